"""Strengths of modes whose poles are known: responses enter, one strength a mode and path leaves, by least squares.

The fit is made on the transfer functions of the whole record from ``min_hz`` to ``max_hz``, which by Parseval's theorem
is least squares on the response in that band. A mode of strength c = phi_drive phi_response / m has the impulse
response

    2 Re(c rho exp(lambda t)),   rho = lambda^power / (2 j Im lambda),   power 0, 1, 2 for displacement, velocity,
                                                                         acceleration

and its sampled, finite transform is a geometric sum in closed form: no windows, no leakage. Modes outside the band are
a polynomial in s (compliance and inertia of what lies above, mass of what lies below).
"""

import dataclasses

import numpy as np

from .measurement import POWERS


@dataclasses.dataclass(frozen=True)
class Band:
    """Transfer functions to fit.

    Attributes
    ----------
    frequencies : ndarray (m,) [Hz]
    values : ndarray (m, k) complex [m, m/s or m/s^2 per N]
    sample_rate : float [Hz]
    count : int
        Samples of the record; 0 for a periodic one, which holds each mode's whole ringing.
    power : int
        Of s over the receptance.
    delay : float [s]
        By which the responses come late.
    """

    frequencies: np.ndarray
    values: np.ndarray
    sample_rate: float
    count: int
    power: int
    delay: float = 0.0

    def sums(self, poles):
        """Transforms of sampled exp(pole (t - delay)), from ``delay`` on: ndarray (m, n) complex [s].

        Parameters
        ----------
        poles : ndarray (n,) complex [1/s]
        """
        first = int(np.ceil(self.delay * self.sample_rate - 1e-9))
        turn = 2j * np.pi * self.frequencies[:, None] / self.sample_rate
        start = np.exp(poles * (first / self.sample_rate - self.delay) - turn * first)
        end = 0.0
        if self.count:
            end = np.exp(poles * (self.count / self.sample_rate - self.delay) - turn * self.count)
        return (start - end) / (1.0 - np.exp(poles / self.sample_rate - turn)) / self.sample_rate

    def outside(self):
        """What modes outside the band add: ndarray (m, 3) complex, of size 1 in the band's middle."""
        s = 1j * self.frequencies / np.sqrt(self.frequencies[0] * self.frequencies[-1])
        late = np.exp(-2j * np.pi * self.frequencies * self.delay)
        return np.stack([1.0 / s, np.ones_like(s), s], axis=1) * late[:, None]


@dataclasses.dataclass(frozen=True)
class Strengths:
    """What the fit found.

    Attributes
    ----------
    values : ndarray (n, k) [1/kg]
        phi_drive phi_response / m of each mode and path.
    errors : ndarray (n, k) [1/kg]
        Standard errors, as if what the fit leaves were noise.
    fitted : ndarray (m, k) complex
        Modes and what lies outside the band.
    """

    values: np.ndarray
    errors: np.ndarray
    fitted: np.ndarray


def make_band(measurement, min_hz, max_hz, delay=0.0):
    """The part of a measurement's transfer functions that is fitted: `Band`."""
    frequencies, values = measurement.spectra()
    inside = (frequencies >= min_hz) & (frequencies <= max_hz)
    count = 0 if measurement.periodic else len(measurement.responses)
    power = POWERS[measurement.quantity]
    return Band(frequencies[inside], values[inside], measurement.sample_rate, count, power, delay)


def mode_responses(band, poles):
    """Transforms of modes of strength 1/kg: ndarray (m, n) complex."""
    rho = poles**band.power / (2j * poles.imag)
    return rho * band.sums(poles) + np.conj(rho) * band.sums(np.conj(poles))


def fit_strengths(band, poles):
    """Real strengths of modes with given poles: real modes, as the guitar's model has them.

    Parameters
    ----------
    band : Band
    poles : ndarray (n,) complex [1/s]

    Returns
    -------
    Strengths
    """
    basis = reals(np.concatenate([mode_responses(band, poles), band.outside()], axis=1))
    values, errors = _least_squares(basis, reals(band.values))
    fitted = (basis @ values)[: len(band.values)] + 1j * (basis @ values)[len(band.values) :]
    return Strengths(values[: len(poles)], errors[: len(poles)], fitted)


def fit_complex_strengths(band, poles):
    """The strengths of modes when these may be complex, as in a body whose parts do not move in phase.

    Returns
    -------
    values : ndarray (n, k) complex [1/kg]
    errors : ndarray (n, k) [1/kg]
        Standard errors of the real part.
    """
    rho = poles**band.power / (2j * poles.imag)
    ahead, back = rho * band.sums(poles), np.conj(rho) * band.sums(np.conj(poles))
    basis = reals(np.concatenate([ahead + back, 1j * (ahead - back), band.outside()], axis=1))
    values, errors = _least_squares(basis, reals(band.values))
    return values[: len(poles)] + 1j * values[len(poles) : 2 * len(poles)], errors[: len(poles)]


def reals(values):
    """Real above imaginary parts: complex (m, ...) as real (2 m, ...)."""
    return np.concatenate([values.real, values.imag])


def _least_squares(basis, wanted):
    """Solution (n, k) and its standard errors; columns are brought to one size first."""
    size = np.linalg.norm(basis, axis=0)
    left, singular, right = np.linalg.svd(basis / size, full_matrices=False)
    inverse = right.T / np.maximum(singular, 1e-12 * singular[0])
    values = inverse @ (left.T @ wanted)
    rest = wanted - left @ (singular[:, None] * (right @ values))
    variance = np.sum(rest**2, axis=0) / max(len(wanted) - len(size), 1)
    errors = np.sqrt(np.sum(inverse**2, axis=1)[:, None] * variance)
    return values / size[:, None], errors / size[:, None]
