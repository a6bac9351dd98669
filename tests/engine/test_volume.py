"""Volume, expression and master volume: what they do to the sound, in dB; and a note retuned by SysEx, as it sounds."""

import math

import numpy as np
import pytest
from engine import sysex
from measure.poles_from_signal import note_pitch_cents

from ukrt.engine.engine import Engine
from ukrt.model.presets import load_preset

RATE = 48000
GUITAR = load_preset("classical")
NOTES = [(0, 0x90, 45, 100), (0, 0x90, 64, 80), (9000, 0x90, 60, 90)]
RAMP = 480  # frames: 10 ms
SETTLED = 2000


def play(messages, frames=14_000, block=512, signal="pressure"):
    """Samples (frames, channels) of an engine that is sent (frame, status, data1, data2) in order."""
    engine = Engine(GUITAR, float(RATE), signal=signal)
    for message in sorted(messages, key=lambda one: one[0]):
        assert engine.send(*message)
    sound = np.concatenate([engine.process(min(block, frames - at)) for at in range(0, frames, block)])
    engine.close()
    return sound


@pytest.fixture(scope="module")
def plain():
    return play(NOTES)


def pieces(frame, whole):
    return [(frame, *piece) for piece in sysex.messages(whole)]


def cc(frame, number, value, channel=0):
    return (frame, 0xB0 | channel, number, value)


@pytest.mark.parametrize("value", [0, 1, 20, 64, 99, 127])
def test_the_curves_in_db(plain, value):
    """40 log10(v / 100), 40 log10(v / 127), 40 log10(v / 16383): every sample is scaled by exactly that."""
    master = value * 129
    for messages, ratio in (
        ([cc(0, 7, value)], value / 100),
        ([cc(0, 11, value, 5)], value / 127),
        (pieces(0, sysex.master_volume(master)), master / 16383),
        (
            [cc(0, 7, value), cc(0, 11, 50), *pieces(0, sysex.master_volume(9000))],
            value / 100 * 50 / 127 * 9000 / 16383,
        ),
    ):
        sound = play(NOTES + messages)[SETTLED:]
        gain = 10 ** (40 * math.log10(ratio) / 20) if ratio else 0.0
        np.testing.assert_allclose(sound, gain * plain[SETTLED:], rtol=1e-12)


def test_what_is_full_leaves_the_bits_alone(plain):
    full = [cc(0, 7, 100), cc(0, 11, 127), *pieces(0, sysex.master_volume(16383)), cc(500, 121, 0)]
    np.testing.assert_array_equal(play(NOTES + full), plain)
    back = play([*NOTES, cc(1000, 7, 30), cc(3000, 7, 100)])
    np.testing.assert_array_equal(back[3000 + RAMP :], plain[3000 + RAMP :])


def test_the_last_value_of_any_channel_counts_and_121_brings_full_expression(plain):
    messages = [cc(0, 7, 50, 1), cc(0, 11, 20, 2), cc(100, 7, 80, 3), cc(200, 121, 0, 4), cc(300, 7, 3, 9)]
    np.testing.assert_allclose(play(NOTES + messages)[SETTLED:], 0.64 * plain[SETTLED:], rtol=1e-12)


def test_the_gain_moves_along_straight_lines_and_is_there_when_the_note_is_let_go(plain):
    sound = play([*NOTES, cc(5000, 7, 50), cc(5200, 7, 120), cc(8000, 11, 0)])
    gain = np.ones(len(sound))
    gain[5000:5200] += np.arange(1, 201) * (0.25 - 1.0) / RAMP
    gain[5200 : 5200 + RAMP] = gain[5199] + np.arange(1, RAMP + 1) * (1.44 - gain[5199]) / RAMP
    gain[5200 + RAMP :] = 1.44
    gain[8000 : 8000 + RAMP] = 1.44 * (1.0 - np.arange(1, RAMP + 1) / RAMP)
    gain[8000 + RAMP :] = 0.0
    np.testing.assert_allclose(sound, gain[:, None] * plain, rtol=1e-9, atol=1e-12 * np.abs(plain).max())
    assert not sound[8000 + RAMP :].any()


def test_a_moving_fader_leaves_no_zipper():
    """127 steps of expression in 0.2 s of a ringing note: above 12 kHz they bring 50 dB less than if taken at once."""
    steps = [cc(20_000 + 76 * k, 11, 127 - k) for k in range(127)]
    sound, still = play(NOTES[:1] + steps, 31_000), play(NOTES[:1], 31_000)
    stairs = np.ones(len(still))
    for frame, _, _, value in steps:
        stairs[frame:] = (value / 127) ** 2
    window = slice(19_900, 30_500)
    moved, jumped = (_energy_above(one[window, 0], 12_000.0) for one in (sound, stairs[:, None] * still))
    assert moved < 1e-5 * jumped


def _energy_above(signal, hz):
    spectrum = np.fft.rfft(signal * np.blackman(len(signal)))
    return float(np.sum(np.abs(spectrum[np.fft.rfftfreq(len(signal), 1.0 / RATE) > hz]) ** 2))


@pytest.mark.parametrize("block", [1, 37, 64, 5000])
def test_the_block_size_changes_no_bit(block):
    random = np.random.default_rng(3)
    moves = [cc(int(at), int(random.choice([7, 11])), int(random.integers(128))) for at in random.integers(0, 3000, 40)]
    moves += pieces(1234, sysex.note_tuning({45: 45.4, 64: 66.0})) + pieces(1500, sysex.master_fine(9999))
    moves += pieces(1800, sysex.master_volume(8000))
    frames = 3200
    np.testing.assert_array_equal(play(NOTES + moves, frames, block), play(NOTES + moves, frames))


def test_forces_are_physical_and_not_scaled():
    for signal in ("bridge-force", "strings"):
        quiet = play([*NOTES, cc(0, 7, 1), cc(0, 11, 0)], 4000, signal=signal)
        np.testing.assert_array_equal(quiet, play(NOTES, 4000, signal=signal))


@pytest.mark.parametrize("key", [47, 62, 64, 71])
def test_a_note_retuned_by_30_cents_sounds_30_cents_higher(key):
    """The tuning standard's single note, before the note and while it sounds; within 0.5 cents, where no mode of the
    body or open string is near that would take part (at A3, beside the body's, it is 24 cents)."""
    target = 440.0 * 2 ** ((key - 69) / 12)
    retune = pieces(0, sysex.note_tuning({key: key + 0.3}))
    late = [(6000, *message[1:]) for message in retune]
    heard = []
    for messages in ([], retune, late):
        sound = play([(0, 0x90, key, 60), *messages], round(3.25 * RATE), 4096, "bridge-force")
        heard.append(note_pitch_cents(sound[480:, 0], float(RATE), target))
    assert heard[1] - heard[0] == pytest.approx(30.0, abs=0.5)
    assert heard[2] - heard[0] == pytest.approx(30.0, abs=0.5)
