"""What the figures measure with: spectra, peaks, repetition and zero crossings of signals that are known."""

import numpy as np
import pytest

from ukrt.figures.pitch import band_pass, zero_crossing_frequency
from ukrt.figures.spectra import amplitude_spectrum, db, highest_near, repetition_hz

RATE = 10e3


def tones(seconds, *partials):
    """Sum of a sin(2 pi f t + phase) for (f, a, phase) in ``partials``; times and values."""
    times = np.arange(0.0, seconds, 1.0 / RATE)
    return times, sum(a * np.sin(2.0 * np.pi * f * times + phase) for f, a, phase in partials)


@pytest.mark.parametrize("hz", [82.0, 82.31, 440.77])
@pytest.mark.parametrize("level_db", [0.0, -60.0, -120.0])
def test_a_sinusoids_peak_has_its_frequency_and_amplitude(hz, level_db):
    amplitude = 10.0 ** (level_db / 20.0)
    frequencies, amplitudes = amplitude_spectrum(tones(2.0, (hz, amplitude, 0.3))[1], RATE, pad=4)
    found, height = highest_near(frequencies, amplitudes, hz + 1.0, 5.0)
    assert found == pytest.approx(hz, abs=2e-3)
    assert db(height) == pytest.approx(level_db, abs=0.01)


def test_a_weak_line_beside_a_strong_one_keeps_its_level():
    _, values = tones(8.0, (82.0, 1.0, 0.0), (147.0, 1e-6, 1.0))
    _, height = highest_near(*amplitude_spectrum(values, RATE, pad=4), 147.0, 2.0)
    assert db(height) == pytest.approx(-120.0, abs=0.1)


def test_padding_adds_points_and_changes_none():
    _, values = tones(1.0, (100.3, 1.0, 0.2))
    once, four = amplitude_spectrum(values, RATE), amplitude_spectrum(values, RATE, pad=4)
    assert np.allclose(four[0][::4], once[0]) and np.allclose(four[1][::4], once[1])


def test_without_a_window_whole_periods_leak_nothing():
    frequencies, amplitudes = amplitude_spectrum(tones(1.0, (100.0, 2.0, 0.7))[1], RATE, window="none")
    assert amplitudes[frequencies == 100.0] == pytest.approx(2.0)
    assert np.max(amplitudes[np.abs(frequencies - 100.0) > 0.5]) < 1e-12


def test_pulses_repeat_at_their_rate_and_not_at_their_harmonics():
    times = np.arange(0.0, 1.0, 1.0 / RATE)
    phase = (110.4 * times) % 1.0
    pulses = np.exp(-2.0 * times) * np.exp(-(((phase - 0.5) / 0.05) ** 2)) + 3.0 * np.exp(-5.0 * times)
    assert repetition_hz(pulses, RATE, 60.0, 1000.0) == pytest.approx(110.4, abs=0.3)


def test_zero_crossings_give_the_frequency_of_each_period():
    at, frequency = zero_crossing_frequency(*tones(1.0, (82.4, 1.0, 0.3)))
    assert len(at) == 81  # 82 upward crossings begin within the second
    assert np.allclose(frequency, 82.4, atol=2e-3) and np.all(np.diff(at) > 0.0)


def test_zero_crossings_follow_a_glide():
    times = np.arange(0.0, 4.0, 1.0 / RATE)
    glide = 82.4 + 0.4 * np.exp(-times)  # Hz
    at, frequency = zero_crossing_frequency(times, np.sin(2.0 * np.pi * np.cumsum(glide) / RATE))
    assert np.allclose(frequency, 82.4 + 0.4 * np.exp(-at), atol=5e-3)


def test_the_fundamental_alone_shows_its_glide_through_partials_out_of_tune():
    times = np.arange(0.0, 4.0, 1.0 / RATE)
    phase = 2.0 * np.pi * np.cumsum(82.6 + 0.2 * np.exp(-times)) / RATE
    others = 0.8 * np.sin(2.03 * phase) + 0.6 * np.sin(3.05 * phase + 1.0)
    at, frequency = zero_crossing_frequency(times, band_pass(np.sin(phase) + others, RATE, 82.6, 15.0))
    inner = (at > 0.04) & (at < 3.96)
    assert np.allclose(frequency[inner], 82.6 + 0.2 * np.exp(-at[inner]), atol=0.01)


def test_a_pass_band_delays_nothing_and_keeps_its_centre():
    times, values = tones(1.0, (82.0, 1.0, 0.4), (500.0, 1.0, 0.0))
    passed, inner = band_pass(values, RATE, 82.0, 15.0), (times > 0.05) & (times < 0.95)
    assert np.allclose(passed[inner], np.sin(2.0 * np.pi * 82.0 * times[inner] + 0.4), atol=2e-3)
