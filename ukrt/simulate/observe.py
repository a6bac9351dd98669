"""What is kept of a run of the engine: its arrays are read out sample by sample and go, in SI, to the collector."""

import numpy as np

from ..engine import layout as at
from ..experiment.quantities import ENERGY_PARTS, Collector, with_total
from ..model.body import body_modes
from ..model.strings import residual_compliance, string_modes
from .readout import add_energies, read_forces, read_positions

KEPT_AT_ONCE = 256  # samples between two visits to the collector
REDUNDANT = 1e-11  # of the largest singular value: two ports at one place count once


class EngineObserver(Collector):
    """Reads an instance before and after each kept sample.

    Parameters
    ----------
    case : ukrt.experiment.case.Case
    d, i : ndarray
        The instance, filled.
    interval : float [s]
        Between two kept samples.
    """

    def __init__(self, case, d, i, interval):
        super().__init__(case)
        self.case, self._d, self._i, self._interval = case, d, i, interval
        guitar = case.instrument
        self._count = len(guitar.strings)
        self._modes = [string_modes(string, guitar.basis.bandwidth_hz) for string in guitar.strings]
        tiles = [self._tiles_of(s) for s in range(self._count)]
        moves = KEPT_AT_ONCE if {"displacement", "amplitudes"} & set(self.about) else 0
        self._drift = np.zeros(KEPT_AT_ONCE)
        self._strings = np.zeros((moves, max(tile.stop for tile in tiles), 8))
        self._body = np.zeros((moves, body_modes(guitar.body).count))
        self._forces, self._rises = np.zeros((2, KEPT_AT_ONCE, self._count))
        self._energies = np.zeros((KEPT_AT_ONCE if "energies" in self.about else 0, len(ENERGY_PARTS)))
        self._row, self._first, self._ports, self._points = 0, 0, None, None

    def before(self, ports_may_have_changed):
        """Just before the engine advances from a kept sample."""
        if ports_may_have_changed and "displacement" in self.about:
            self._follow_ports()
        read_positions(self._d, self._i, self._row, self._drift, self._strings, self._body)
        add_energies(self._d, self._i, self._row, self._energies)

    def after(self):
        """Just after it has advanced by one sample."""
        read_forces(self._d, self._row, self._forces, self._rises)
        add_energies(self._d, self._i, self._row, self._energies)
        self._row += 1
        if self._row == KEPT_AT_ONCE:
            self.flush()

    def flush(self):
        """Hand what has been read to the collector."""
        n, self._row = self._row, 0
        ways = {
            "drift": lambda: self._drift[:n].copy(),
            "bridge_force": lambda: self._forces[:n].copy(),
            "displacement": lambda: self._displacement(n),
            "energies": lambda: with_total(self._energies[:n].T.copy()),
            "tension": lambda: self._rises[:n] + [string.tension for string in self.case.instrument.strings],
            "amplitudes": lambda: self._amplitudes(n),
        }
        if n:
            times = self._interval * np.arange(self._first, self._first + n)
            self.add(times, {name: ways[name]() for name in self.about})
        self._first += n
        self._energies[:] = 0.0

    def _tiles_of(self, s):
        own_i = at.STRING_I + s * at.STRING_I_SIZE
        first = int(self._i[own_i + at.SI_TILE])
        return slice(first, first + int(self._i[own_i + at.SI_TILES]))

    def _coefficients(self, s):
        """The coefficient tiles of string ``s``: ndarray (n_tiles, COEF_TILE), a view."""
        tiles = self._tiles_of(s)
        return self._d[at.COEF : at.COEF + at.COEF_TILE * tiles.stop].reshape(-1, at.COEF_TILE)[tiles]

    def _roots(self, s):
        """sqrt(g) of each mode: ndarray (n_modes,) [m^(1/2) N^(-1/2)]; at the bridge every shape is 1 or -1."""
        bridge = self._coefficients(s)[:, at.COEF_COLUMNS : at.COEF_COLUMNS + at.TILE]
        return np.abs(bridge.ravel()[: self._modes[s].count])

    def _amplitudes(self, n):
        """q = sqrt(g) x of the modes of the basis: strings in Y, in Z, body."""
        out = []
        for lanes in (slice(0, 4), slice(4, 8)):
            for s in range(self._count):
                x = self._strings[:n, self._tiles_of(s), lanes].reshape(n, -1)
                out.append(x[:, : self._modes[s].count] * self._roots(s))
        modes = body_modes(self.case.instrument.body)
        a, b = (self._d[base : base + modes.count] for base in (at.BODY_A, at.BODY_B))
        out.append(self._body[:n] * np.sqrt((1.0 - a - b) / (modes.mass * modes.omega**2)))
        return np.concatenate(out, axis=1)

    def _displacement(self, n):
        columns = []
        for point, weights in zip(self.case.record.displacement, self._points, strict=True):
            lanes = slice(0, 4) if point.direction == "Y" else slice(4, 8)
            x = self._strings[:n, self._tiles_of(self.case.string_number(point.string)), lanes]
            # einsum, since the last bit of a matrix product's row depends on how many rows there are
            columns.append(np.einsum("nm,m->n", x.reshape(n, -1), weights))
        return np.array(columns).T

    def _follow_ports(self):
        """Where bridge, fingers and pluck act may have changed, and with it what the pseudo-modes stand for."""
        strings = self._d[at.STRING : at.STRING + self._count * at.STRING_D_SIZE].reshape(self._count, -1)
        words = self._i[at.STRING_I : at.STRING_I + self._count * at.STRING_I_SIZE].reshape(self._count, -1)
        places = strings[:, at.S_PORT_X : at.S_PORT_X + at.COLUMNS]
        ports = [tuple(row[:n]) for row, n in zip(places, words[:, at.SI_PORTS], strict=True)]
        if ports != self._ports:
            self.flush()
            self._ports = ports
            self._points = [self._weights(point) for point in self.case.record.displacement]

    def _weights(self, point):
        """Weights of a string's x in the displacement of a point: sqrt(g) sin(p x) of the modes of the basis, and of
        the pseudo-modes what they carry at the ports, continued along the string with the shape of least energy."""
        s = self.case.string_number(point.string)
        string, basis = self.case.instrument.strings[s], self.case.instrument.basis.bandwidth_hz
        place, ports = point.place * string.length, np.array(self._ports[s])
        static, _ = residual_compliance(string, basis, [*ports, place])
        share = np.linalg.pinv(static[:-1, :-1], REDUNDANT) @ static[:-1, -1]
        tiles = self._coefficients(s)
        columns = tiles[:, at.COEF_COLUMNS :].reshape(len(tiles), -1, at.TILE)[:, : len(ports)]
        weights = np.einsum("tpl,p->tl", columns, share).ravel()  # right for pseudo-modes, overwritten for the others
        count = self._modes[s].count
        weights[:count] = self._roots(s) * self._modes[s].shape(place)
        return weights
