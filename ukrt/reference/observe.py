"""What is kept of a run: modal motion of some steps enters, the quantities that the case asks for leave."""

import numpy as np

from ..experiment.result import Quantity


class Observer:
    """Collects the quantities of a run.

    Parameters
    ----------
    case : ukrt.experiment.case.Case
    interval : float [s]
        Between two kept samples.
    """

    def __init__(self, case, interval):
        self.case, self.interval, self.largest_drift = case, interval, 0.0
        self.times, self._parts, self._about = np.empty(0), [], {}

    def start(self, system, motion):
        """The sample at time nil, before the first step."""
        rows = len(system.A)
        self._keep(system, np.zeros(1), motion[:1], motion[1:2], np.zeros((1, rows)), np.zeros((1, rows)))

    def add(self, system, times, q, v, forces, landing):
        """Kept steps: times (n,), q and v (n, modes), constraint forces (n, rows), and the landing under way."""
        if len(times):
            self._keep(system, times, q, v, forces, landing.offsets(times))

    def quantities(self):
        """Everything so far: dict of str to Quantity."""
        names = list(self._parts[0])
        return {
            name: Quantity(np.concatenate([part[name] for part in self._parts]), *self._about[name]) for name in names
        }

    def _keep(self, system, times, q, v, forces, offsets):
        record, found = self.case.record, {}
        drift = np.max(np.abs(q @ system.A.T - offsets), axis=1, initial=0.0)
        self.largest_drift = max(self.largest_drift, float(np.max(drift)))
        found["drift"] = drift, "m", ()
        names = tuple(string.name for string in self.case.instrument.strings)
        if record.bridge_force:
            found["bridge_force"] = -forces[:, : len(names)], "N", names
        if record.displacement:
            found["displacement"] = self._displacement(system, q)
        if record.energies:
            found["energies"] = _energies(system, q, v)
        if record.tension:
            rise = [m.tension_rise(q[:, y], q[:, z]) for m, y, z in _strings(system)]
            rest = [string.tension for string in self.case.instrument.strings]
            found["tension"] = np.array(rise).T + rest, "N", names
        if record.amplitudes:
            found["amplitudes"] = q[:, : system.body.stop].copy(), "m", _labels(system, names)
        self._parts.append({name: values for name, (values, *_) in found.items()})
        self._about = {name: tuple(about) for name, (_, *about) in found.items()}
        self.times = np.concatenate([self.times, times])

    def _displacement(self, system, q):
        rows, labels = [], []
        for point in self.case.record.displacement:
            string = self.case.string_number(point.string)
            rows.append(system.shape(string, point.place * system.modes[string].length, point.direction))
            labels.append(point_label(point))
        return q @ np.array(rows).T, "m", tuple(labels)


def point_label(point):
    """A recorded point in words, such as ``E2 Y 0.9 L``."""
    return f"{point.string} {point.direction} {point.place:g} L"


def _strings(system):
    return zip(system.modes, system.strings_y, system.strings_z, strict=True)


def _energies(system, q, v):
    """Eq. 50 for strings, body and fingers; stretch is the energy of Kirchhoff-Carrier beside it, ES/(8 L) (...)^2."""
    energy = 0.5 * (system.stiffness * q**2 + system.mass * v**2)
    strings_y = sum(energy[:, on].sum(axis=1) for on in system.strings_y)
    strings_z = sum(energy[:, on].sum(axis=1) for on in system.strings_z)
    fingers_y, fingers_z = energy[:, system.fingers_y].sum(axis=1), energy[:, system.fingers_z].sum(axis=1)
    body, stretch = energy[:, system.body].sum(axis=1), np.zeros(len(q))
    for modes, on_y, on_z in _strings(system):
        if modes.axial_stiffness > 0.0:
            stretch += 0.5 * modes.tension_rise(q[:, on_y], q[:, on_z]) ** 2 * modes.length / modes.axial_stiffness
    parts = [strings_y, strings_z, body, fingers_y, fingers_z, stretch]
    labels = ("strings Y", "strings Z", "body", "fingers Y", "fingers Z", "stretch", "total")
    return np.array([*parts, sum(parts)]).T, "J", labels


def _labels(system, names):
    """Names of the modal coordinates of strings and body."""
    labels = []
    for direction, slices in (("Y", system.strings_y), ("Z", system.strings_z)):
        for name, on in zip(names, slices, strict=True):
            labels += [f"{name} {direction} {n + 1}" for n in range(on.stop - on.start)]
    return tuple(labels + [f"body {n + 1}" for n in range(system.body.stop - system.body.start)])
