"""The body at the bridge as modes: a `Body` enters, a modal system and its shapes at the strings' bridge points leave
(Eqs. 21-30, Table I; between the two ends of the bridge shapes are interpolated linearly)."""

import numpy as np

from .modes import ModalSystem


def body_modes(body):
    """Modes of a `Body` as a `ModalSystem`."""
    return ModalSystem(
        mass=np.array(body.modal_masses, float),
        omega=2.0 * np.pi * np.array(body.frequencies_hz, float),
        zeta=np.array(body.damping_ratios, float),
    )


def bridge_ends(body):
    """Shapes at the bass and at the treble end: ndarray (2, n_modes) [1]."""
    return np.array([body.shapes_bass, body.shapes_treble], float)


def end_weights(positions):
    """How much of the bass and of the treble end each bridge position sees.

    Parameters
    ----------
    positions : float or ndarray (...) [1]
        0 at the bass end, 1 at the treble end.

    Returns
    -------
    ndarray (..., 2) [1]
        (1 - position, position). The same weights share a string's bridge force out to the two ends.
    """
    positions = np.asarray(positions, float)
    return np.stack([1.0 - positions, positions], axis=-1)


def bridge_shapes(guitar):
    """Body shapes at the bridge points of the strings: ndarray (n_strings, n_modes) [1], the Phi_B of Eqs. 42-47."""
    return end_weights([string.bridge_position for string in guitar.strings]) @ bridge_ends(guitar.body)
