"""The ringing of a plucked string as a sum of its coupled modes, without stepping through time and with any basis: what
a computed figure is checked against."""

import numpy as np

from ..model.constraints import dense_system
from ..model.strings import string_modes
from .coupled_modes import free_coordinates

HIGHEST_HZ = 4000.0  # modes above are left out: a ramp of 10 ms gives them nothing
RATE_HZ = 1e4  # instants at which the deviation is taken, a second


def deviation_by_modes(case, places, bandwidth_hz):
    """Standard deviation of Y along the first string, from the end of the first pluck to the case's end.

    Modes of M q'' + K q = 0 under the constraints; each loses what the losses take from its own shape, which is right
    to first order in them.

    Parameters
    ----------
    case : ukrt.experiment.case.Case
    places : ndarray (n_places,) [m]
    bandwidth_hz : float [Hz]
        Of the string's basis, whatever the guitar's own.

    Returns
    -------
    ndarray (n_places,) [m]
    """
    string, pluck = case.instrument.strings[0], case.plucks[0]
    dense = dense_system(case.instrument, case.held_points(0.0), bandwidth_hz)
    modes, on = string_modes(string, bandwidth_hz), dense.strings_y[0]
    free = free_coordinates(dense.A[:, on], dense.mass[on])
    square, vectors = np.linalg.eigh(free.T @ (dense.stiffness[on, None] * free))
    heard = (square > 0.0) & (square < (2.0 * np.pi * HIGHEST_HZ) ** 2)
    omega, shapes = np.sqrt(square[heard]), free @ vectors[:, heard]
    sigma = 0.5 * np.sum(np.diag(dense.damping)[on, None] * shapes**2, axis=0)
    size = pluck.force_y * (modes.shape(pluck.place * string.length) @ shapes) / omega
    times = np.arange(pluck.duration, case.duration, 1.0 / RATE_HZ)[:, None]
    ringing = np.exp(-sigma * times) * np.imag(np.exp(1j * omega * times) * _ramp(omega, pluck.duration)) * size
    ringing -= ringing.mean(axis=0)
    covariance = ringing.T @ ringing / len(times)
    along = modes.shape(places) @ shapes
    return np.sqrt(np.einsum("ij,jk,ik->i", along, covariance, along))


def _ramp(omega, duration):
    """Integral of (t / T) exp(-i omega t) from 0 to T [s]: what a ramp gives to a mode."""
    z = 1j * omega * duration
    return duration * (1.0 - (1.0 + z) * np.exp(-z)) / z**2
