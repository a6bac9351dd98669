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
    start, duration : float [s]
    offset, speed : ndarray (n_rows,) [m], [m/s]
        d and d' at the start.
    """

    start: float
    duration: float
    offset: np.ndarray
    speed: np.ndarray

    @classmethod
    def none(cls, system):
        """Nothing lands: all constraints hold from the beginning."""
        nil = np.zeros(len(system.A))
        return cls(0.0, 1.0, nil, nil)

    @classmethod
    def of(cls, system, motion, arrived, start, duration):
        """Contacts number ``arrived`` land at ``start`` on strings that move as ``motion`` (3, n) says."""
        first, count = 2 * len(system.modes), len(system.points)
        landing = np.zeros(len(system.A), bool)
        for k in arrived:
            landing[[first + k, first + count + k]] = True
        offset, speed = system.A @ motion[0], system.A @ motion[1]
        return cls(start, duration, np.where(landing, offset, 0.0), np.where(landing, speed, 0.0))

    def offsets(self, times):
        """d(t): ndarray (n_times, n_rows) [m]."""
        u, on = self._progress(times)
        stay, go = (2.0 * u - 3.0) * u**2 + 1.0, self.duration * u * (u - 1.0) ** 2
        return on * (stay * self.offset + go * self.speed)

    def accelerations(self, times):
        """b = d''(t): ndarray (n_times, n_rows) [m/s^2]."""
        u, on = self._progress(times)
        stay, go = 12.0 * u - 6.0, self.duration * (6.0 * u - 4.0)
        return on * (stay * self.offset + go * self.speed) / self.duration**2

    def _progress(self, times):
        u = ((times - self.start) / self.duration)[:, None]
        return u, (u >= 0.0) & (u <= 1.0)
