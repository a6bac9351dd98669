"""Admittances of the coupled guitar in the frequency domain: two points and frequencies enter, velocity over force
leaves.

A force F at a is answered by port forces that keep the constraints: with H the receptances of the free subsystems,
q = H (F phi_a - A^T lambda), A q = 0, so D lambda = d_a F with D = A H A^T (`continuous.receptances`) and
d_a = A H phi_a, what the force alone would tear open. Hence Y_ba = s (phi_b H phi_a - d_b D^-1 d_a). No poles, no time
steps, modes of the strings to `System.cut_hz`.
"""

from dataclasses import dataclass

import numpy as np

from .continuous import body_modes, differences, ports, receptances, string_modes
from .loudness import null_vector


@dataclass(frozen=True)
class OnString:
    """A point of a string of the system, `place` [m] from the nut."""

    string: int
    place: float


@dataclass(frozen=True)
class OnBridge:
    """A point of the body's bridge, `position` from 0 (bass end) to 1 (treble end)."""

    position: float


def _starts(system):
    return np.cumsum([0, *(1 + len(c) for c in system.contacts)])


def _string_response(system, point, places, s):
    """Free string: displacement at `places` per force at `point`, (k, places)."""
    string = system.strings[point.string]
    p, omega, loss, mass = string_modes(string, system.cut_hz, system.n_modes)
    second, first, _, _ = (part[:, None] for part in differences(s, system.step))
    inverse = 1.0 / (second + loss * first + omega**2)
    return inverse @ (np.sin(p[:, None] * np.asarray(places, float)) * np.sin(p * point.place)[:, None] / mass)


def _body_response(system, position, positions, s):
    """Free body: displacement at bridge `positions` per force at `position`, (k, positions)."""
    omega2, loss, mass, shapes = body_modes(system.body, (position, *positions))
    second, first, _, _ = (part[:, None] for part in differences(s, system.step))
    inverse = system.bridge_compliance / (second + loss * first + omega2)
    return (inverse * shapes[0] / mass) @ shapes[1:].T


def gap(system, point, s):
    """d = A H phi: what a unit force at `point` would tear open at every port of the system, (k, ports) [m/N]."""
    starts = _starts(system)
    out = np.zeros((s.size, starts[-1]), complex)
    if isinstance(point, OnString):
        places = ports(system.strings[point.string], system.contacts[point.string])
        out[:, starts[point.string] : starts[point.string + 1]] = _string_response(system, point, places, s)
    else:
        positions = tuple(string.bridge_position for string in system.strings)
        out[:, starts[:-1]] = -_body_response(system, point.position, positions, s)
    return out


def _free(system, at, driven, s):
    """phi_b H phi_a: nothing between two strings, or a string and the body, before the constraints."""
    if isinstance(at, OnString) and isinstance(driven, OnString) and at.string == driven.string:
        return _string_response(system, driven, (at.place,), s)[:, 0]
    if isinstance(at, OnBridge) and isinstance(driven, OnBridge):
        return _body_response(system, driven.position, (at.position,), s)[:, 0]
    return np.zeros(s.size, complex)


def admittance(system, at, driven, s):
    """Velocity at one point per force at another: complex (k,) [m/(N s)] at s (k,) [rad/s].

    at, driven : `OnString` or `OnBridge`; the same one twice for the driving-point admittance. Seen through time steps
    where the system has a `step`: the velocity is then s times the displacement all the same.
    """
    s = np.atleast_1d(np.asarray(s, complex))
    matrix = receptances(system, s)[0]
    forces = np.linalg.solve(matrix, gap(system, driven, s)[:, :, None])[:, :, 0]
    return s * (_free(system, at, driven, s) - np.sum(gap(system, at, s) * forces, axis=1))


def bridge_forces(system, driven, s):
    """Force of every string on the body per force at a point: complex (k, strings) [1] at s (k,) [rad/s]."""
    s = np.atleast_1d(np.asarray(s, complex))
    forces = np.linalg.solve(receptances(system, s)[0], gap(system, driven, s)[:, :, None])[:, :, 0]
    return forces[:, _starts(system)[:-1]]


def admittance_residues(system, at, driven, found):
    """Residues of `admittance` at poles (k,) of the system, in continuous time: complex (k,) [m/(N s^2)]."""
    found = np.atleast_1d(np.asarray(found, complex))
    before, after = gap(system, driven, found), gap(system, at, found)
    out = []
    for pole, d_a, d_b in zip(found, before, after, strict=True):
        vector, scale = null_vector(system, pole)
        out.append(-pole * (d_b @ vector) * (vector @ d_a) / scale)
    return np.array(out)
