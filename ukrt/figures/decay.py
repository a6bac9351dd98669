"""How fast a note dies: samples enter, times leave."""

import numpy as np


def time_to_fall(values, rate_hz, fall_db):
    """Time until all but ``fall_db`` of a record's energy has passed (Schroeder, JASA 37, 409, 1965).

    Parameters
    ----------
    values : ndarray (n,)
    rate_hz : float [Hz]
    fall_db : float [dB]
        The energy that is left is that many dB below the whole.

    Returns
    -------
    float [s]
    """
    left = np.cumsum(np.square(values)[::-1])[::-1]
    return float(np.count_nonzero(left >= left[0] * 10.0 ** (-fall_db / 10.0)) / rate_hz)


def decay_rate(values, rate_hz, hz, window_s=0.25, floor_db=-60.0):
    """Rate sigma at which the partial near ``hz`` dies as exp(-sigma t), by a straight line through its level.

    Parameters
    ----------
    values : ndarray (n,)
    rate_hz : float [Hz]
    hz : float [Hz]
        Other partials must keep 4 / ``window_s`` away from it.
    window_s : float [s]
        Of the Hann windows, one beside the other, in which its amplitude is taken.
    floor_db : float [dB]
        Levels below this, over the first, do not count.

    Returns
    -------
    float [1/s]
    """
    n = int(round(window_s * rate_hz))
    frames = np.asarray(values, float)[: len(values) // n * n].reshape(-1, n)
    window = np.hanning(n) * np.exp(-2j * np.pi * hz / rate_hz * np.arange(n))
    level = np.log(np.abs(frames @ window))
    used = level > level[0] + floor_db / 20.0 * np.log(10.0)
    times = np.arange(len(frames))[used] * n / rate_hz
    return float(-np.polyfit(times, level[used], 1)[0])


def envelope_ripple(values, rate_hz, start=0.1, end=3.0, cell_s=0.02, degree=5):
    """How much an envelope wobbles about a smooth curve.

    Parameters
    ----------
    values : ndarray (n,)
    rate_hz : float [Hz]
    start, end : float [s]
        Where it is looked at.
    cell_s : float [s]
        The envelope is the largest value in each cell, longer than a period.
    degree : int
        Of the polynomial through the level over time.

    Returns
    -------
    float [dB]
        Rms.
    """
    n = int(round(cell_s * rate_hz))
    part = np.asarray(values, float)[int(start * rate_hz) : int(end * rate_hz)]
    level = 20.0 * np.log10(part[: len(part) // n * n].reshape(-1, n).max(axis=1))
    curve = np.polynomial.Polynomial.fit(np.arange(len(level)), level, degree)
    return float(np.sqrt(np.mean((level - curve(np.arange(len(level)))) ** 2)))


def band(values, rate_hz, low_hz, high_hz):
    """The part of a record between two frequencies, cut out of its Fourier transform: ndarray (n,)."""
    spectrum, hz = np.fft.rfft(values), np.fft.rfftfreq(len(values), 1.0 / rate_hz)
    return np.fft.irfft(np.where((hz >= low_hz) & (hz < high_hz), spectrum, 0.0), len(values))
