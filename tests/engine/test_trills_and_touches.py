"""Trills, muting and half lifts while notes sound, glissandi over frets: energy, levels, and that nothing clicks."""

import numpy as np
import pytest
from engine.balance import check_balance
from engine.bench import classical, fret_place
from engine.swap_bench import RATE, counters, energy_above, instance, note_log, play, swap

from ukrt.engine import controller_layout as cc
from ukrt.engine import gestures
from ukrt.engine import player_layout as player
from ukrt.model.presets import load_preset

LOW_E, HIGH_E = 0, 5
ON, OFF, CONTROL = 0x90, 0x80, 0xB0
GUITAR = load_preset("classical")


def _scripts(g, s):
    fret = {n: fret_place(g.strings[s], n) for n in (3, 4, 5, 6, 7)}
    behind = (fret[5] + player.LOOSE_OFFSET) / g.strings[s].length
    stopped, pluck = (10, gestures.PRESS, s, fret[5], 240), (10, gestures.PLUCK, s, 0.85, 5.0, 0.4, 480)
    loosen = [(3000, gestures.LIFT, s, 0.0, 960), (3000, gestures.TOUCH, s, behind, 960, 20.0)]
    tighten = [(6000, gestures.TOUCH, s, behind, 960, 0.0), (6000, gestures.PRESS, s, fret[5], 240)]
    up, down = (
        [(3000 + 700 * k, gestures.PRESS, s, fret[n], 480) for k, n in enumerate(way)] for way in ((6, 7), (4, 3))
    )
    return {
        "half lift": [stopped, pluck, *loosen],
        "half lift and back": [stopped, pluck, *loosen, *tighten],
        "half lift to the utmost, then harder": [
            stopped, pluck, loosen[0], (3000, gestures.TOUCH, s, behind, 960, 2.0),
            (4000, gestures.TOUCH, s, behind, 960, 100.0)],
        "half lift while a hand mutes": [stopped, pluck, (2000, gestures.TOUCH, s, 0.95, 960, 4.0), *loosen],
        "glissando up": [stopped, pluck, *up],
        "glissando down": [stopped, pluck, *down],
        "half lift within a glissando": [stopped, pluck, up[0], *[(3200, *one[1:]) for one in loosen]],
    }  # fmt: skip


@pytest.mark.parametrize("s", [LOW_E, HIGH_E])
@pytest.mark.parametrize("name", _scripts(GUITAR, LOW_E))
def test_what_the_left_hand_brings_is_its_work(name, s):
    """Every sample balances to rounding, changes of ports only take, and no more is there than was put in."""
    check_balance(classical(), s, _scripts(GUITAR, s)[name], 8000)


def _force(messages, n, slowly=False):
    """The bridge's force; ``slowly``: with fingers and hands ten times slower while notes sound."""
    one = instance(GUITAR)
    for row in (player.I_EASE_RAMP, player.I_LANDING) if slowly else ():
        one.i[row] *= 10
    return play(one, 0, n, messages)[:, 0]


def _high(force, start, stop, hz=5000.0):
    """Largest energy above ``hz`` in 1024 frames."""
    return max(energy_above(force[k : k + 1024], hz) for k in range(start, stop, 256))


_CHANGES = {
    "the hand comes": [(14400, CONTROL, cc.MUTE, 127)],
    "the hand leaves": [(0, CONTROL, cc.MUTE, 20), (14400, CONTROL, cc.MUTE, 0)],
    "the finger loosens a little": [(14400, CONTROL, cc.LOOSE, 1)],
    "the finger loosens": [(14400, CONTROL, cc.LOOSE, 127)],
    "the finger presses again": [(7000, CONTROL, cc.LOOSE, 20), (14400, CONTROL, cc.LOOSE, 0)],
}


@pytest.mark.parametrize("key", [40, 48, 67])
@pytest.mark.parametrize("change", _CHANGES)
def test_what_comes_to_touch_a_sounding_string_does_not_click(change, key):
    """Above 5 kHz: no more than ten times slower, but for -50 dB of the whole."""
    messages = [(100, ON, key, 100), *_CHANGES[change]]
    whole = _high(_force(messages[:1], 26000), 14400, 24000, 20.0)
    quick, slow = (_high(_force(messages, 26000, slowly), 14400, 24000) for slowly in (False, True))
    assert quick < 1.5 * slow + 1e-5 * whole


@pytest.mark.parametrize("first, last", [(48, 55), (54, 47), (67, 74), (41, 46)])
def test_a_glissando_over_frets_does_not_click(first, last):
    """Above 5 kHz from step to step: no more than 4 times what ten times slower, but for -45 dB of the whole."""
    glide = [
        (0, CONTROL, controller, value) for controller, value in ((cc.GLIDE, 127), (cc.FRETS, 127), (cc.STRING, 0))
    ]
    messages = [*glide, (0, CONTROL, cc.GLIDE_TIME, 100), (100, ON, first, 100), (12000, ON, last, 100)]
    whole = _high(_force(messages[-2:-1], 26000), 12300, 24000, 20.0)
    quick, slow = (_high(_force(messages, 60000, slowly), 12300, 50000) for slowly in (False, True))
    assert quick < 4.0 * slow + 3e-5 * whole


def _pitch(force, near):
    """Frequency of the partial nearest to ``near`` [Hz], from 4096 frames, by the peak of a parabola."""
    n = 16 * len(force)
    level = np.log(np.abs(np.fft.rfft(force * np.hanning(len(force)), n)) + 1e-30)
    k = round(near * n / RATE) + np.arange(-35, 36)
    top = k[np.argmax(level[k])]
    a, b, c = level[top - 1 : top + 2]
    return (top + 0.5 * (a - c) / (a - 2.0 * b + c)) * RATE / n


