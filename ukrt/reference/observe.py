"""What is kept of a run of the reference: modal motion of some steps enters, the quantities that the case asks for go
to the collector."""

import numpy as np

from ..experiment.quantities import Collector, with_total


class Observer(Collector):
    """Computes the quantities of a run from modal motion, and collects them.

    Parameters
    ----------
    case : ukrt.experiment.case.Case
    """

    def __init__(self, case):
        super().__init__(case)
        self.case = case

    def start(self, system, motion):
        """The sample at time nil, before the first step."""
        nothing = np.zeros((1, len(system.A)))
        self._keep(system, np.zeros(1), motion[:1], motion[1:2], nothing, nothing)

    def observe(self, system, times, q, v, forces, landing):
        """Kept steps: times (n,), q and v (n, modes), constraint forces (n, rows), and the landing under way."""
        if len(times):
            self._keep(system, times, q, v, forces, landing.offsets(times))

    def _keep(self, system, times, q, v, forces, offsets):
        count = len(system.modes)
        ways = {
            "drift": lambda: np.max(np.abs(q @ system.A.T - offsets), axis=1, initial=0.0),
            "bridge_force": lambda: -forces[:, :count],
            "displacement": lambda: q @ self._points(system).T,
            "energies": lambda: _energies(system, q, v),
            "tension": lambda: self._tension(system, q),
            "amplitudes": lambda: q[:, : system.body.stop].copy(),
        }
        self.add(times, {name: ways[name]() for name in self.about})

    def _points(self, system):
        """Rows phi of the recorded points: ndarray (n_points, n) [1]."""
        rows = []
        for point in self.case.record.displacement:
            string = self.case.string_number(point.string)
            rows.append(system.shape(string, point.place * system.modes[string].length, point.direction))
        return np.array(rows)

    def _tension(self, system, q):
        rise = [modes.tension_rise(q[:, y], q[:, z]) for modes, y, z in _strings(system)]
        return np.array(rise).T + [string.tension for string in self.case.instrument.strings]


def _strings(system):
    return zip(system.modes, system.strings_y, system.strings_z, strict=True)


def _energies(system, q, v):
    """Eq. 50 for strings, body and fingers, and the energy of stretching."""
    energy = 0.5 * (system.stiffness * q**2 + system.mass * v**2)
    strings_y = sum(energy[:, on].sum(axis=1) for on in system.strings_y)
    strings_z = sum(energy[:, on].sum(axis=1) for on in system.strings_z)
    fingers_y, fingers_z = energy[:, system.fingers_y].sum(axis=1), energy[:, system.fingers_z].sum(axis=1)
    body, stretch = energy[:, system.body].sum(axis=1), np.zeros(len(q))
    for modes, on_y, on_z in _strings(system):
        if modes.axial_stiffness > 0.0:
            stretch += 0.5 * modes.tension_rise(q[:, on_y], q[:, on_z]) ** 2 * modes.length / modes.axial_stiffness
    return with_total((strings_y, strings_z, body, fingers_y, fingers_z, stretch))
