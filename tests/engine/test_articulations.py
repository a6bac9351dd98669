"""Hammer-ons, pull-offs, slides and vibrato on the strings: energy, levels, and that nothing clicks."""

import numpy as np
import pytest
from engine.bench import add, classical, fret_place, on_bench
from engine.meter import CONSTRAINT, JUMP_DOWN, JUMP_UP, LARGEST_ENERGY, LARGEST_ERROR, LOSS, PLUCK, metered_steps
from engine.swap_bench import RATE, energy_above, instance, play

from ukrt.engine import controller_layout as cc
from ukrt.engine import gestures
from ukrt.engine import layout as at
from ukrt.engine import player_layout as player
from ukrt.engine.kernels.energy import total_energy
from ukrt.model.presets import load_preset

LOW_E, D, HIGH_E = 0, 2, 5
ON, OFF, CONTROL, PRESSURE, KEY_PRESSURE, BEND = 0x90, 0x80, 0xB0, 0xD0, 0xA0, 0xE0
LEGATO, GLIDE = (0, CONTROL, cc.LEGATO, 127), (0, CONTROL, cc.GLIDE, 127)
GUITAR = load_preset("classical")


def _scripts(g, s):
    fret = {n: fret_place(g.strings[s], n) for n in (2, 5, 7)}
    pluck = (10, gestures.PLUCK, s, 0.85, 5.0, 0.4, 480)
    stopped = (10, gestures.PRESS, s, fret[5], 240)
    hammer = (4000, gestures.PRESS, s, fret[5], 96, 3.0)
    pull = (4000, gestures.LIFT, s, 0.0, 480, 3.0, 1.1)
    return {
        "hammer on a string at rest": [hammer],
        "hammer on a sounding string": [pluck, hammer],
        "hammer beyond a finger": [stopped, pluck, (4000, gestures.PRESS, s, fret[7], 96, 3.0)],
        "pull off a string at rest": [stopped, pull],
        "pull off a sounding string": [stopped, pluck, pull],
        "pull off while landing": [pluck, hammer, (4040, *pull[1:])],
        "pull off to a finger": [stopped, pluck, pull, (4480, gestures.PRESS, s, fret[2], 96)],
        "hammer while pulling off": [stopped, pluck, pull, (4200, *hammer[1:])],
    }


@pytest.mark.parametrize("s", [LOW_E, HIGH_E])
@pytest.mark.parametrize("name", _scripts(GUITAR, LOW_E))
def test_what_slurs_bring_is_the_work_of_the_finger(name, s):
    """Every sample balances to rounding, changes of ports only take, and no more is there than was put in."""
    d, i = on_bench(classical())
    for frame, kind, _, *numbers in _scripts(GUITAR, s)[name]:
        add(d, i, frame, kind, s, *numbers)
    ledger, saved = np.zeros(8), np.zeros(at.D_SIZE)
    metered_steps(d, i, 8000, ledger, saved)
    put_in = ledger[PLUCK] + ledger[CONSTRAINT]
    assert put_in > 1e-5
    assert ledger[LARGEST_ERROR] < 1e-10 * ledger[LARGEST_ENERGY]
    assert ledger[JUMP_UP] < 1e-7 * put_in
    kept = total_energy(d, i) + ledger[LOSS] - put_in
    assert abs(kept - ledger[JUMP_UP] + ledger[JUMP_DOWN]) < 1e-9 * put_in
    assert kept < 1e-7 * put_in


def _level(messages, start, n=9600):
    """Level of the bridge's force [dB] over ``n`` frames from ``start``."""
    force = play(instance(GUITAR), 0, start + n, messages)[start:, 0]
    return 10.0 * np.log10(np.mean(force**2))


@pytest.mark.parametrize("key", [40, 50, 64])
@pytest.mark.parametrize("velocity", [40, 80, 127])
def test_slurs_are_softer_than_plucks_but_heard(key, velocity):
    """Onto and off a string that was plucked softly: so many dB below the same note plucked."""
    after, begin = 580, 40000  # frames from a note-on until the landing is over
    for frets in (2, 4):
        low, high = (100, ON, key, 1), (100, ON, key + frets, 1)
        plucked = _level([(100, ON, key + frets, velocity)], 100 + after)
        hammered = _level([LEGATO, low, (begin, ON, key + frets, velocity)], begin + after)
        assert -20.0 < hammered - plucked < -6.0
        plucked = _level([(100, ON, key, velocity)], 100 + after)
        pulled = _level([LEGATO, high, (begin, ON, key, velocity)], begin + after)
        assert -20.0 < pulled - plucked < -4.0


def _high(messages, start, stop, hz=5000.0):
    """Largest energy above ``hz`` in 1024 frames, from ``start`` to ``stop``."""
    force = play(instance(GUITAR), 0, stop + 1024, messages)[:, 0]
    return max(energy_above(force[k : k + 1024], hz) for k in range(start, stop, 256))


