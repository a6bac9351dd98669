"""Spectrograms, decays and sounds of signals that are known."""

import numpy as np
import pytest

from ukrt.figures.decay import band, decay_rate, envelope_ripple, time_to_fall
from ukrt.figures.sounds import SOUND_HZ, convolved, normal_gain, resampled
from ukrt.figures.spectra import amplitude_spectrum
from ukrt.figures.spectrogram import spectrogram

RATE = 50e3


def tone(hz, seconds=1.0, rate_hz=RATE, sigma=0.0):
    t = np.arange(int(seconds * rate_hz)) / rate_hz
    return np.exp(-sigma * t) * np.sin(2 * np.pi * hz * t)


def test_a_sinusoid_has_the_level_of_its_amplitude_whatever_the_window():
    for window_s in (0.04, 0.08, 0.2):
        times, frequencies, levels = spectrogram(0.02 * tone(1000.0), RATE, window_s, 0.01)
        middle = np.argmin(np.abs(times - 0.5))
        peak = np.argmax(levels[middle])
        assert frequencies[peak] == pytest.approx(1000.0, abs=0.5 / window_s)
        assert levels[middle, peak] == pytest.approx(20 * np.log10(0.02), abs=0.01)


def test_a_spectrogram_shows_a_tone_when_it_sounds():
    silent_then = np.concatenate([np.zeros(25000), tone(500.0, 0.5)])
    times, frequencies, levels = spectrogram(silent_then, RATE, 0.08, 0.01)
    level = levels[:, np.argmin(np.abs(frequencies - 500.0))]
    assert np.abs(times[np.argmin(np.abs(level - (level.max() - 6.0206)))] - 0.5) < 0.011
    assert times[0] == 0.0 and times[-1] <= 1.0 - 0.04 + 1e-9
    assert frequencies[-1] <= 5000.0 and levels.shape == (len(times), len(frequencies))


def test_a_fading_window_keeps_the_amplitude_of_a_sinusoid():
    frequencies, amplitudes = amplitude_spectrum(0.3 * tone(440.0, 2.0), RATE, "fade")
    assert amplitudes[np.argmin(np.abs(frequencies - 440.0))] == pytest.approx(0.3, rel=1e-3)


def test_decay_of_an_exponential():
    sound = tone(462.0, 3.0, sigma=3.8) + 0.5 * tone(700.0, 3.0, sigma=1.0)
    assert decay_rate(sound, RATE, 462.0) == pytest.approx(3.8, rel=2e-3)
    assert time_to_fall(tone(200.0, 5.0, sigma=2.0), RATE, 10.0) == pytest.approx(np.log(10.0) / 4.0, abs=3e-3)


def test_ripple_is_what_the_envelope_has_over_a_smooth_curve():
    t = np.arange(int(4 * RATE)) / RATE
    plain = tone(1000.0, 4.0, sigma=1.5)
    assert envelope_ripple(plain, RATE) < 1e-3
    wobbling = plain * 10 ** (0.05 * 0.5 * np.sin(2 * np.pi * 6.0 * t))
    assert envelope_ripple(wobbling, RATE) == pytest.approx(0.5 / np.sqrt(2), rel=0.07)


def test_bands_add_up_to_the_whole():
    sound = tone(300.0) + 0.1 * tone(2000.0)
    assert np.max(np.abs(band(sound, RATE, 0, 1000) + band(sound, RATE, 1000, 1e9) - sound)) < 1e-12
    assert np.max(np.abs(band(sound, RATE, 1000, 3000) - 0.1 * tone(2000.0))) < 1e-9


def test_convolution_gives_each_end_of_the_bridge_its_own_response():
    rng = np.random.default_rng(1)
    ends, response = rng.normal(size=(300, 2)), rng.normal(size=(40, 2, 2))
    by_hand = sum(np.convolve(ends[:, e], response[:, e, 1]) for e in range(2))
    assert convolved(ends, response)[:, 1] == pytest.approx(by_hand, abs=1e-11)


def test_a_sound_keeps_its_amplitude_and_is_normalised_to_minus_one_decibel():
    made = resampled(0.25 * tone(1000.0), RATE)
    assert len(made) == SOUND_HZ
    assert np.sqrt(2 * np.mean(made[4800:-4800] ** 2)) == pytest.approx(0.25, rel=1e-4)
    assert normal_gain(made, 3.0 * made) * 3.0 * np.max(np.abs(made)) == pytest.approx(10 ** (-1 / 20))