def test_a_glissando_sounds_every_fret():
    """Two seconds over five frets: 0.4 s each, every one in tune to 5 cents; a free slide is between them."""
    cents = {}
    for frets in (127, 0):
        messages = [(0, CONTROL, cc.GLIDE, 127), (0, CONTROL, cc.FRETS, frets), (0, CONTROL, cc.GLIDE_TIME, 127)]
        force = _force([*messages, (100, ON, 65, 110), (9600, ON, 70, 110)], 9600 + 98000)
        wanted = 440.0 * 2.0 ** ((65 + np.arange(1, 6) - 69) / 12)
        starts = 9600 + 480 + 19200 * np.arange(5) + 8000
        found = [_pitch(force[k : k + 9600], hz) for k, hz in zip(starts, wanted, strict=True)]
        cents[frets] = 1200.0 * np.log2(np.array(found) / wanted)
    assert np.abs(cents[127]).max() < 5.0 < np.abs(cents[0]).max()


def _level(force, start, n=1200):
    return 10.0 * np.log10(np.mean(force[start : start + n] ** 2))


def test_a_half_lift_damps_the_more_the_further_it_goes():
    note = (100, ON, 48, 100)
    levels = np.array([_level(_force([note, (9600, CONTROL, cc.LOOSE, v)], 18000), 16000) for v in (0, 1, 32, 64, 127)])
    assert np.all(np.diff(levels) < -2.0) and levels[-1] < levels[0] - 20.0
    assert _level(_force([(100, ON, 45, 100), (9600, CONTROL, cc.LOOSE, 127)], 18000), 16000) > levels[0] - 6.0


def test_a_quick_release_ends_a_note_sooner():
    levels = [_level(_force([(100, ON, 45, 100), (9600, OFF, 45, v)], 14000), 10300, 300) for v in (1, 64, 127)]
    assert levels[0] > levels[1] + 1.0 > levels[2] + 2.0
    same = [_force([(100, ON, 45, 100), (9600, OFF, 45, v)], 14000) for v in (0, 64)]
    assert np.array_equal(*same)


def test_a_trill_goes_on_and_swells_no_further():
    """Hammer-ons and pull-offs by one held key: each is heard, the energy stays about that of the first ones."""
    messages = [(0, CONTROL, cc.LEGATO, 127), (100, ON, 45, 100)]
    for k in range(12):
        messages += [(9600 + 4800 * k, ON, 47, 100), (12000 + 4800 * k, OFF, 47, 64)]
    one = instance(GUITAR)
    force = play(one, 0, 70000, messages)[:, 0]
    assert counters(one)["notes_resumed"] == 12
    levels = np.array([_level(force, 12600 + 2400 * k, 2000) for k in range(23)])
    assert np.ptp(levels[6:]) < 8.0 and abs(levels[-4:].mean() - levels[6:10].mean()) < 3.0
    assert {note["fret"] for note in note_log(one)} == {0, 2}


def _any_left_hand(rng, count):
    frame = 0
    numbers = (1, 5, 17, 19, 19, 20, 27, 27, 27, 28, 64, 65, 65, 68, 121)
    for _ in range(count):
        if rng.random() < 0.2:
            yield frame, CONTROL, cc.LEGATO, 127
            for kind, key in ((ON, 45), (ON, 47), (OFF, 47)):
                yield frame, kind, key, 90
                frame += int(rng.choice((300, 2000)))
        frame += int(rng.choice((0, 1, 63, 300, 481, 2000, 6000)))
        kind = int(rng.choice((ON, ON, OFF, OFF, CONTROL)))
        first = int(rng.choice(numbers)) if kind == CONTROL else int(rng.choice((45, 46, 47, 48, 49, 62, 64, 65)))
        yield frame, kind | int(rng.integers(2)), first, int(rng.choice((0, 1, 50, 64, 127)))


@pytest.mark.parametrize("seed", range(2))
def test_the_left_hand_goes_on_across_a_swap_and_then_rests(seed):
    """The same guitar swapped in changes no decision; in the end all is silent, and no key is remembered."""
    messages = [(0, CONTROL, cc.LEGATO, 127), *_any_left_hand(np.random.default_rng(seed), 250)]
    end = messages[-1][0] + 1000
    for channel in range(2):
        messages += [(end, CONTROL | channel, cc.PEDAL, 0), (end, CONTROL | channel, cc.NOTES_OFF, 0)]
    plain, one, other = (instance(GUITAR) for _ in range(3))
    whole = play(plain, 0, end + 240000, messages)[:, 0]
    half = end // 2
    first = play(one, 0, half, messages)[:, 0]
    assert np.array_equal(first, whole[:half])
    swap(one, other, half)
    second = play(other, half, end + 240000 - half, messages)[:, 0]
    assert counters(plain) == counters(other) and note_log(plain) == note_log(other)
    assert counters(plain)["notes_resumed"] > 5 and counters(plain)["gestures_refused"] == 0
    for sound in (whole, second):
        assert np.abs(sound).max() < 400.0 and np.mean(sound[-4800:] ** 2) < 1e-5 * np.mean(whole[:end] ** 2)
    assert (
        not other.i[player.S_STATE : player.S_STATE + 6].any()
        and not other.i[player.S_HOLDS : player.S_HOLDS + 6].any()
    )
