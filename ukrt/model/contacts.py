"""Where strings are held: fingers and dampers at places enter, held points with mass, damping and stiffness leave, the
same in both polarizations (Eqs. 31-41)."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class HeldPoint:
    """One point of a string that a finger holds: y_string(place) = y_finger.

    Attributes
    ----------
    place : float [m]
        From the nut.
    mass, damping, stiffness : float [kg], [N s/m], [N/m]
        Of the finger there, a one-mode system with shape 1 (Eqs. 36-41). No mass and no stiffness: a pure damper.
    rigid : bool
        The finger does not move at all (Eqs. 31-35).
    """

    place: float
    mass: float = 0.0
    damping: float = 0.0
    stiffness: float = 0.0
    rigid: bool = False

    @property
    def has_mode(self):
        """Whether the finger adds a modal coordinate of its own."""
        return not self.rigid and self.mass > 0.0

    @property
    def is_damper(self):
        """Whether it only takes energy, without mass or stiffness."""
        return not self.rigid and self.mass == 0.0

    def receptance(self, s):
        """Displacement over force of the finger, 1 / (m s^2 + c s + k) [m/N]; zero where it is rigid.

        Parameters
        ----------
        s : complex or ndarray [1/s]
        """
        if self.rigid:
            return np.zeros_like(np.asarray(s, complex))
        return 1.0 / (s * (self.mass * s + self.damping) + self.stiffness)


def held_by_finger(finger, place):
    """Points at which ``finger`` holds a string when its first contact (offset 0) stands at ``place`` [m].

    Parameters
    ----------
    finger : ukrt.model.parameters.Finger
    place : float [m]

    Returns
    -------
    tuple of HeldPoint
    """
    return tuple(HeldPoint(place + c.offset, c.mass, c.damping, c.stiffness, c.rigid) for c in finger.contacts)


def held_by_damper(damper, string):
    """Points at which the damping hand holds ``string``, with its damping as a multiple of sqrt(T0 rho S)."""
    damping = damper.damping_ratio * string.wave_impedance
    return tuple(HeldPoint(place * string.length, damping=damping) for place in damper.places)
