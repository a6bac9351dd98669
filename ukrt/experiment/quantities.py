"""What a run records, the same for every solver: names, units and columns come from the case; a solver brings values.

`Collector` gathers them piece by piece; nothing here knows how they were computed.
"""

import numpy as np

from ..model.body import body_modes
from ..model.strings import string_modes
from .result import Quantity

# Sums over all strings and contacts; "stretch" is the energy of Kirchhoff-Carrier, ES/(8 L) (int y_x^2 + z_x^2 dx)^2.
ENERGY_PARTS = ("strings Y", "strings Z", "body", "fingers Y", "fingers Z", "stretch")


def wanted(case):
    """The quantities that a case asks for: dict of str to (unit, columns), in the order in which results have them.

    Parameters
    ----------
    case : ukrt.experiment.case.Case
    """
    record, names = case.record, tuple(string.name for string in case.instrument.strings)
    about = {"drift": ("m", ())}
    if record.bridge_force:
        about["bridge_force"] = "N", names
    if record.displacement:
        about["displacement"] = "m", tuple(point_label(point) for point in record.displacement)
    if record.energies:
        about["energies"] = "J", (*ENERGY_PARTS, "total")
    if record.tension:
        about["tension"] = "N", names
    if record.amplitudes:
        about["amplitudes"] = "m", mode_labels(case.instrument)
    return about


def point_label(point):
    """A recorded point in words, such as ``E2 Y 0.9 L``."""
    return f"{point.string} {point.direction} {point.place:g} L"


def mode_labels(guitar):
    """Names of the modal coordinates of strings and body, in the order of Eq. 42 (tuple of str)."""
    labels = []
    for direction in "YZ":
        for string in guitar.strings:
            count = string_modes(string, guitar.basis.bandwidth_hz).count
            labels += [f"{string.name} {direction} {n + 1}" for n in range(count)]
    return (*labels, *(f"body {n + 1}" for n in range(body_modes(guitar.body).count)))


def with_total(parts):
    """The energies of `ENERGY_PARTS`, ndarrays (n_times,) [J], as columns with their sum: (n_times, n_parts + 1)."""
    return np.array([*parts, sum(parts)]).T


class Collector:
    """Gathers the quantities of a run.

    Attributes
    ----------
    about : dict of str to (unit, columns)
        What is wanted.
    largest_drift : float [m]
        How far the constraints were missed at worst.
    """

    def __init__(self, case):
        self.about, self.largest_drift = wanted(case), 0.0
        self._times, self._parts = [], {name: [] for name in self.about}

    def add(self, times, values):
        """Kept samples: times (n,) [s], and ``values``, a dict of every wanted name to ndarray (n, ...)."""
        self._times.append(times)
        self.largest_drift = max(self.largest_drift, float(np.max(values["drift"], initial=0.0)))
        for name, parts in self._parts.items():
            parts.append(values[name])

    @property
    def times(self):
        """Times of everything so far: ndarray (n_times,) [s]."""
        return np.concatenate([np.empty(0), *self._times])

    def quantities(self):
        """Everything so far: dict of str to Quantity."""
        return {name: Quantity(np.concatenate(self._parts[name]), *about) for name, about in self.about.items()}
