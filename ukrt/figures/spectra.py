"""Spectra of records: samples enter, amplitudes over frequency and peaks leave."""

import numpy as np


def amplitude_spectrum(values, rate_hz, window="hann", pad=1):
    """One-sided amplitude spectrum: a sinusoid of amplitude a that lasts throughout has a peak of height a.

    Parameters
    ----------
    values : ndarray (n,)
    rate_hz : float [Hz]
    window : {"hann", "none"}
    pad : int
        The record is made so many times longer with zeros, which interpolates the spectrum.

    Returns
    -------
    frequencies : ndarray (n_bins,) [Hz]
    amplitudes : ndarray (n_bins,)
        In the unit of ``values``.
    """
    values = np.asarray(values, float)
    n = len(values)
    weights = np.ones(n) if window == "none" else 0.5 - 0.5 * np.cos(2.0 * np.pi * np.arange(n) / n)
    amplitudes = 2.0 * np.abs(np.fft.rfft(values * weights, n * pad)) / np.sum(weights)
    return np.fft.rfftfreq(n * pad, 1.0 / rate_hz), amplitudes


def highest_near(frequencies, amplitudes, centre_hz, within_hz):
    """The highest point of a spectrum near a frequency, between bins by a parabola through three levels.

    Parameters
    ----------
    frequencies, amplitudes : ndarray (n_bins,) [Hz], [any]
    centre_hz, within_hz : float [Hz]

    Returns
    -------
    frequency, amplitude : float [Hz], [any]
    """
    near = np.flatnonzero(np.abs(frequencies - centre_hz) <= within_hz)
    k = int(near[np.argmax(amplitudes[near])])
    if not 0 < k < len(amplitudes) - 1 or np.min(amplitudes[k - 1 : k + 2]) <= 0.0:
        return float(frequencies[k]), float(amplitudes[k])
    before, at, after = np.log(amplitudes[k - 1 : k + 2])
    curvature = before - 2.0 * at + after
    shift = 0.5 * (before - after) / curvature if curvature < 0.0 else 0.0
    shift = float(np.clip(shift, -0.5, 0.5))
    step = frequencies[1] - frequencies[0]
    return float(frequencies[k] + shift * step), float(np.exp(at - 0.25 * (before - after) * shift))


def db(ratio):
    """A ratio of amplitudes in dB."""
    return 20.0 * np.log10(ratio)
