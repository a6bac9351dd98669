"""Modal subsystems: modal masses, frequencies and dampings with the shapes at some points enter; receptances, and the
static compliance and inertia of modes that a basis leaves out, leave (Eqs. 7-15 in the Laplace variable)."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class ModalSystem:
    """Uncoupled modes m (q'' + 2 zeta omega q' + omega^2 q) = phi . f.

    Attributes
    ----------
    mass : ndarray (n_modes,) [kg]
    omega : ndarray (n_modes,) [rad/s]
    zeta : ndarray (n_modes,) [1]
    """

    mass: np.ndarray
    omega: np.ndarray
    zeta: np.ndarray

    @property
    def count(self):
        """Number of modes."""
        return self.omega.shape[-1]

    def mobility(self, s):
        """Modal receptances 1 / (m (s^2 + 2 zeta omega s + omega^2)).

        Parameters
        ----------
        s : complex or ndarray (...) [1/s]

        Returns
        -------
        ndarray (..., n_modes) [m/N]
        """
        s = np.asarray(s)[..., None]
        return 1.0 / (self.mass * (s * (s + 2.0 * self.zeta * self.omega) + self.omega**2))


def receptance(modes, phi, s):
    """Receptance matrix between points: displacement over force.

    Parameters
    ----------
    modes : ModalSystem
    phi : ndarray (..., n_points, n_modes) [1]
        Shapes at the points; leading axes broadcast with those of ``s``.
    s : complex or ndarray (...) [1/s]

    Returns
    -------
    ndarray (..., n_points, n_points) complex [m/N]
    """
    return (phi * modes.mobility(s)[..., None, :]) @ np.swapaxes(phi, -1, -2)


def static_compliance(modes, phi):
    """Sum over modes of phi phi^T / (m omega^2), the static compliance between points.

    Parameters
    ----------
    modes : ModalSystem
    phi : ndarray (..., n_points, n_modes) [1]

    Returns
    -------
    ndarray (..., n_points, n_points) [m/N]
    """
    return (phi / (modes.mass * modes.omega**2)) @ np.swapaxes(phi, -1, -2)


def compliance_moments(modes, phi, orders=2):
    """Taylor coefficients of the receptance about s = 0, which stand for modes far above the frequencies of interest.

    With b = 2 zeta / omega and c = 1 / omega^2 a mode is (1 + b s + c s^2)^-1 / (m omega^2).

    Parameters
    ----------
    modes : ModalSystem
    phi : ndarray (..., n_points, n_modes) [1]
    orders : int
        Number of coefficients after the static one.

    Returns
    -------
    ndarray (orders + 1, ..., n_points, n_points)
        R_j in R_0 + R_1 s + R_2 s^2 + ..., [m/N s^j]. Undamped, R_0 is `static_compliance` and -R_2 its next order in
        omega^2: sum of phi phi^T / (m omega^4).
    """
    b, c = 2.0 * modes.zeta / modes.omega, 1.0 / modes.omega**2
    previous, current = np.zeros_like(modes.omega), 1.0 / (modes.mass * modes.omega**2)
    out = []
    for _ in range(orders + 1):
        out.append((phi * current[..., None, :]) @ np.swapaxes(phi, -1, -2))
        previous, current = current, -b * current - c * previous
    return np.stack(out)
