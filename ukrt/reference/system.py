"""What the reference solver integrates: a guitar and what holds its strings enter; masses, stiffnesses, losses,
constraint rows and the Moore-Penrose inverse of B = A M^-1/2 leave (Eqs. 5-15, 42-47)."""

from dataclasses import dataclass

import numpy as np

from ..model.constraints import dense_system
from ..model.strings import string_modes

RANK_TOLERANCE = 1e-13  # of the largest singular value of B: rows that say the same twice count once


@dataclass(frozen=True)
class ReferenceSystem:
    """M q'' + C q' + K q = f + f_nl(q) under A q'' = b, for one set of held points.

    Attributes
    ----------
    mass, stiffness : ndarray (n,) [kg], [N/m]
        Diagonals of M and K (Eq. 44).
    loss : ndarray (n,) [N s/m]
        Diagonal of C.
    dampers : ndarray (n_dampers, n) [sqrt(N s/m)]
        Rows sqrt(c) phi of pure dampers: C = diag(loss) + dampers^T dampers.
    A : ndarray (n_rows, n) [1]
        Constraint rows (Eq. 47).
    B_plus : ndarray (n, n_rows) [kg^1/2]
        Moore-Penrose inverse of B = A M^-1/2 (Eq. 3).
    compliance : ndarray (n_rows, n_rows) [kg]
        (B B^T)^+, so that B^+ = B^T (B B^T)^+.
    strings_y, strings_z : tuple of slice
    body, fingers_y, fingers_z : slice
    modes : tuple of ukrt.model.strings.StringModes
    points : tuple of (int, ukrt.model.contacts.HeldPoint)
        String and point of each contact that has a row, in the order of the rows.
    finger_of : tuple of int or None
        Number of each such point's oscillator; None where it is rigid.
    """

    mass: np.ndarray
    stiffness: np.ndarray
    loss: np.ndarray
    dampers: np.ndarray
    A: np.ndarray
    B_plus: np.ndarray
    compliance: np.ndarray
    strings_y: tuple
    strings_z: tuple
    body: slice
    fingers_y: slice
    fingers_z: slice
    modes: tuple
    points: tuple
    finger_of: tuple

    @property
    def count(self):
        """Number of modal coordinates."""
        return len(self.mass)

    def shape(self, string, place, direction):
        """Row phi with y(place) = phi q: ndarray (n,) [1]; ``place`` in metres, ``direction`` Y or Z."""
        row = np.zeros(self.count)
        row[(self.strings_y if direction == "Y" else self.strings_z)[string]] = self.modes[string].shape(place)
        return row


def make_system(guitar, held):
    """Assemble the constrained system.

    Parameters
    ----------
    guitar : ukrt.model.parameters.Guitar
        Its strings' tensions are taken as they stand.
    held : sequence (n_strings,) of sequences of ukrt.model.contacts.HeldPoint

    Returns
    -------
    ReferenceSystem
    """
    dense = dense_system(guitar, held)
    modes = tuple(string_modes(string, guitar.basis.bandwidth_hz) for string in guitar.strings)
    all_points = [(n, point) for n, row in enumerate(held) for point in row]
    rows, loss = [], np.diag(dense.damping).copy()
    for n, point in all_points:
        for where in (dense.strings_y[n], dense.strings_z[n]) if point.is_damper else ():
            row = np.zeros(len(loss))
            row[where] = np.sqrt(point.damping) * modes[n].shape(point.place)
            rows.append(row)
            loss -= row**2
    points = tuple((n, point) for n, point in all_points if not point.is_damper)
    with_mode = np.cumsum([point.has_mode for _, point in points])
    finger_of = tuple(int(k) - 1 if p.has_mode else None for k, (_, p) in zip(with_mode, points, strict=True))
    B_plus, compliance = moore_penrose(dense.A / np.sqrt(dense.mass))
    return ReferenceSystem(
        mass=dense.mass,
        stiffness=dense.stiffness,
        loss=np.maximum(loss, 0.0),
        dampers=np.array(rows).reshape(-1, len(loss)),
        A=dense.A,
        B_plus=B_plus,
        compliance=compliance,
        strings_y=dense.strings_y,
        strings_z=dense.strings_z,
        body=dense.body,
        fingers_y=dense.fingers_y,
        fingers_z=dense.fingers_z,
        modes=modes,
        points=points,
        finger_of=finger_of,
    )


def moore_penrose(B):
    """The Moore-Penrose inverse of a wide matrix, and that of B B^T, from the singular values.

    Parameters
    ----------
    B : ndarray (n_rows, n)

    Returns
    -------
    B_plus : ndarray (n, n_rows)
    compliance : ndarray (n_rows, n_rows)
        (B B^T)^+.
    """
    u, singular, vt = np.linalg.svd(B, full_matrices=False)
    inverse = np.zeros_like(singular)
    np.divide(1.0, singular, out=inverse, where=singular > RANK_TOLERANCE * singular[0])
    return (vt.T * inverse) @ u.T, (u * inverse**2) @ u.T
