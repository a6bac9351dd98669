"""Frequency from zero crossings: samples enter, times and frequencies of single periods leave."""

import numpy as np


def zero_crossing_frequency(times, values):
    """Frequency of each period between two upward zero crossings, which are interpolated linearly.

    Parameters
    ----------
    times : ndarray (n,) [s]
    values : ndarray (n,)

    Returns
    -------
    middles : ndarray (n_periods,) [s]
    frequencies : ndarray (n_periods,) [Hz]
    """
    before = np.flatnonzero((values[:-1] < 0.0) & (values[1:] >= 0.0))
    step = times[before + 1] - times[before]
    at = times[before] + step * values[before] / (values[before] - values[before + 1])
    return 0.5 * (at[1:] + at[:-1]), 1.0 / np.diff(at)


def band_pass(values, rate_hz, centre_hz, width_hz):
    """What of a record lies near a frequency, without delay: its spectrum under a Gauss curve.

    Parameters
    ----------
    values : ndarray (n,)
    rate_hz, centre_hz : float [Hz]
    width_hz : float [Hz]
        Standard deviation of the Gauss curve; in time it spreads over 1 / (2 pi width) and is not right nearer to the
        ends than about three times that.

    Returns
    -------
    ndarray (n,)
    """
    n = len(values)
    length = n + int(np.ceil(rate_hz / width_hz))  # so that its end does not run into its beginning
    spectrum = np.fft.rfft(values, length)
    distance = (np.fft.rfftfreq(length, 1.0 / rate_hz) - centre_hz) / width_hz
    return np.fft.irfft(spectrum * np.exp(-0.5 * distance**2), length)[:n]
