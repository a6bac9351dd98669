"""How a note's pitch leaves its expected course: a signal and this course enter, cents over time leave.

Each partial is turned back by the phase it is expected to have, so that what is left stands nearly still however the
pitch moves; a window takes it out of its neighbours, and the phase it still turns by is what it is off.
"""

import numpy as np

WINDOW_SECONDS, HOP_SECONDS = 0.08, 0.005  # what is 50 Hz away is left out
BLACKMAN_HARRIS = (0.35875, -0.48829, 0.14128, -0.01168)  # sidelobes below -92 dB (Harris 1978): partials die apart


def blackman_harris(n):
    """The window of ``n`` samples (ndarray)."""
    turns = 2.0 * np.pi * (np.arange(n) + 0.5) / n
    return sum(share * np.cos(k * turns) for k, share in enumerate(BLACKMAN_HARRIS))


def partial_track(signal, rate, hz, cents):
    """One partial against its expected course.

    Parameters
    ----------
    signal : ndarray (n,)
    rate : float [Hz]
    hz : float [Hz]
        Its frequency where ``cents`` is 0.
    cents : ndarray (n,)
        What is expected, sample by sample.

    Returns
    -------
    times : ndarray (m,) [s]
    off : ndarray (m,) [cents]
        Above what is expected.
    amplitude : ndarray (m,)
        Of the partial, in units of the signal.
    """
    course = hz * 2.0 ** (cents / 1200.0)
    phase = 2.0 * np.pi / rate * (np.cumsum(course) - 0.5 * course)
    hop, n = round(HOP_SECONDS * rate), round(WINDOW_SECONDS * rate)
    window = blackman_harris(n)
    frames = np.lib.stride_tricks.sliding_window_view(signal * np.exp(-1j * phase), n)[::hop]
    still = 2.0 * (frames @ window) / np.sum(window)
    turned = np.angle(still[1:] * np.conj(still[:-1])) / (2.0 * np.pi * HOP_SECONDS)
    times = (np.arange(len(turned)) + 0.5) * HOP_SECONDS + 0.5 * WINDOW_SECONDS
    at = course[np.minimum(np.round(times * rate).astype(int), len(course) - 1)]
    return times, 1200.0 / np.log(2.0) * np.log1p(turned / at), np.abs(still[1:])


def note_track(signal, rate, hz, cents, partials=6):
    """The pitch of a note against its expected course, from its lowest partials.

    Each partial counts as much as it says about a common pitch in noise: its energy times the square of its number
    (Rife and Boorstyn 1976, the bound of a tone's frequency).

    Returns
    -------
    times : ndarray (m,) [s]
    off : ndarray (m,) [cents]
    level : ndarray (m,)
        Root of the partials' energy.
    """
    pitch, weights, energy = 0.0, 0.0, 0.0
    for number in range(1, partials + 1):
        times, off, amplitude = partial_track(signal, rate, number * hz, cents)
        weight = (number * amplitude) ** 2
        pitch, weights, energy = pitch + weight * off, weights + weight, energy + amplitude**2
    return times, pitch / weights, np.sqrt(energy)
