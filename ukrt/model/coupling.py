"""The coupled guitar in the Laplace variable s: strings, what holds them and the body enter; the two compliances whose
sum is zero at the poles of one string on that guitar leave (Eqs. 21-47, motion in Y).

With lambda the force of the bridge on a string, the string's end moves by Y(s) lambda, its receptance between bridge
and held points, the held points eliminated. The body at the string's bridge point, loaded by all other strings, moves
by -Z(s) lambda. The two move as one, so the poles are the zeros of Y(s) + Z(s).
"""

import copy
import functools

import numpy as np

from .body import body_modes, bridge_ends, end_weights
from .contacts import held_by_damper
from .modes import compliance_moments, receptance
from .strings import REFERENCE_HZ, mode_count, numbered_modes

SPLIT_HZ = 8e3  # modes above enter by their moments to s^6, which serves up to a fifth of this: within 1e-4 cents
MOMENTS = 6
OTHERS = ("damped", "open", "absent")


class HeldString:
    """One string, held at some points, as the bridge sees it: low modes one by one, the rest by moments.

    Parameters
    ----------
    string : ukrt.model.parameters.String
    holders : sequence (n_held,) of ukrt.model.contacts.HeldPoint
        What holds it; their places count only where ``places`` is not given.
    places : ndarray (n, n_held) [m], optional
        Where, for each of n values of s.
    tension : ndarray (n,) [N], optional
        Tension for each of n values of s, instead of its own.
    split_hz, reference_hz : float [Hz]
        Modes above the one enter by their moments, modes above the other not at all.
    """

    def __init__(self, string, holders=(), places=None, tension=None, split_hz=SPLIT_HZ, reference_hz=REFERENCE_HZ):
        if places is None:
            places = np.array([point.place for point in holders])
        low, rest = _low_and_high(string, split_hz, reference_hz)
        if tension is not None:
            split, last = low.count, low.count + rest.count
            low, rest = numbered_modes(string, 0, split, tension), numbered_modes(string, split, last, tension)
        points = np.concatenate([np.full((*places.shape[:-1], 1), string.length), places], axis=-1)
        self.holders, self.modes = tuple(holders), low
        self.phi = self.modes.shape(points)
        self.moments = compliance_moments(rest, rest.shape(points), MOMENTS)

    def compliance(self, s):
        """Y(s) at the bridge: ndarray like ``s``, complex [m/N]."""
        return _at_the_bridge(receptance(self.modes, self.phi, s), self.moments, _given_way(self.holders, s), s)

    def at(self, chosen):
        """The same for some of the n values of s: ``chosen`` is an index array or mask over them."""
        part = copy.copy(self)
        if self.phi.ndim > 2:
            part.phi = self.phi[chosen]
        if self.moments.ndim > 3:
            part.moments = self.moments[:, chosen]
        if self.modes.omega.ndim > 1:
            part.modes = copy.copy(self.modes)
            for name in ("omega", "zeta"):
                object.__setattr__(part.modes, name, getattr(self.modes, name)[chosen])
        return part


@functools.lru_cache(maxsize=64)
def _low_and_high(string, split_hz, reference_hz):
    """The modes of a string to ``split_hz`` and the rest, at its own tension."""
    split, last = mode_count(string, split_hz), mode_count(string, max(split_hz, reference_hz))
    return numbered_modes(string, 0, split), numbered_modes(string, split, last)


def _given_way(holders, s):
    """Displacement over force of each of the holders: list of ndarray like ``s`` [m/N]."""
    return [point.receptance(s) for point in holders]


def _at_the_bridge(full, moments, fingers, s):
    """Y(s) at the bridge.

    Parameters
    ----------
    full : ndarray (..., 1 + n_held, 1 + n_held) complex [m/N]
        Receptance of the low modes between bridge and held points; is overwritten.
    moments : sequence of ndarray (..., 1 + n_held, 1 + n_held)
        Of all modes above.
    fingers : sequence (n_held,) of ndarray (...)
        Displacement over force of what holds.
    s : ndarray (...) complex [1/s]
    """
    power = np.ones_like(s)
    for moment in moments:
        full += power[..., None, None] * moment
        power = power * s
    for n, given_way in enumerate(fingers, start=1):
        full[..., n, n] += given_way
    if not fingers:
        return full[..., 0, 0]
    cross = full[..., 1:, 0]
    inner = np.linalg.solve(full[..., 1:, 1:], cross[..., None])[..., 0]
    return full[..., 0, 0] - np.sum(cross * inner, axis=-1)


