"""Putting a guitar in tune: a `Guitar` enters; tensions of its open strings and places of the finger for every fret
leave, so that each note's string-like pole on the coupled guitar has the frequency that its scale asks for.

Solved in continuous time with the strings' modes to 400 kHz (`coupling`), body coupled, the other strings damped, at
small amplitude, for partial 1 of the motion in Y; in Z, where the bridge does not move, the same note lies some cents
beside it. On the line s = -sigma + i omega_target the unknowns are sigma and one knob: the tension of an open string,
the place of a fretted one. Where a body mode is near, several solutions exist and the slowest decaying is meant; where
it is so near and so strongly coupled that no setting puts the slower pole there (a wolf note), the nearest is chosen.
"""

from dataclasses import dataclass, replace

import numpy as np

from ..errors import ParameterError
from ..units import cents_to_ratio, ratio_to_cents
from .coupling import SPLIT_HZ, Bridge, Characteristic, HeldString
from .fingerboard import fingerboard
from .parameters import Basis, Radiation
from .poles import slowest_pole, stopped, with_tensions
from .strings import REFERENCE_HZ, ideal_open_hz, retuned

COARSE_HZ = 20e3  # modes for the search; the solution is then polished with all modes
STARTS = (0.5, 3.0, 8.0, 20.0)  # decay rates 1/s to start from: 0.5 free string, 20 a strongly damped body mode
LARGEST_MOVE = np.array([8.0, 40.0])  # 1/s and cents in one step of the search
FARTHEST = 300.0  # cents between a note and the knob's starting value beyond which a solution is not believed
WOLF_CENTS = np.arange(-60.0, 61.0, 2.0)  # settings that are tried where none is in tune: not as far as the next fret
CLEARANCE = 2e-3  # m that the finger's last contact keeps from the nut
MOST_KNOWN = 32  # intonations that a process remembers
IN_TUNE = 1e-3  # cents between the slowest pole and the note


@dataclass(frozen=True)
class Intonation:
    """How a guitar is set.

    Attributes
    ----------
    tensions : ndarray (n_strings,) [N]
    places : ndarray (n_strings, frets + 1) [m]
        Of the finger's first contact, from nut or capo (and frets from there); column 0, the open string, is 0.
    cents_left : ndarray (n_strings, frets + 1) [cents]
        How far the slowest pole of each note is from where it should be.
    decay_rates : ndarray (n_strings, frets + 1) [1/s]
        sigma of that pole.
    """

    tensions: np.ndarray
    places: np.ndarray
    cents_left: np.ndarray
    decay_rates: np.ndarray


def make_intonation(guitar):
    """Solve (or, in mode ``published``, only describe) the intonation of ``guitar``.

    Parameters
    ----------
    guitar : ukrt.model.parameters.Guitar

    Returns
    -------
    Intonation
        Arrays are shared between calls and read-only.
    """
    plain = what_counts(guitar)
    found = _known.get(plain)
    if found is None:
        found = _solve(plain)
        remember(plain, found)
    return found


def what_counts(guitar):
    """The guitar without anything that its intonation does not depend on (Guitar)."""
    return replace(guitar, name="", description="", radiation=Radiation(""), basis=Basis())


_known = {}


def is_known(plain):
    """Whether what `what_counts` gave has been solved before (bool)."""
    return plain in _known


def remember(plain, intonation):
    """Let this be the intonation of what `what_counts` gave; the first of many is forgotten."""
    for array in (intonation.tensions, intonation.places, intonation.cents_left, intonation.decay_rates):
        array.setflags(write=False)
    while len(_known) >= MOST_KNOWN:
        _known.pop(next(iter(_known)), None)
    _known[plain] = intonation


def _solve(guitar):
    board = fingerboard(guitar)
    options = {
        "others": "damped" if guitar.damper.places else "absent",
        "split_hz": max(SPLIT_HZ, 5.0 * float(board.hz.max())),
    }
    equal = guitar.tuning.mode == "equal"
    tensions = _open_tensions(board, options) if equal else np.array([_as_given(one) for one in guitar.strings])
    tuned = with_tensions(board.guitar, tensions)
    bridge = Bridge(tuned, **options)
    rows = [_one_string(tuned, bridge, board, n, equal) for n in range(len(tuned.strings))]
    return Intonation(tensions, *(np.array(column) for column in zip(*rows, strict=True)))


