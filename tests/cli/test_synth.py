"""`ukrt.Synth`: the calls of a plugin host, the same sound as a rendered file, every wrong argument in a sentence."""

import numpy as np
import pytest
from engine import sysex

import ukrt
from ukrt.errors import ParameterError


@pytest.fixture(scope="module")
def synth():
    damped = {"playing.idle_strings": "damped"}  # or they ring on with the note that has ended
    with ukrt.Synth(sample_rate=48000, block_size=256, overrides=damped) as synth:
        yield synth


@pytest.fixture(autouse=True)
def at_rest(synth):
    synth.reset()


def test_is_silent_until_played(synth):
    assert synth.frame == 0
    block = synth.process()
    assert block.shape == (256, 2) and block.dtype == np.float64 and not block.any()
    assert synth.process(1000).shape == (1000, 2)
    assert synth.frame == 1256


def test_a_note_sounds_and_a_note_off_ends_it(synth):
    synth.note_on(52, 100)
    ringing = np.abs(np.concatenate([synth.process(4800) for _ in range(5)])).max()
    assert 0.005 < ringing < 1.0
    synth.note_off(52)
    for _ in range(15):
        synth.process(4800)
    assert np.abs(synth.process(4800)).max() < 0.05 * ringing


def test_sysex_is_sent_whole(synth):
    sounds = []
    for volume in (16383, 8192):
        synth.reset()
        synth.sysex(sysex.master_volume(volume))
        synth.note_on(52, 100)
        sounds.append(np.concatenate([synth.process(4800) for _ in range(2)])[480:])
    np.testing.assert_allclose(sounds[1], sounds[0] * (8192 / 16383) ** 2, rtol=1e-12)
    for wrong in (b"", b"\xf0", b"\x7f\x00", sysex.master_volume(1)[:-1], b"\xf0\x7f\x80\xf7"):
        with pytest.raises(ParameterError, match="begin with F0"):
            synth.sysex(wrong)


def test_the_pedal_holds_what_note_off_would_end(synth):
    synth.control_change(64, 127)
    synth.note_on(52, 100)
    synth.process(4800)
    synth.note_off(52)
    held = [np.abs(synth.process(4800)).max() for _ in range(10)][-1]
    synth.control_change(64, 0)
    for _ in range(10):
        synth.process(4800)
    assert np.abs(synth.process(4800)).max() < 0.1 * held


def frequency(sound, low, high, rate=48000):
    """Frequency of the strongest tone between ``low`` and ``high`` [Hz]."""
    spectrum = np.abs(np.fft.rfft(sound * np.hanning(len(sound)), 8 * len(sound)))
    hertz = np.arange(len(spectrum)) * rate / (8 * len(sound))
    return hertz[np.argmax(spectrum * ((low < hertz) & (hertz < high)))]


def test_articulations_have_names(synth):
    def play(say):
        synth.reset()
        say()
        synth.note_on(45, 90)
        return synth.process(4800)

    named = play(lambda: synth.articulate(attack=10, strum_direction=127, mute=127))
    numbered = play(lambda: (synth.control_change(22, 10), synth.control_change(19, 127)))
    assert np.array_equal(named, numbered) and not np.array_equal(named, play(lambda: None))
    for controls, words in (({"atack": 1}, "atack"), ({"attack": 128}, "0 to 127"), ({"attack": 0.5}, "whole number")):
        with pytest.raises(ParameterError, match=words):
            synth.articulate(**controls)


def test_pitch_bend_raises_the_tone(synth):
    tones = []
    for bend in (0, 8191, -8192):
        synth.reset()
        synth.pitch_bend(bend)
        synth.note_on(64, 60)
        synth.process(8192)
        sound = np.concatenate([synth.process(4800) for _ in range(5)])[:, 0]
        tones.append(frequency(sound, 270, 400))
    up, down = (12 * np.log2(tone / tones[0]) for tone in tones[1:])
    assert (up, down) == pytest.approx((2.0, -2.0), abs=0.1)


def test_events_act_at_their_frame_whatever_the_blocks(synth):
    def play(*sizes):
        synth.reset()
        synth.note_on(45, 90, frame=100)
        synth.note_on(57, 70, frame=2000)
        return np.concatenate([synth.process(n) for n in sizes])

    whole = play(6000)
    assert np.array_equal(whole, play(*[1000] * 6))
    assert np.array_equal(whole, play(1, 63, 64, 65, 107, 1700, 4000))
    assert not whole[:100].any() and whole[:4000].any()


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda s: s.note_on(128, 90), "note is 128, but it must be a whole number from 0 to 127"),
        (lambda s: s.note_on(60, -1), "velocity is -1"),
        (lambda s: s.note_on(60.5, 90), "note is 60.5"),
        (lambda s: s.note_on(60, True), "velocity is True"),
        (lambda s: s.note_off(60, channel=16), "channel is 16, but it must be a whole number from 0 to 15"),
        (lambda s: s.control_change(-1, 0), "controller is -1"),
        (lambda s: s.pitch_bend(8192), "bend is 8192, but it must be a whole number from -8192 to 8191"),
        (lambda s: s.process(0), "n is 0, but it must be a whole number from 1 to 8192"),
        (lambda s: s.process(8193), "n is 8193"),
        (
            lambda s: (s.process(100), s.note_on(60, 90, frame=99)),
            "frame is 99, but it must be a whole number from 100",
        ),
    ],
)
def test_wrong_arguments_are_refused_in_a_sentence(synth, call, words):
    with pytest.raises(ParameterError, match=words):
        call(synth)


@pytest.mark.parametrize(
    ("options", "words"), [({"block_size": 0}, "block_size is 0"), ({"sample_rate": 8000}, "8000")]
)
def test_wrong_set_up_is_refused(options, words):
    with pytest.raises(ParameterError, match=words):
        ukrt.Synth(**options)


def test_other_signals_have_their_channels():
    with ukrt.Synth(signal="strings") as strings, ukrt.Synth(signal="bridge-force") as bridge:
        for synth in (strings, bridge):
            synth.note_on(47, 90)
        each, whole = (np.concatenate([s.process(4096) for _ in range(3)]) for s in (strings, bridge))
    assert each.shape[1] == 6 and whole.shape[1] == 1
    assert np.allclose(each.sum(axis=1), whole[:, 0], rtol=0, atol=1e-9 * np.abs(whole).max())
