"""Fingers that land on a string in motion: constraints whose right-hand side b is not nil (Eq. 2).

A finger arrives at rest and unloaded, so that it brings no energy: the constraint begins as
y_string - y_finger = d(t) with d the string's own displacement and velocity there, and d goes to nothing as a cubic
Hermite polynomial over the finger's landing time. Then A q'' = d''.
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Landing:
    """The offsets d(t) of all constraint rows.

    Attributes
    ----------
    start : ndarray (n_rows,) [s]
        When each row's finger came; minus infinity where it was always there.
    duration : float [s]
    offset, speed : ndarray (n_rows,) [m], [m/s]
        d and d' at the start.
    """

    start: np.ndarray
    duration: float
    offset: np.ndarray
    speed: np.ndarray

    @classmethod
    def none(cls, system, duration):
        """Nothing lands: all constraints hold from the beginning."""
        nil = np.zeros(len(system.A))
        return cls(nil - np.inf, duration, nil, nil)

    def onto(self, system, motion, stays, time):
        """The landings once the held points have changed: those that stay go on, the others begin at ``time``.

        Parameters
        ----------
        system : ukrt.reference.system.ReferenceSystem
            With the points that are held now.
        motion : ndarray (3, n)
            Its motion; fingers that arrive are at rest.
        stays : dict of int to int
            Point of the new system to the same point of the old one.
        time : float [s]

        Returns
        -------
        Landing
        """
        offset, speed = system.A @ motion[0], system.A @ motion[1]
        start, bridges = np.full(len(system.A), time), 2 * len(system.modes)
        new, old = np.arange(bridges), np.arange(bridges)
        for half in range(2):
            new = np.append(new, [bridges + half * len(system.points) + k for k in stays])
            n_old = (len(self.start) - bridges) // 2
            old = np.append(old, [bridges + half * n_old + k for k in stays.values()])
        new, old = new.astype(int), old.astype(int)
        start[new], offset[new], speed[new] = self.start[old], self.offset[old], self.speed[old]
        return Landing(start, self.duration, offset, speed)

    def offsets(self, times):
        """d(t): ndarray (n_times, n_rows) [m]."""
        u, on = self._progress(times)
        stay, go = (2.0 * u - 3.0) * u**2 + 1.0, self.duration * u * (u - 1.0) ** 2
        return np.where(on, stay * self.offset + go * self.speed, 0.0)

    def accelerations(self, times, step):
        """b of A q'' = b: ndarray (n_times, n_rows) [m/s^2].

        The second difference of d, not its second derivative: Verlet then takes the constraints along d to round-off.
        """
        if not (self.offset.any() or self.speed.any()):
            return np.zeros((len(times), len(self.offset)))
        before, now, after = (self.offsets(times + k * step) for k in (-1, 0, 1))
        first = np.abs(np.asarray(times)[:, None] - self.start) < 0.5 * step
        before = np.where(first, after - 2.0 * step * self.speed, before)  # so that Verlet starts with the speed
        return (before - 2.0 * now + after) / step**2

    def _progress(self, times):
        u = (np.asarray(times)[:, None] - self.start) / self.duration
        on = (u > -1e-9) & (u < 1.0)
        return np.where(on, u, 0.0), on
