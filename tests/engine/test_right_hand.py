"""Attack, planting, strums and variations on the strings: energy, spectra, that nothing clicks and nothing is lost."""

from dataclasses import replace

import numpy as np
import pytest
from engine.balance import check_balance
from engine.bench import add, classical
from engine.swap_bench import (
    RATE,
    check_blocks,
    counters,
    energy_above,
    instance,
    note_log,
    play,
    sound_through_a_swap,
    swap,
)

from ukrt.engine import controller_layout as cc
from ukrt.engine import gestures, layout
from ukrt.engine import player_layout as at
from ukrt.model.presets import load_preset
from ukrt.playing.rules import attack_times, strum_times

ON, OFF, CONTROL = 0x90, 0x80, 0xB0
GUITAR = load_preset("classical")
SMOOTH = replace(GUITAR, pluck=replace(GUITAR.pluck, shape="smooth"))
CHORD = (40, 47, 52, 56, 59, 64)  # open strings and first position: E major, one note on each string


def _scripts(s):
    pluck = (10, gestures.PLUCK, s, 0.85, 5.0, 0.4, 480)
    land, leave = (4000, gestures.TOUCH, s, 0.845, 96, 2.0), (4384, gestures.TOUCH, s, 0.0, 96, 0.0)
    again = (4000, gestures.PLUCK, s, 0.85, 5.0, 0.4, 480)
    return {
        "planted pluck of a sounding string": [pluck, land, again, leave],
        "planted pluck that pulls late": [pluck, land, (4456, *again[1:6], 24), leave],
        "snap of a plectrum": [(466, *pluck[1:6], 24)],
    }


@pytest.mark.parametrize("shape", ["linear", "smooth"])
@pytest.mark.parametrize("s", [0, 5])
@pytest.mark.parametrize("name", _scripts(0))
def test_what_the_right_hand_brings_is_its_work(name, s, shape):
    """Every sample balances to rounding, changes of ports only take, and no more is there than was put in.

    A port that is made while the string moves fast weighs the pseudo-modes' velocity a little anew (2e-5 of all).
    """
    guitar = replace(classical(), pluck=replace(GUITAR.pluck, shape=shape))
    jump_up = 2e-5 if name == "planted pluck that pulls late" else 1e-6
    check_balance(guitar, s, _scripts(s)[name], 6000, jump_up)


def _partials(guitar, messages, hz, start=1000, n=24000):
    """Levels [dB] of the first eight partials of ``hz`` in the bridge's force."""
    force = play(instance(guitar), 0, start + n, messages)[start:, 0]
    spectrum = np.abs(np.fft.rfft(force * np.hanning(n), 4 * n))
    places = np.fft.rfftfreq(4 * n, 1.0 / RATE) / hz
    return np.array([20.0 * np.log10(spectrum[abs(places / k - 1.0) < 0.03].max()) for k in range(1, 9)])


def _force_spectrum(hz, pull, smooth):
    """Size of the spectrum [N s] of a force that rises for ``pull`` seconds and is then gone, by its integral."""
    t = (np.arange(100000) + 0.5) / 100000
    force = 0.5 - 0.5 * np.cos(np.pi * t) if smooth else t
    return np.abs(np.exp(-2j * np.pi * np.outer(hz, pull * t)) @ force) * pull / 100000


@pytest.mark.parametrize("value, smooth", [(0, False), (20, False), (45, False), (64, True), (20, True)])
def test_every_partial_moves_as_much_as_the_pull_had_of_its_frequency(value, smooth):
    note, hz = (100, ON, 45, 60), 110.0 * np.arange(1, 9)
    plain = _partials(GUITAR, [note], 110.0)
    other = _partials(SMOOTH if smooth else GUITAR, [(0, CONTROL, cc.ATTACK, value), note], 110.0)
    pull = round(attack_times(GUITAR.pluck)[value] * RATE) / RATE
    usual = _force_spectrum(hz, GUITAR.pluck.duration, False)
    wanted = 20.0 * np.log10(_force_spectrum(hz, pull, smooth) / usual)
    assert other - plain == pytest.approx(wanted, abs=0.7)


def _after_touch(s, resistance, ramp):
    """Force on the bridge of a string that is plucked, then touched for 8 ms beside the place of the pluck."""
    one = instance(GUITAR)
    add(one.d, one.i, 10, gestures.PLUCK, s, 0.85, 3.0, 0.4, 480)
    if resistance > 0.0:
        add(one.d, one.i, 9600, gestures.TOUCH, s, 0.845, ramp, resistance)
        add(one.d, one.i, 9600 + 480 - 96, gestures.TOUCH, s, 0.0, 96, 0.0)
    return play(one, 0, 14000)[:, 0]


@pytest.mark.parametrize("s", [0, 3, 5])
def test_a_planted_finger_takes_from_the_former_note(s):
    """The more firmly, the more."""
    levels = []
    for resistance in (0.0, 0.2, 0.7, 2.0):
        force = _after_touch(s, resistance, 96)
        levels.append(10.0 * np.log10(np.mean(force[10200:12600] ** 2)))
    assert np.all(np.diff(levels) < -0.5) and levels[-1] < levels[0] - 3.0


