"""Slurs, slides, vibrato, harmonics and muting on the strings: energy, levels, and that nothing clicks."""

from dataclasses import replace

import numpy as np
import pytest
from engine.balance import check_balance
from engine.bench import classical, fret_place
from engine.swap_bench import RATE, check_blocks, energy_above, instance, play, sound_through_a_swap

from ukrt.engine import controller_layout as cc
from ukrt.engine import gestures
from ukrt.engine import layout as at
from ukrt.engine import player_layout as player
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
    touch = (4000, gestures.TOUCH, s, 0.95, 96, 4.0)
    return {
        "hammer on a string at rest": [hammer],
        "hammer on a sounding string": [pluck, hammer],
        "hammer beyond a finger": [stopped, pluck, (4000, gestures.PRESS, s, fret[7], 96, 3.0)],
        "pull off a string at rest": [stopped, pull],
        "pull off a sounding string": [stopped, pluck, pull],
        "pull off while landing": [pluck, hammer, (4040, *pull[1:])],
        "pull off to a finger": [stopped, pluck, pull, (4480, gestures.PRESS, s, fret[2], 96)],
        "pluck that lets go softly": [(5, gestures.RELEASE, s, 0.0, 144), pluck],
        "touch a sounding string": [pluck, touch, (6000, gestures.TOUCH, s, 0.0, 240, 0.0)],
        "touch, then damp": [
            stopped,
            pluck,
            touch,
            (5000, gestures.DAMP, s, 1.0, 240),
            (7000, gestures.TOUCH, s, 0.9, 96, 2.0),
        ],
        "touch elsewhere": [pluck, touch, (5000, gestures.TOUCH, s, 0.3, 96, 0.5)],
        "hammer while pulling off": [stopped, pluck, pull, (4200, *hammer[1:])],
    }


@pytest.mark.parametrize("s", [LOW_E, HIGH_E])
@pytest.mark.parametrize("name", _scripts(GUITAR, LOW_E))
def test_what_hands_bring_is_their_work(name, s):
    """Every sample balances to rounding, changes of ports only take, and no more is there than was put in.

    Pseudo-modes that are made anew just after a kink was let go, when they move most, weigh its velocity a little anew.
    """
    check_balance(classical(), s, _scripts(GUITAR, s)[name], 8000)


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
    """Above 5 kHz, while an open or a stopped string sways and as it begins and ends: below -67 dB of the whole."""
    notes = [(100, ON, key, 100)]
    whole = _high(notes, 24000, 60000, 20.0)
    plain = _high(notes, 24000, 60000)
    sways = _high([*notes, (24000, CONTROL, cc.WHEEL, 127), (44000, CONTROL, cc.WHEEL, 0)], 24000, 60000)
    assert sways < 1.5 * plain + 2e-7 * whole


def _partials(messages, hz, start, n=24000):
    """Levels [dB] of the first eight partials of ``hz`` in the bridge's force."""
    force = play(instance(GUITAR), 0, start + n, messages)[start:, 0]
    spectrum = np.abs(np.fft.rfft(force * np.hanning(n), 4 * n))
    places = np.fft.rfftfreq(4 * n, 1.0 / RATE) / hz
    return np.array([20.0 * np.log10(spectrum[abs(places / k - 1.0) < 0.03].max()) for k in range(1, 9)])


@pytest.mark.parametrize(
    "key, stopped, partial", [(52, 40, 2), (59, 40, 3), (64, 45, 3), (79, 55, 4), (73, 45, 5), (69, 57, 2)]
)
def test_a_harmonic_has_its_partials_and_no_others(key, stopped, partial):
    """0.1 s after the release: its own partial within 8 dB of the plain note's, all that lie off its nodes gone."""
    hz, begin = 440.0 * 2.0 ** ((stopped - 69) / 12), 100 + 480 + 4800
    plain = _partials([(100, ON, stopped, 100)], hz, begin)
    touched = _partials([(0, CONTROL, cc.HARMONIC, 127), (100, ON, key, 100)], hz, begin)
    off = np.arange(1, 9) % partial != 0
    assert np.all(touched[off & (plain > plain.max() - 25.0)] < touched[partial - 1] - 24.0)
    assert abs(touched[partial - 1] - plain[partial - 1]) < 8.0


