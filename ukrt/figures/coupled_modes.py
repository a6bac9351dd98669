"""Modes of the coupled system from its eigenvalue problem, without stepping through time: a case enters; poles, shapes
and how much of each the finger has leave. What the peaks of a computed spectrum are compared with."""

from dataclasses import dataclass

import numpy as np

from ..model.constraints import dense_system
from ..model.strings import string_modes

RANK = 1e-10  # of the largest singular value of A: below it a constraint says nothing new


@dataclass(frozen=True)
class CoupledModes:
    """Modes in Y of strings, body and fingers under their constraints, by rising frequency.

    Attributes
    ----------
    poles : ndarray (n,) complex [1/s]
        -sigma + i omega.
    amplitudes : ndarray (n_coordinates, n) complex
        Of the uncoupled modes [q_Y, q_B, q_FY]; each column has unit kinetic energy at unit velocity, sum m |q|^2 = 1.
    mass : ndarray (n_coordinates,) [kg]
    fingers : slice
        Their coordinates.
    first_string : ukrt.model.strings.StringModes
        Its coordinates are the first.
    """

    poles: np.ndarray
    amplitudes: np.ndarray
    mass: np.ndarray
    fingers: slice
    first_string: object

    @property
    def frequencies(self):
        """Frequencies of the damped modes [Hz]."""
        return self.poles.imag / (2.0 * np.pi)

    @property
    def finger_share(self):
        """Part of each mode's kinetic energy that the fingers have (n,)."""
        return self.mass[self.fingers] @ np.abs(self.amplitudes[self.fingers]) ** 2

    def share_between(self, start, end, points=2001):
        """Part of each mode's squared displacement along the first string between two places [m] (n,)."""
        place = np.linspace(0.0, self.first_string.length, points)
        modes = self.first_string
        square = np.abs(modes.shape(place) @ self.amplitudes[: modes.count]) ** 2
        inside = (place >= start) & (place <= end)
        return square[inside].sum(axis=0) / square.sum(axis=0)

    def likeness(self, others):
        """Modal assurance of each mode with each of ``others`` over the string: ndarray (n, n_others), 0 to 1."""
        count = self.first_string.count
        a, b = self.amplitudes[:count], others.amplitudes[:count]
        lengths = np.sum(np.abs(a) ** 2, axis=0)[:, None] * np.sum(np.abs(b) ** 2, axis=0)
        return np.abs(a.conj().T @ b) ** 2 / lengths


def coupled_modes(case, bandwidth_hz=None):
    """Modes of a case's system as it stands at the beginning, motion in Y.

    With N a basis of the null space of A (Eq. 46) and q = N z, M q'' + C q' + K q = 0 becomes an eigenvalue problem
    without constraints; first without C, then with C in the modes found, all those below the guitar's own bandwidth.

    Parameters
    ----------
    case : ukrt.experiment.case.Case
    bandwidth_hz : float, optional
        Of the strings' basis; by default the guitar's. A wide one stands for the continuous string.

    Returns
    -------
    CoupledModes
    """
    own_hz = case.instrument.basis.bandwidth_hz
    dense = dense_system(case.instrument, case.held_points(0.0), bandwidth_hz)
    kept = [*dense.strings_y, dense.body, dense.fingers_y]
    rows = np.concatenate([np.arange(one.start, one.stop) for one in kept])
    mass = dense.mass[rows]
    free = free_coordinates(dense.A[:, rows], mass)
    square, shapes = np.linalg.eigh(free.T @ (dense.stiffness[rows, None] * free))
    if bandwidth_hz and bandwidth_hz > own_hz:
        low = square <= (2.0 * np.pi * own_hz) ** 2
        square, shapes = square[low], shapes[:, low]
    free = free @ shapes
    damping = free.T @ dense.damping[np.ix_(rows, rows)] @ free
    size = free.shape[1]
    state = np.block([[np.zeros((size, size)), np.eye(size)], [-np.diag(square), -damping]])
    poles, vectors = np.linalg.eig(state)
    order = np.argsort(poles.imag)
    order = order[poles.imag[order] > 0.0]
    amplitudes = free @ vectors[:size, order]
    amplitudes /= np.sqrt(mass @ np.abs(amplitudes) ** 2)
    fingers = slice(len(rows) - (dense.fingers_y.stop - dense.fingers_y.start), len(rows))
    first = string_modes(case.instrument.strings[0], bandwidth_hz or own_hz)
    return CoupledModes(poles[order], amplitudes, mass, fingers, first)


def free_coordinates(A, mass):
    """A basis N of the motions that constraints leave free: A N = 0 and N^T M N = 1.

    Parameters
    ----------
    A : ndarray (n_rows, n)
        Rows may be nil or say the same twice.
    mass : ndarray (n,) [kg]

    Returns
    -------
    ndarray (n, n_free) [kg^-1/2]
    """
    _, singular, vt = np.linalg.svd(A / np.sqrt(mass))
    return vt[np.count_nonzero(singular > RANK * singular[0]) :].T / np.sqrt(mass)[:, None]
