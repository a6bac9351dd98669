"""Stiff damped strings as modes: a `String` and a bandwidth enter; wavenumbers, frequencies, dampings, masses, shapes,
and what Kirchhoff-Carrier tension needs leave (Eqs. 16-20, 48, 49)."""

from dataclasses import dataclass, replace

import numpy as np

from ..units import cents_to_ratio
from .modes import ModalSystem, compliance_moments, static_compliance

REFERENCE_HZ = 400e3  # "infinitely many" modes: all that follow to 4 MHz move E4 by another 0.02 cents only


@dataclass(frozen=True)
class StringModes(ModalSystem):
    """Modes of one polarization of a string, pinned at the nut and free at the bridge; Y and Z are alike.

    Attributes
    ----------
    p : ndarray (n_modes,) [1/m]
        Wavenumbers (2n - 1) pi / 2L.
    kappa : ndarray (n_modes,) [1/m]
        p^2 L / 2, so that the integral of y_x^2 over the string is sum kappa q^2.
    length, axial_stiffness : float [m], [N]
    """

    p: np.ndarray
    kappa: np.ndarray
    length: float
    axial_stiffness: float

    def shape(self, x):
        """Shapes sin(p x) (Eq. 19).

        Parameters
        ----------
        x : float or ndarray (...) [m]
            Places from the nut.

        Returns
        -------
        ndarray (..., n_modes) [1]
        """
        return np.sin(np.asarray(x, float)[..., None] * self.p)

    def tension_rise(self, q_y, q_z=0.0):
        """Dynamic tension ES/(2L) sum kappa (q_Y^2 + q_Z^2) [N] of modal displacements (Eqs. 17, 20)."""
        stretch = np.sum(self.kappa * (np.square(q_y) + np.square(q_z)), axis=-1)
        return self.axial_stiffness / (2.0 * self.length) * stretch

    def tension_force(self, q_y, q_z=0.0):
        """Modal forces -kappa T_dyn q [N] of the dynamic tension on Y (Eq. 20); exchange the arguments for Z."""
        return -self.kappa * np.expand_dims(self.tension_rise(q_y, q_z), -1) * q_y


def string_modes(string, bandwidth_hz):
    """Modes of ``string`` up to and including ``bandwidth_hz``."""
    return string_modes_range(string, 0.0, bandwidth_hz)


def string_modes_range(string, f_from, f_to):
    """Modes of ``string`` with frequencies above ``f_from`` and up to ``f_to`` [Hz].

    Parameters
    ----------
    string : ukrt.model.parameters.String
    f_from, f_to : float [Hz]

    Returns
    -------
    StringModes
    """
    return numbered_modes(string, mode_count(string, f_from), mode_count(string, f_to))


def numbered_modes(string, after, last, tension=None):
    """Modes number ``after`` + 1 to ``last`` of ``string``.

    Parameters
    ----------
    string : ukrt.model.parameters.String
    after, last : int
    tension : ndarray (...) [N], optional
        Other tensions than its own; they become the leading axes of ``omega`` and ``zeta``.

    Returns
    -------
    StringModes
    """
    p = (2.0 * np.arange(after + 1, last + 1) - 1.0) * np.pi / (2.0 * string.length)
    tension = string.tension if tension is None else np.asarray(tension, float)[..., None]
    bending = string.bending_stiffness * p**2
    omega = np.sqrt(tension / string.linear_density) * p * (1.0 + bending / (2.0 * tension))
    losses = tension * (string.loss_internal + string.loss_air / omega) + string.loss_bending * bending
    return StringModes(
        mass=np.full(len(p), string.linear_density * string.length / 2.0),
        omega=omega,
        zeta=0.5 * losses / (tension + bending),
        p=p,
        kappa=p**2 * string.length / 2.0,
        length=string.length,
        axial_stiffness=string.axial_stiffness,
    )


def residual_compliance(string, bandwidth_hz, places, reference_hz=REFERENCE_HZ):
    """What the modes between ``bandwidth_hz`` and ``reference_hz`` leave at ``places`` when they are cut.

    Parameters
    ----------
    string : ukrt.model.parameters.String
    bandwidth_hz, reference_hz : float [Hz]
    places : ndarray (n_places,) [m]

    Returns
    -------
    static : ndarray (n_places, n_places) [m/N]
        Sum of phi phi^T / (m omega^2).
    inertial : ndarray (n_places, n_places) [m s^2/N]
        Sum of phi phi^T / (m omega^4): the receptance is static + omega^2 inertial + ...
    """
    cut = string_modes_range(string, bandwidth_hz, max(bandwidth_hz, reference_hz))
    phi = cut.shape(places)
    return static_compliance(cut, phi), static_compliance(cut, phi / cut.omega)


def residual_moments(string, bandwidth_hz, places, orders=4, reference_hz=REFERENCE_HZ):
    """`compliance_moments` of the modes between ``bandwidth_hz`` and ``reference_hz``, damping included."""
    cut = string_modes_range(string, bandwidth_hz, max(bandwidth_hz, reference_hz))
    return compliance_moments(cut, cut.shape(places), orders)


def ideal_open_hz(string):
    """Fundamental c_T / 2L of the flexible string between rigid ends [Hz]."""
    return string.wave_speed / (2.0 * string.length)


def retuned(string, cents):
    """The same string with its tension changed so that a flexible one would sound ``cents`` higher."""
    return replace(string, tension=string.tension * cents_to_ratio(2.0 * cents))


def mode_count(string, hz):
    """Number of modes up to and including ``hz``: Eq. 48, a cubic, solved for p and then checked on mode numbers."""
    if hz <= 0.0:
        return 0
    cubic, target = string.bending_stiffness / (2.0 * string.tension), 2.0 * np.pi * hz / string.wave_speed
    if cubic > 0.0:  # p + cubic p^3 = target, by Cardano in hyperbolic form
        scale = 2.0 / np.sqrt(3.0 * cubic)
        p = scale * np.sinh(np.arcsinh(1.5 * target * np.sqrt(3.0 * cubic)) / 3.0)
    else:
        p = target
    guess = int(p * string.length / np.pi + 0.5)
    numbers = np.arange(max(guess - 1, 1), guess + 3)
    below = numbered_modes(string, numbers[0] - 1, numbers[-1]).omega <= 2.0 * np.pi * hz
    return int(numbers[0] - 1 + np.count_nonzero(below))