def test_muting_shortens_the_note_the_more_it_is():
    after = [_level([(0, CONTROL, cc.MUTE, value), (100, ON, 40, 100)], 580 + 9600, 2400) for value in (0, 1, 64, 127)]
    begun = [_level([(0, CONTROL, cc.MUTE, value), (100, ON, 40, 100)], 580, 2400) for value in (0, 1, 64, 127)]
    assert np.all(np.diff(after) < -4.0) and after[3] < after[0] - 25.0
    assert begun[0] - 8.0 < begun[3] < begun[0]


def _pluck_spectrum(hz, release):
    """Size of the spectrum of a force that rises for 10 ms and falls along half a cosine [s] to nothing, in N s."""
    t = (np.arange(200000) + 0.5) * 1e-7
    falls = 0.5 + 0.5 * np.cos(np.pi * (t - 0.01) / release) if release > 0.0 else 0.0
    force = np.where(t < 0.01, t / 0.01, np.where(t < 0.01 + release, falls, 0.0))
    return np.abs(np.exp(-2j * np.pi * np.outer(hz, t)) @ force) * 1e-7


@pytest.mark.parametrize("value", [40, 80, 127])
def test_a_soft_fingertip_leaves_out_what_is_quicker_than_it_slips(value):
    """Every partial moves as much as the force had of its frequency."""
    note, hz = (100, ON, 45, 100), 110.0 * np.arange(1, 9)
    cut, soft = (_partials([(0, CONTROL, cc.FLESH, v), note], 110.0, 1000) for v in (0, value))
    release = value * round(GUITAR.articulation.flesh_time * RATE) // 127 / RATE
    wanted = 20.0 * np.log10(_pluck_spectrum(hz, release) / _pluck_spectrum(hz, 0.0))
    clear = wanted > -15.0  # not near a zero of it, where the partials' own places would count
    assert clear.sum() >= 3
    assert soft[clear] - cut[clear] == pytest.approx(wanted[clear], abs=0.7)


@pytest.mark.parametrize("key", [59, 64, 60])
def test_the_finger_leaves_a_node_without_a_click(key):
    """In 5 ms: above 5 kHz no more than when it leaves ten times slower, but for -70 dB of the whole."""
    loud, messages = {}, [(0, CONTROL, cc.HARMONIC, 127), (100, ON, key, 100)]
    leaves = 100 + 480 + round(GUITAR.articulation.touch_time * RATE)
    for time in (0.005, 0.05):
        guitar = replace(GUITAR, damper=replace(GUITAR.damper, release_time=time))
        force = play(instance(guitar), 0, leaves + 5000, messages)[:, 0]
        loud[time] = [
            max(energy_above(force[k : k + 1024], hz) for k in range(leaves - 512, leaves + 3000, 256))
            for hz in (5000, 20)
        ]
    assert loud[0.005][0] < 1.5 * loud[0.05][0] + 1e-7 * loud[0.05][1]


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
        (21100, CONTROL, cc.HARMONIC, 127),
        (21200, ON, 64, 90),
        (21300, CONTROL, cc.HARMONIC, 0),
        (21300, CONTROL, cc.MUTE, 50),
        (21400, ON, 59, 90),
    ]
    check_blocks(GUITAR, messages)


def _any_messages(rng, count):
    """Messages of every kind in three channels, most of them notes and what these are played by."""
    frame = 0
    controllers = (1, 5, 6, 16, 17, 17, 18, 19, 20, 21, 64, 65, 65, 68, 68, 68, 74, 100, 101, 120, 121, 123)
    for _ in range(count):
        frame += int(rng.choice((0, 1, 63, 300, 481, 2000)))
        kind = int(rng.choice((ON, ON, ON, OFF, OFF, CONTROL, CONTROL, PRESSURE, KEY_PRESSURE, BEND)))
        first, second = (int(value) for value in rng.integers(0, 128, 2))
        if kind in (ON, OFF, KEY_PRESSURE):
            first = int(rng.integers(38, 90))
        elif kind == CONTROL:
            first = int(rng.choice(controllers))
        yield frame, kind | int(rng.integers(3)), first, second


@pytest.mark.parametrize("seed", range(3))
def test_any_messages_are_played_and_then_all_is_silent(seed):
    """Nothing that is no number, nothing loud beyond reason, no stuck note, and silence; a swap in their midst, too."""
    one, other = instance(GUITAR), instance(load_preset("drop-d"))
    messages = list(_any_messages(np.random.default_rng(seed), 500))
    sound_through_a_swap(one, other, messages, 3)
