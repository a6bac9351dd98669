"""The pitch tracker on tones of known pitch."""

import numpy as np
import pytest

from measure.pitch_track import WINDOW_SECONDS, blackman_harris, note_track, partial_track

RATE = 48000.0
TIME = np.arange(96000) / RATE


def tone(hz, cents, amplitude):
    """A partial of a moving pitch, amplitude (n,) or a number."""
    return amplitude * np.sin(2.0 * np.pi * np.cumsum(hz * 2.0 ** (cents / 1200.0)) / RATE + 0.3)


@pytest.mark.parametrize("off", [0.0, 0.05, -7.0])
def test_a_constant_offset_on_a_moving_pitch(off):
    """A bend of a fourth and back, decaying partials: what it is off, to 0.1 cents."""
    course = 250.0 * (1.0 - np.cos(2.0 * np.pi * TIME))
    signal = sum(tone(k * 110.0, course + off, np.exp(-k * TIME) / k) for k in range(1, 8))
    for found in (partial_track(signal, RATE, 330.0, course), note_track(signal, RATE, 110.0, course)):
        assert found[1] == pytest.approx(np.full(len(found[0]), off), abs=0.1)


def test_a_pitch_that_moves_unexpectedly():
    """Vibrato of 20 cents at 5 Hz against a constant course is seen through the window, in phase."""
    sway = 20.0 * np.sin(2.0 * np.pi * 5.0 * TIME)
    times, off, _ = partial_track(tone(220.0, sway, 1.0), RATE, 220.0, np.zeros(len(TIME)))
    window = blackman_harris(round(WINDOW_SECONDS * RATE))
    seen = np.interp(times, TIME, np.convolve(sway, window / window.sum(), "same"))
    assert np.abs(off - seen)[20:-20].max() < 0.2 and 17.0 < off[20:-20].max() < 20.0


def test_amplitudes():
    _, _, amplitude = partial_track(tone(440.0, np.zeros(len(TIME)), 0.25), RATE, 440.0, np.zeros(len(TIME)))
    assert amplitude == pytest.approx(np.full(len(amplitude), 0.25), rel=1e-4)