@pytest.mark.parametrize("s", [0, 3, 4, 5])
def test_a_finger_is_planted_without_a_click(s):
    """On a sounding string, before its pluck: above 5 kHz no more than of a landing ten times slower, -60 dB apart."""
    loud = {}
    for ramp in (96, 960):
        force = _after_touch(s, 2.0, ramp)[9600 - 1024 : 9600 + 380]
        loud[ramp] = [
            max(energy_above(force[k : k + 512], hz) for k in range(0, len(force) - 511, 64)) for hz in (5000, 20)
        ]
    assert loud[96][0] < 1.5 * loud[960][0] + 1e-6 * loud[960][1]


def test_muting_lasts_when_the_damper_that_was_there_leaves():
    """A muted note on a string that has just been damped is as muted as on one at rest."""
    muted, note = (0, CONTROL, cc.MUTE, 127), (100, ON, 40, 100)
    later = [muted, note, (9600, OFF, 40, 0), (13000, ON, 40, 100)]
    first = play(instance(GUITAR), 0, 20000, [muted, note])[:, 0]
    second = play(instance(GUITAR), 0, 20000 + 12900, later)[12900:, 0]
    levels = [10.0 * np.log10(np.mean(force[10000:15000] ** 2)) for force in (first, second)]
    assert abs(levels[1] - levels[0]) < 1.0


def test_a_presets_muting_is_the_controllers():
    preset = load_preset("classical", {"articulation.muting": 1.0, "articulation.flesh": 1.0})
    notes = [(100, ON, 40, 100), (9000, ON, 47, 100)]
    sent = [(0, CONTROL, cc.MUTE, 127), (0, CONTROL, cc.FLESH, 127), *notes]
    assert np.array_equal(play(instance(preset), 0, 15000, notes), play(instance(GUITAR), 0, 15000, sent))
    off = [(0, CONTROL, cc.MUTE, 0), (0, CONTROL, cc.FLESH, 0), *notes]
    assert np.array_equal(play(instance(preset), 0, 15000, off), play(instance(GUITAR), 0, 15000, notes))


def test_blocks_of_any_size_give_the_same_bits():
    messages = [(0, CONTROL, cc.VARIATION, 127), (0, CONTROL, cc.ATTACK, 20), (0, CONTROL, cc.PLANTING, 100)]
    messages += [(100 + 3001 * k, ON, key, 80) for k, key in enumerate((45, 64, 59, 64))]
    messages += [(13000, CONTROL, cc.STRUM, 100), *((13001, ON, key, 90) for key in CHORD)]
    messages += [(14000, OFF, 64, 0), (16000, ON, 67, 90)]
    check_blocks(GUITAR, messages)


@pytest.mark.parametrize("preset, rate", [("drop-d", RATE), ("classical", 96000.0), ("ukulele", RATE)])
def test_a_strum_goes_on_over_another_guitars_strings(preset, rate):
    """What was still to come comes at its time, on the strings that there are."""
    one, other = instance(GUITAR), instance(load_preset(preset), rate)
    sweep = int(round(strum_times()[127] * RATE))
    messages = [(0, CONTROL, cc.STRUM, 127), *((100, ON, key, 90) for key in CHORD)]
    play(one, 0, 5000, messages)
    swap(one, other, 5000)
    left = [(100 + sweep * s // 5, s) for s in range(2, min(6, len(other.guitar.strings)))]
    waiting = {}
    for k in range(other.i[layout.H_GESTURES]):
        frame, kind, s = (int(v) for v in other.i[layout.GESTURES_I + 3 * k :][:3])
        if kind == gestures.PLUCK:
            waiting[s] = frame
    pace = rate / RATE
    assert waiting == {s: 5000 + round((frame - 5000) * pace) for frame, s in left}
    assert all(other.i[at.S_PLUCK + s] == frame for s, frame in waiting.items())
    play(other, 5000, 48000)
    assert counters(other)["gestures_refused"] == 0
    assert not any(other.i[layout.GESTURES_I + 3 * k + 1] == gestures.PLUCK for k in range(other.i[layout.H_GESTURES]))


def _any_messages(rng, count):
    """Notes, and whatever the right hand is told by, in two channels."""
    frame = 0
    controllers = (16, 17, 18, 19, 22, 22, 23, 23, 23, 24, 24, 25, 26, 26, 64, 65, 68, 74, 120, 121, 123)
    for _ in range(count):
        frame += int(rng.choice((0, 0, 1, 63, 300, 481, 2000, 9000)))
        kind = int(rng.choice((ON, ON, ON, OFF, OFF, CONTROL)))
        first, second = (int(value) for value in rng.integers(0, 128, 2))
        first = int(rng.choice(controllers)) if kind == CONTROL else int(rng.integers(38, 90))
        yield frame, kind | int(rng.integers(2)), first, second


@pytest.mark.parametrize("seed", range(2))
def test_any_messages_are_played_and_then_all_is_silent(seed):
    """Nothing that is no number, no stuck note or touch, and silence; a swap to another sample rate in their midst."""
    one, other = instance(GUITAR), instance(load_preset("drop-d"), 44100.0)
    messages = list(_any_messages(np.random.default_rng(seed), 400))
    sound_through_a_swap(one, other, messages, 2)
    assert all(other.d[layout.STRING + s * layout.STRING_D_SIZE + layout.S_TOUCH_PLACE] == 0.0 for s in range(6))
    assert len(note_log(other)) > 100