class Bridge:
    """What the strings of a guitar meet at their bridge points: the body, and through it each other.

    Parameters
    ----------
    guitar : ukrt.model.parameters.Guitar
        With the tensions that hold.
    others : str
        What the other strings do: ``damped`` (held by the guitar's damper), ``open`` or ``absent``.
    split_hz : float [Hz]
        See `HeldString`.
    """

    def __init__(self, guitar, others="damped", split_hz=SPLIT_HZ):
        if others not in OTHERS:
            raise ValueError(f"others is {others!r}, but it must be one of {', '.join(OTHERS)}")
        self.body, self.ends, self.split_hz = body_modes(guitar.body), bridge_ends(guitar.body), split_hz
        self.weights = end_weights([string.bridge_position for string in guitar.strings])
        self.loads, self._others = [], {}
        if others != "absent" and self.body.count:
            held = [held_by_damper(guitar.damper, string) if others == "damped" else () for string in guitar.strings]
            self.loads = [
                HeldString(string, points, split_hz=split_hz)
                for string, points in zip(guitar.strings, held, strict=True)
            ]

    def compliance(self, string, s):
        """Z(s) at the bridge point of ``string``, the body loaded by the other strings.

        Parameters
        ----------
        string : int
        s : ndarray (n,) complex [1/s]

        Returns
        -------
        ndarray (n,) complex [m/N]
        """
        if not self.body.count:
            return np.zeros_like(s)
        body = receptance(self.body, self.ends, s)
        load = self._load(string, s) if len(self.loads) > 1 else np.zeros_like(body)
        (a, b), (c, d) = np.moveaxis(np.eye(2) + body @ load, (-2, -1), (0, 1))
        u, v = np.moveaxis(body @ self.weights[string], -1, 0)
        x, y = self.weights[string]
        return (x * (d * u - b * v) + y * (a * v - c * u)) / (a * d - b * c)

    def _load(self, string, s):
        """What all strings but one ask of the ends of the bridge: ndarray (n, 2, 2) complex [N/m]."""
        if string not in self._others:
            others = [n for n in range(len(self.loads)) if n != string]
            loads = [self.loads[n] for n in others]
            moments = np.stack([one.moments for one in loads], axis=1)[:, :, None]
            self._others[string] = loads, moments, np.array([np.outer(w, w) for w in self.weights[others]])
        loads, moments, shares = self._others[string]
        full = np.stack([receptance(one.modes, one.phi, s) for one in loads])
        fingers = [np.stack(one) for one in zip(*[_given_way(load.holders, s) for load in loads], strict=True)]
        compliance = _at_the_bridge(full, moments, fingers, s)
        return np.sum(shares[:, None] / compliance[..., None, None], axis=0)

    @property
    def body_poles(self):
        """Poles of the body alone, upper half-plane: ndarray (n_modes,) complex [1/s]."""
        return self.body.omega * (-self.body.zeta + 1j * np.sqrt(1.0 - self.body.zeta**2))


class Characteristic:
    """The function F(s) = Y(s) + Z(s) of one string, whose zeros are its poles.

    Parameters
    ----------
    bridge : Bridge
    string : int
    held : HeldString
        That string.
    share : float
        How much of the body there is: 1 the guitar, 0 a rigid bridge.
    """

    def __init__(self, bridge, string, held, share=1.0):
        self.bridge, self.string, self.held, self.share = bridge, string, held, share

    def __call__(self, s):
        return self.several(s)[0]

    def several(self, *sets, own=None):
        """F at several sets of points, each as many as there are settings: list of ndarray (n,) complex.

        ``own`` is the string's compliance at the first set, where it is known.
        """
        values = [self.held.compliance(s) for s in sets] if own is None else [own, *map(self.held.compliance, sets[1:])]
        if not self.share:
            return values
        body = self.bridge.compliance(self.string, np.concatenate(sets)).reshape(len(sets), -1)
        return [value + self.share * part for value, part in zip(values, body, strict=True)]

    def at(self, chosen):
        """The same for some of the values of s."""
        return Characteristic(self.bridge, self.string, self.held.at(chosen), self.share)
