"""The whole guitar as one dense constrained system: strings, body and held points enter; mass, damping and stiffness of
all modal coordinates and the constraint rows of A q'' = 0 leave (Eqs. 7-15, 21-47). Readable rather than fast: for
tests and for reference solutions."""

from dataclasses import dataclass

import numpy as np

from .body import body_modes, bridge_shapes
from .strings import string_modes


@dataclass(frozen=True)
class DenseSystem:
    """M q'' + C q' + K q = f with A q = 0, q = [q_Y, q_Z, q_B, q_FY, q_FZ] as in Eqs. 42-47.

    Attributes
    ----------
    mass, stiffness : ndarray (n,) [kg], [N/m]
        Diagonals of M and K.
    damping : ndarray (n, n) [N s/m]
        Diagonal but for pure dampers, which act on the strings directly.
    A : ndarray (n_rows, n) [1]
        Rows: bridge in Y (one a string), bridge in Z, contacts in Y, contacts in Z.
    strings_y, strings_z : tuple of slice
        Coordinates of each string.
    body, fingers_y, fingers_z : slice
        Coordinates of the body and of the oscillating contacts.
    """

    mass: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray
    A: np.ndarray
    strings_y: tuple
    strings_z: tuple
    body: slice
    fingers_y: slice
    fingers_z: slice


def dense_system(guitar, held, bandwidth_hz=None):
    """Build the coupled system of ``guitar``.

    Parameters
    ----------
    guitar : ukrt.model.parameters.Guitar
        Its strings' tensions are taken as they stand.
    held : sequence (n_strings,) of sequences of ukrt.model.contacts.HeldPoint
        What holds each string.
    bandwidth_hz : float, optional
        Of the string modes; by default that of the guitar.

    Returns
    -------
    DenseSystem
    """
    bandwidth_hz = guitar.basis.bandwidth_hz if bandwidth_hz is None else bandwidth_hz
    strings = [string_modes(string, bandwidth_hz) for string in guitar.strings]
    body = body_modes(guitar.body)
    points = [(n, point) for n, row in enumerate(held) for point in row]
    fingers = [point for _, point in points if point.has_mode]
    sizes = [m.count for m in strings] * 2 + [body.count, len(fingers), len(fingers)]
    ends = np.cumsum([0, *sizes])
    slices = [slice(int(a), int(b)) for a, b in zip(ends[:-1], ends[1:], strict=True)]
    count = len(strings)
    on_y, on_z, on_body, on_fingers = slices[:count], slices[count : 2 * count], slices[-3], slices[-2:]

    mass, stiffness, damping = np.zeros(ends[-1]), np.zeros(ends[-1]), np.zeros((ends[-1], ends[-1]))
    for where, modes in zip([*on_y, *on_z, on_body], [*strings, *strings, body], strict=True):
        mass[where], stiffness[where] = modes.mass, modes.mass * modes.omega**2
        damping[where, where] = np.diag(2.0 * modes.zeta * modes.omega * modes.mass)
    for where in on_fingers:
        mass[where] = [point.mass for point in fingers]
        stiffness[where] = [point.stiffness for point in fingers]
        damping[where, where] = np.diag([point.damping for point in fingers])
    for n, point in points:
        if point.is_damper:
            phi = strings[n].shape(point.place)
            for where in (on_y[n], on_z[n]):
                damping[where, where] += point.damping * np.outer(phi, phi)

    rows = _bridge_rows(guitar, strings, on_y, on_body, ends[-1]) + _bridge_rows(guitar, strings, on_z, None, ends[-1])
    for on_string, on_finger in zip((on_y, on_z), on_fingers, strict=True):
        rows += _contact_rows(points, strings, on_string, on_finger, ends[-1])
    return DenseSystem(mass, stiffness, damping, np.array(rows), tuple(on_y), tuple(on_z), on_body, *on_fingers)


def _bridge_rows(guitar, strings, on_string, on_body, size):
    """Y_s(L) - Y_body(r_s) = 0, or Z_s(L) = 0 where ``on_body`` is None (Eqs. 21-30)."""
    shapes, rows = bridge_shapes(guitar), []
    for n, modes in enumerate(strings):
        row = np.zeros(size)
        row[on_string[n]] = modes.shape(modes.length)
        if on_body is not None:
            row[on_body] = -shapes[n]
        rows.append(row)
    return rows


def _contact_rows(points, strings, on_string, on_finger, size):
    """Y_s(x_f) = 0 for rigid points (Eqs. 31-35), Y_s(x_f) - Y_f = 0 for oscillators (Eqs. 36-41)."""
    rows, finger = [], on_finger.start
    for n, point in points:
        if point.is_damper:
            continue
        row = np.zeros(size)
        row[on_string[n]] = strings[n].shape(point.place)
        if point.has_mode:
            row[finger] = -1.0
            finger += 1
        rows.append(row)
    return rows