@pytest.mark.parametrize("low, high", [(48, 50), (48, 52), (67, 69)])
def test_a_slide_is_as_clean_as_one_ten_times_slower(low, high):
    """In 92 ms and in 0.9 s: what is above 5 kHz as the finger sets out and arrives; -50 dB re all do not count."""
    loud = {}
    whole = _high([(100, ON, low, 100)], 20000, 24000, 20.0)
    for value in (34, 103):
        messages = [GLIDE, (0, CONTROL, cc.GLIDE_TIME, value), (100, ON, low, 100), (20000, ON, high, 100)]
        loud[value] = _high(messages, 20000, 24000)
    assert loud[34] < 4.0 * loud[103] + 1e-5 * whole


def _pitch(force, start, n=2400):
    """Frequency of the fundamental [Hz] around ``start``, from the phase it turns by."""
    tone = np.exp(-2j * np.pi * 196.0 / RATE * np.arange(start - n, start + n))
    turned = force[start - n : start + n] * tone
    early, late = (np.sum(turned[k : k + n] * np.hanning(n)) for k in (0, n))
    return 196.0 + np.angle(late / early) * RATE / n / (2.0 * np.pi)


def _sway(messages, n=120000):
    force = play(instance(GUITAR), 0, n, messages)[:, 0]
    times = np.arange(12000, n - 4000, 480)
    hz = np.array([_pitch(force, k) for k in times])
    return times, 1200.0 * np.log2(hz / 196.0)


@pytest.mark.parametrize("how", ["wheel", "pressure", "key pressure"])
def test_vibrato_sways_the_pitch_at_its_rate_and_comes_back(how):
    """G3 on its string: 5 Hz, 25 cents (a window of 50 ms sees 0.9 of it); afterwards the pitch that was before."""
    start = {
        "wheel": (20000, CONTROL, cc.WHEEL, 127),
        "pressure": (20000, PRESSURE, 127, 0),
        "key pressure": (20000, KEY_PRESSURE, 55, 127),
    }[how]
    stop = (80000, *start[1:3], 0) if how != "pressure" else (80000, PRESSURE, 0, 0)
    _, plain = _sway([(100, ON, 55, 100)])
    times, cents = _sway([(100, ON, 55, 100), start, stop])
    sway = cents - plain
    assert np.abs(sway[times < 17500]).max() < 0.01 and np.abs(sway[times > 92000]).max() < 0.5
    full = sway[(times > 32000) & (times < 76000)]
    assert 19.0 < full.max() < 26.0 and -26.0 < full.min() < -19.0
    phases = np.exp(-2j * np.pi * 5.0 * np.arange(len(full)) * 0.01)
    assert 2.0 * abs(np.mean(full[:80] * phases[:80])) > 0.9 * full.max(), "not at 5 Hz"


def test_vibrato_is_around_the_bend_and_leaves_the_tension_where_the_bend_wants_it():
    one = instance(GUITAR)
    messages = [
        (100, ON, 55, 100),
        (10000, CONTROL, cc.WHEEL, 127),
        (30000, BEND, 0, 96),
        (60000, CONTROL, cc.WHEEL, 0),
    ]
    play(one, 0, 50000, messages)
    s = 3
    ratio = one.d[at.STRING + s * at.STRING_D_SIZE + at.S_RATIO]
    assert abs(600.0 * np.log2(ratio) - 100.0) < 26.0
    play(one, 50000, 40000, messages)
    assert one.d[at.STRING + s * at.STRING_D_SIZE + at.S_RATIO] == 2.0 ** (100.0 / 600.0)
    assert one.d[player.D_DEPTH + s] == 0.0


@pytest.mark.parametrize("key", [55, 45, 47, 69])
def test_vibrato_does_not_click(key):
    """Above 5 kHz, while an open or a stopped string sways and as it begins and ends: below -70 dB of the whole."""
    notes = [(100, ON, key, 100)]
    whole = _high(notes, 24000, 60000, 20.0)
    plain = _high(notes, 24000, 60000)
    sways = _high([*notes, (24000, CONTROL, cc.WHEEL, 127), (44000, CONTROL, cc.WHEEL, 0)], 24000, 60000)
    assert sways < 1.5 * plain + 1e-7 * whole


def test_blocks_of_any_size_give_the_same_bits():
    messages = [
        LEGATO,
        (100, ON, 45, 100),
        (5000, CONTROL, cc.WHEEL, 90),
        (9000, ON, 47, 90),
        (14001, ON, 45, 90),
        (15000, CONTROL, cc.GLIDE, 127),
        (16000, ON, 46, 90),
        (21003, ON, 48, 90),
    ]
    whole = play(instance(GUITAR), 0, 30000, messages)
    one, parts, now = instance(GUITAR), [], 0
    for n in (1, 37, 64, 500, 8407, 130, 5000, 8000, 7861):
        parts.append(play(one, now, n, messages))
        now += n
    assert np.array_equal(np.concatenate(parts), whole)
