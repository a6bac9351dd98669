"""The Eigensystem Realization Algorithm: impulse responses enter, poles and shapes for every model order leave.

J.-N. Juang, R. S. Pappa, J. Guidance 8(5), 620-627 (1985); J.-N. Juang, Applied System Identification, Prentice Hall
1994, ch. 5. The block Hankel matrix of the Markov parameters is cut to its largest singular values; in balanced
coordinates the state matrix of order n is the leading n x n block of that of any higher order, so that one singular
value decomposition serves all orders.
"""

import dataclasses

import numpy as np
import soxr

from .measurement import PATHS

OVERSAMPLING = 2.5  # rate over the highest frequency: soxr is flat to 0.91 of the Nyquist frequency
LEAST_OVERSAMPLING = 2.2
SKIPPED = 20  # samples after decimation in which the filter's ringing is not yet over: no free decay
BLOCK_COLUMNS = 8  # times the block rows, where the record is long enough: more averaging at the price of one SVD row


@dataclasses.dataclass(frozen=True)
class Poles:
    """Poles of one model order, one of each conjugate pair.

    Attributes
    ----------
    order : int
    values : ndarray (n,) complex [1/s]
    shapes : ndarray (n, n_outputs) complex
        Of arbitrary scale.
    """

    order: int
    values: np.ndarray
    shapes: np.ndarray

    @property
    def frequencies_hz(self):
        """Undamped natural frequencies (n,) [Hz]."""
        return np.abs(self.values) / (2.0 * np.pi)

    @property
    def damping_ratios(self):
        """Damping ratios (n,) [1]."""
        return -self.values.real / np.abs(self.values)


def free_decays(measurement, max_hz, delay=0.0):
    """The band up to ``max_hz`` at a low rate, from where the response decays freely.

    Parameters
    ----------
    measurement : Measurement
    max_hz : float [Hz]
    delay : float [s]
        By which the responses come late.

    Returns
    -------
    decays : ndarray (n, k)
    rate : float [Hz]
    """
    rate = measurement.sample_rate
    low = OVERSAMPLING * max_hz
    if rate <= 1.2 * low and not measurement.periodic:
        return measurement.responses[int(np.ceil(delay * rate)) + 1 :], rate  # an acceleration begins with a pulse
    decays = measurement.responses if rate <= low else soxr.resample(measurement.responses, rate, low, quality="VHQ")
    low = min(rate, low)
    return decays[int(np.ceil(delay * low)) + SKIPPED :], low


def markov_parameters(decays, paths):
    """Responses as matrices, outputs by inputs.

    With both driving points and the path between them the matrix is whole, for the body is reciprocal; otherwise all
    responses are outputs of one input, which has the same poles.

    Parameters
    ----------
    decays : ndarray (n, k)
    paths : tuple of str

    Returns
    -------
    ndarray (n, n_outputs, n_inputs)
    """
    by_entry = {}
    for column, name in zip(decays.T, paths, strict=True):
        by_entry.setdefault(tuple(sorted(PATHS[name])), []).append(column)
    if len(by_entry) < 3:
        return decays[:, :, None]
    bass, cross, treble = (np.mean(by_entry[entry], axis=0) for entry in ((0, 0), (0, 1), (1, 1)))
    return np.stack([bass, cross, cross, treble], axis=1).reshape(-1, 2, 2)


def realize(markov, rate, orders):
    """Poles for each model order.

    Parameters
    ----------
    markov : ndarray (n, n_outputs, n_inputs)
    rate : float [Hz]
    orders : sequence of int
        Model orders, two for each mode.

    Returns
    -------
    list of Poles
    """
    largest = max(orders)
    n, outputs, inputs = markov.shape
    rows = min(max(150, -(-5 * largest // (4 * outputs))), n // 2)
    columns = min(BLOCK_COLUMNS * rows, n - rows)
    at = np.arange(rows)[:, None] + np.arange(columns)
    hankel, shifted = (markov[at + k].transpose(0, 2, 1, 3).reshape(rows * outputs, columns * inputs) for k in (0, 1))
    left, singular, right = np.linalg.svd(hankel, full_matrices=False)
    root = np.sqrt(np.maximum(singular[:largest], singular[0] * np.finfo(float).eps))
    state = (left[:, :largest] / root).T @ shifted @ (right[:largest].T / root)
    output = left[:outputs, :largest] * root
    return [_poles(state[:order, :order], output[:, :order], rate, order) for order in orders if order <= len(state)]


def _poles(state, output, rate, order):
    values, vectors = np.linalg.eig(state)
    upper = (values.imag > 0.0) & (np.abs(values) > 0.0)
    poles = np.log(values[upper]) * rate
    return Poles(order, poles, (output @ vectors[:, upper]).T)
