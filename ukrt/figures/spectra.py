"""Spectra of records: samples enter, amplitudes over frequency and peaks leave."""

import numpy as np


def amplitude_spectrum(values, rate_hz, window="hann", pad=1):
    """One-sided amplitude spectrum: a sinusoid of amplitude a that lasts throughout has a peak of height a.

    Parameters
    ----------
    values : ndarray (n,)
    rate_hz : float [Hz]
    window : {"hann", "fade", "none"}
        ``fade`` is the falling half of a Hann window: for a note that begins with the record and rings beyond its end.
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
    phase = {"hann": 2.0 * np.pi * np.arange(n) / n, "fade": np.pi * (1.0 + np.arange(n) / n)}
    weights = np.ones(n) if window == "none" else 0.5 - 0.5 * np.cos(phase[window])
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
    shift, top = _summit(np.log(amplitudes[k - 1 : k + 2]))
    return float(frequencies[k] + shift * (frequencies[1] - frequencies[0])), float(np.exp(top))


def repetition_hz(values, rate_hz, low_hz, high_hz):
    """One over the delay at which a record is most like itself, slow changes taken out (autocorrelation).

    Parameters
    ----------
    values : ndarray (n,)
    rate_hz : float [Hz]
    low_hz, high_hz : float [Hz]
        Between which repetition is looked for; the record's spectrum below ``low_hz`` is taken out.

    Returns
    -------
    float [Hz]
    """
    n = len(values)
    power = np.abs(np.fft.rfft(values - np.mean(values), 2 * n)) ** 2
    power[np.fft.rfftfreq(2 * n, 1.0 / rate_hz) < low_hz] = 0.0
    likeness = np.fft.irfft(power)[:n]
    delays = np.arange(int(np.ceil(rate_hz / high_hz)), int(rate_hz / low_hz) + 1)
    here = likeness[delays]  # maxima only: at short delays everything is like itself
    peak = (here > likeness[delays - 1]) & (here >= likeness[delays + 1])
    k = int(delays[peak][np.argmax(here[peak])])
    return rate_hz / (k + _summit(likeness[k - 1 : k + 2])[0])


def _summit(three):
    """Where the parabola through three equidistant values is highest, from the middle one in steps, and how high."""
    before, at, after = three
    curvature = before - 2.0 * at + after
    shift = float(np.clip(0.5 * (before - after) / curvature, -0.5, 0.5)) if curvature < 0.0 else 0.0
    return shift, at - 0.25 * (before - after) * shift


def db(ratio):
    """A ratio of amplitudes in dB."""
    return 20.0 * np.log10(ratio)
