"""Plucked strings in closed form, to compare runs with: flexible strings between rigid ends, and what stiffness and a
truncated basis do to the fundamental."""

import numpy as np

from ..model.strings import string_modes

_MODES = 20000  # their energies fall with n^2 or faster: the rest is below 1e-4


def static_work(string, span, place, force):
    """Energy that a force has brought in when it has bent a flexible string slowly.

    Parameters
    ----------
    string : ukrt.model.parameters.String
    span : tuple of float [m]
        The two rigid ends, from the nut.
    place : float [m]
        Of the force, from the nut.
    force : float [N]

    Returns
    -------
    float [J]
        F^2 a b / (2 T0 (a + b)), with a and b the distances to the ends.
    """
    a, b = place - span[0], span[1] - place
    return force**2 * a * b / (2.0 * string.tension * (a + b))


def ramp_work(string, span, place, force, duration):
    """The same when the force rises linearly in ``duration`` [s] and then vanishes: its modes are not in equilibrium.

    A mode that a force F t / tau drives from rest has at tau the energy
    F^2 phi^2 / (2 m w^2) [(1 - sin a / a)^2 + ((1 - cos a) / a)^2], a = w tau.
    """
    length = span[1] - span[0]
    p = np.arange(1, _MODES + 1) * np.pi / length
    mass, omega = 0.5 * string.linear_density * length, p * string.wave_speed
    angle = omega * duration
    share = (1.0 - np.sin(angle) / angle) ** 2 + ((1.0 - np.cos(angle)) / angle) ** 2
    return float(np.sum(force**2 * np.sin(p * (place - span[0])) ** 2 * share / (2.0 * mass * omega**2)))


def static_tension_rise(string, place, force):
    """Kirchhoff-Carrier tension of an open flexible string bent slowly by a force: (ES / 2) p (1 - p) (F / T0)^2 [N],
    ``place`` p as a fraction of the length."""
    return 0.5 * string.axial_stiffness * place * (1.0 - place) * (force / string.tension) ** 2


def first_order_shift(string, place, force):
    """How much higher an open string begins, plucked in one plane, to first order in the tension's rise [Hz].

    The mean rise is half the static one, V; mode 1 follows its own part of it, V1, half as much again:
    df / f = (V + V1 / 2) / (2 T0), V1 / V = (2 / pi^2) sin^2(pi p) / (p (1 - p)).
    """
    mean = 0.5 * static_tension_rise(string, place, force)
    own = mean * 2.0 / np.pi**2 * np.sin(np.pi * place) ** 2 / (place * (1.0 - place))
    fundamental = string.wave_speed / (2.0 * string.length)
    return fundamental * (mean + 0.5 * own) / (2.0 * string.tension)


def held_fundamental(string, bandwidth_hz):
    """Fundamental of a string whose truncated nut-pinned, bridge-free modes are held at the bridge, undamped [Hz].

    The first root of sum phi_n(L)^2 / (m (w_n^2 - w^2)) = 0, which lies between the first two w_n.
    """
    modes = string_modes(string, bandwidth_hz)
    low, high = modes.omega[0], modes.omega[1]
    for _ in range(60):
        middle = 0.5 * (low + high)
        if np.sum(1.0 / (modes.omega**2 - middle**2)) < 0.0:  # it rises from minus to plus infinity
            low = middle
        else:
            high = middle
    return float(0.25 * (low + high) / np.pi)