def _as_given(string):
    return string.tension * cents_to_ratio(2.0 * string.fine_tune)


def _open_tensions(board, options):
    """Tensions [N] that put all open strings in tune together: each depends a little on the others through the body."""
    guitar = board.guitar
    strings = list(guitar.strings)
    for n, one in enumerate(strings):
        _retune(strings, n, ratio_to_cents(board.hz[n, 0] / ideal_open_hz(one)))
    rates = [None] * len(strings)
    for _ in range(8):
        guitar = replace(guitar, strings=tuple(strings))
        bridge, moved = Bridge(guitar, **options), 0.0
        for n in range(len(strings)):
            cents, _, rates[n] = _tune(_OpenString(guitar, bridge, board, n), rates[n])
            _retune(strings, n, float(cents[0]))
            moved = max(moved, abs(float(cents[0])))
        if moved < 1e-5:
            break
    return np.array([one.tension for one in strings])


def _retune(strings, n, cents):
    """Change string ``n`` in place; a pitch that no legal tension gives is refused by the name of its note."""
    try:
        strings[n] = retuned(strings[n], cents)
    except ParameterError as error:
        words = f"on this string it would need a tension of {error.value:.3g} N, and {error.legal}"
        raise ParameterError(f"strings.{n}.note", strings[n].note, words) from None


def _one_string(guitar, bridge, board, string, equal):
    """Row of places, of remaining cents and of decay rates of one string."""
    note = _OpenString(guitar, bridge, board, string)
    left, rate = _heard(note, np.zeros(1), near=None if equal else note.expected(np.zeros(1)))
    places, cents, rates = [np.zeros(1)], [left], [rate]
    if board.frets:
        note = _FrettedString(guitar, bridge, board, string)
        if equal:
            setting, left, rate = _tune(note)
        else:
            setting = np.zeros(board.frets)
            left, rate = _heard(note, setting, near=note.expected(setting))
        places, cents, rates = [*places, note.places(setting)], [*cents, left], [*rates, rate]
    return np.concatenate(places), np.concatenate(cents), np.concatenate(rates)


class _Note:
    """What open and stopped notes of a string share."""

    def expected(self, cents):
        """Angular frequency [rad/s] that a flexible string of the free length would have."""
        return np.pi * self.string.wave_speed / self.free_length(cents)


class _OpenString(_Note):
    """An open string whose knob is its tension, in cents of a flexible string's pitch."""

    def __init__(self, guitar, bridge, board, string):
        self.bridge, self.index, self.string = bridge, string, guitar.strings[string]
        self.omega = 2.0 * np.pi * board.hz[string, :1]

    def free_length(self, cents, notes=None):
        return np.full(len(cents), self.string.length)

    def characteristic(self, cents, hz=REFERENCE_HZ, notes=None):
        """F(s) at one setting for each s, with modes to ``hz``; ``notes`` tells which note each one is."""
        tension = self.string.tension * cents_to_ratio(2.0 * np.asarray(cents))
        return Characteristic(
            self.bridge, self.index, HeldString(self.string, (), None, tension, self.bridge.split_hz, hz)
        )


class _FrettedString(_Note):
    """All stopped notes of a string; the knob is the finger's place, in cents of the length that is left."""

    def __init__(self, guitar, bridge, board, string):
        self.guitar, self.bridge, self.index, self.string = guitar, bridge, string, guitar.strings[string]
        self.omega = 2.0 * np.pi * board.hz[string, 1:]
        self.ideal = board.ideal[string, 1:]
        behind = min(contact.offset for contact in guitar.finger.contacts)
        self.longest = self.string.length + behind - CLEARANCE

    def free_length(self, cents, notes=None):
        ideal = self.ideal if notes is None else self.ideal[notes]
        return np.minimum((self.string.length - ideal) * cents_to_ratio(-np.asarray(cents)), self.longest)

    def places(self, cents, notes=None):
        return self.string.length - self.free_length(cents, notes)

    def characteristic(self, cents, hz=REFERENCE_HZ, notes=None):
        """F(s) at one setting for each s, with modes to ``hz``; ``notes`` tells which note each one is."""
        held = stopped(self.guitar, self.index, self.places(cents, notes), self.bridge.split_hz, hz)
        return Characteristic(self.bridge, self.index, held)


