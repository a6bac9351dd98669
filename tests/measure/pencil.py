"""Sums of decaying exponentials: real records enter, a narrow band is cut out of them, its exact exponents leave.

The band is shifted to zero, filtered by a finite linear-phase filter and decimated. Only samples for which the filter
saw nothing but signal are kept, so that exp(s t) stays exp(s t) and no exponent is biased by the filter. They come
from the shift invariance of the record's signal space (ESPRIT, Roy & Kailath 1989; matrix pencil, Hua & Sarkar 1990).
"""

import numpy as np
import scipy.linalg
import scipy.signal

LARGEST_ROWS = 160  # of the Hankel matrix, and its columns: longer records are read with gaps between the columns
LARGEST_COLUMNS = 480


def subband(records, sample_rate, centre_hz, half_width_hz, stop_db=100.0):
    """Cut centre_hz +- half_width_hz out of real records (k, channels).

    Returns the complex band (m, channels), shifted to zero; its rate [Hz], about four half-widths; and gain(s), by
    which a component exp(s t) of the records comes out larger in the band, whose first sample stands for their time 0.
    From twice the half-width on, what is outside is attenuated by stop_db.
    """
    records = np.asarray(records, float)
    records = records[:, None] if records.ndim == 1 else records
    factor = max(1, int(sample_rate / (4.0 * half_width_hz)))
    n_taps, beta = scipy.signal.kaiserord(stop_db, half_width_hz / (0.5 * sample_rate))
    n_taps += 1 - n_taps % 2
    if records.shape[0] < n_taps + 8 * factor:
        needed = (n_taps + 8 * factor) / sample_rate
        length = records.shape[0] / sample_rate
        raise ValueError(f"record of {length:.3f} s, a band of +-{half_width_hz:g} Hz needs {needed:.3f} s")
    taps = scipy.signal.firwin(n_taps, 1.5 * half_width_hz, window=("kaiser", beta), fs=sample_rate)
    turn = np.exp(2j * np.pi * centre_hz / sample_rate * (np.arange(n_taps) - (n_taps - 1) // 2))
    taps = taps * turn  # the filter is shifted, not the signal: valid output k is sum taps[j] x[k + n - 1 - j]
    starts = np.arange(0, records.shape[0] - n_taps + 1, factor)
    lead = -(n_taps - 1) % factor  # zeros before the taps put the first whole window on a multiple of the factor
    first = (n_taps - 1 + lead) // factor
    filtered = scipy.signal.upfirdn(np.concatenate([np.zeros(lead), taps]), records, down=factor, axis=0)
    band = filtered[first : first + starts.size]
    band *= np.exp(-2j * np.pi * centre_hz / sample_rate * starts)[:, None]

    def gain(s):
        return np.exp(np.multiply.outer(s, np.arange(n_taps)[::-1] / sample_rate)) @ taps

    return band, sample_rate / factor, gain


def pencil(band, order=None, tolerance=1e-11, largest_order=40, noise_factor=5.0):
    """Exponents of band[k] = sum_j a_j z_j^k, all channels sharing them.

    order : how many; None takes the singular values above tolerance times the largest AND above noise_factor times the
    one a quarter down the list (noise; the signal must have far fewer exponents than that).
    Returns z (order,), amplitudes at sample 0 (order, channels).
    """
    m, channels = band.shape
    rows = min(max(m // 3, 4), LARGEST_ROWS)
    stride = max(1, (m - rows) * channels // LARGEST_COLUMNS)
    hankel = np.arange(rows)[:, None] + np.arange(0, m - rows + 1, stride)
    data = np.concatenate([band[:, c][hankel] for c in range(channels)], axis=1)
    # QR first: the singular values and left vectors of a wide matrix at the price of a square one
    triangle = scipy.linalg.qr(data.conj().T, mode="r", check_finite=False)[0][: min(data.shape)]
    left, values, _ = scipy.linalg.svd(triangle.conj().T, full_matrices=False, check_finite=False)
    if order is None:
        floor = max(tolerance * values[0], noise_factor * values[values.size // 4])
        order = int(np.clip(np.sum(values > floor), 1, min(largest_order, values.size // 4)))
    space = left[:, :order]
    z = np.linalg.eigvals(np.linalg.lstsq(space[:-1], space[1:], rcond=None)[0])
    powers = z[None, :] ** np.arange(m)[:, None]
    scale = np.linalg.norm(powers, axis=0)
    amplitudes = np.linalg.lstsq(powers / scale, band, rcond=None)[0] / scale[:, None]
    return z, amplitudes