def _tune(note, rate=None):
    """Knob settings [cents] that put the slowest pole of every note on its frequency, what is left [cents] and the
    decay rates [1/s]; ``rate`` is a guess of these."""
    every = np.arange(len(note.omega))
    cents = np.zeros(len(every))
    if rate is None:
        starts, notes = np.repeat(STARTS, len(every)), np.tile(every, len(STARTS))
        rate, cents, found = _on_line(note, notes, starts, np.zeros(len(starts)), COARSE_HZ, 12)
        usable = found & (np.abs(cents) < FARTHEST) & (rate > -1e-3)
        rank = np.where(usable, rate, np.inf).reshape(len(STARTS), -1)
        best = np.argmin(rank, axis=0) * len(every) + every
        rate, cents = np.where(usable, rate, 3.0)[best], np.where(usable, cents, 0.0)[best]
    rate, cents, found = _on_line(note, every, rate, cents, REFERENCE_HZ, 8)
    cents = np.where(found & (np.abs(cents) < FARTHEST), cents, 0.0)
    left, rate = _heard(note, cents, rate)
    for n in np.flatnonzero(~(np.abs(left) < IN_TUNE)):
        cents[n], left[n], rate[n] = _least_wolf(note, n)
    return cents, left, rate


def _on_line(note, notes, rate, cents, hz, steps):
    """Newton's method for the real unknowns (sigma, knob) of F(-sigma + i omega, knob) = 0, many at once."""
    omega, dc, found = note.omega[notes], 1e-3, np.zeros(len(notes), bool)
    rate, cents, active = rate.copy(), cents.copy(), np.arange(len(notes))
    for _ in range(steps):
        s, h = -rate[active] + 1j * omega[active], 1e-7 * omega[active]
        here = note.characteristic(cents[active], hz, notes[active])
        own = here.held.compliance(s)
        value, slower = here.several(s, s - h, own=own)
        by_rate = (slower - value) / h
        moved = note.characteristic(cents[active] + dc, hz, notes[active])
        by_cents = (moved.held.compliance(s) - own) / dc
        with np.errstate(all="ignore"):  # by Cramer's rule: value + by_rate m_0 + by_cents m_1 = 0
            det = (np.conj(by_rate) * by_cents).imag
            move = np.array([-(np.conj(value) * by_cents).imag, -(np.conj(by_rate) * value).imag]) / det
        move = np.nan_to_num(move, nan=0.0, posinf=0.0, neginf=0.0)
        move = np.clip(move, -LARGEST_MOVE[:, None], LARGEST_MOVE[:, None])
        rate[active] += move[0]
        cents[active] += move[1]
        found[active] = np.abs(move[1]) < 1e-2
        active = active[(np.abs(move[1]) > 1e-6) | (np.abs(move[0]) > 1e-6)]
        if not len(active):
            break
    return rate, cents, found


def _heard(note, cents, rate=3.0, notes=None, near=None):
    """Cents between the slowest pole and the note, and its decay rate, at given settings; the pole is looked for beside
    the note or, where it may be far from that, beside ``near`` [rad/s]."""
    omega = note.omega if notes is None else note.omega[notes]
    function, near = note.characteristic(cents, notes=notes), omega if near is None else near
    pole = slowest_pole(function, -rate + 1j * near, note.string, note.free_length(cents, notes))
    return ratio_to_cents(np.abs(pole.imag) / omega), -pole.real


def _least_wolf(note, n):
    """Setting [cents], out of a list, at which the slowest pole of note ``n`` comes nearest to it; cents left, rate."""
    left, rate = _heard(note, WOLF_CENTS, notes=np.full(len(WOLF_CENTS), n))
    best = np.nanargmin(np.abs(left))
    return WOLF_CENTS[best], left[best], rate[best]
