"""Poles measured in either solver's own motion beside the oracle's: a note enters, errors in cents and of decay leave.

One way of measuring for both: the bridge's forces after the same two plucks, all six strings there, the others open;
exponents from the records of free motion (`measure.poles_from_records`), the ones nearest to where they must be.
"""

import functools
from dataclasses import dataclass, replace

import numpy as np
from measure import poles_from_records
from oracle import decay, frequency

from .engine_records import engine_record
from .notes import PARTIALS, Note, setting
from .reference_records import reference_record
from .truth import cut_poles, oracle_poles, oracle_system

PAPER_STEP = 1e-5  # s, the paper's; so is the basis of 10 kHz


@dataclass(frozen=True)
class Scheme:
    """Which solver, at which sample rate [Hz] (engine) or step [s] (reference), with a basis to which frequency [Hz]."""

    solver: str
    rate: float = 48000.0
    step: float = PAPER_STEP
    basis_hz: float = 10e3

    def __str__(self):
        if self.solver == "engine":
            return f"engine, {self.rate / 1e3:g} kHz"
        return f"reference, {self.step * 1e6:g} us"


PAPER = Scheme("reference")


@dataclass(frozen=True)
class Comparison:
    """Partial by partial (those of `PARTIALS` within the basis): oracle [Hz, 1/s], solver minus oracle [cents, 1].

    Each pole of the oracle has one partner in the solver. The engine's is the nearest. The reference's is further away,
    and others (dead lengths, strings in unison) may be nearer: its partner is the one that the oracle's pole becomes
    when the modes beyond the basis fade and time falls into steps (`truth.cut_poles`); ``nearest`` has the errors of
    the pole that happens to be nearest, the kindest reading. ``cut`` is what the basis alone does, ``own`` what the
    measured poles have beyond what the oracle, cut and stepped alike, foretells: nothing, if all is right.
    """

    note: Note
    partials: tuple
    frequencies_hz: np.ndarray
    decay_rates: np.ndarray
    cents: np.ndarray
    decay_errors: np.ndarray
    scheme: Scheme = Scheme("engine")
    nearest: tuple = ()
    cut: tuple = ()
    own: tuple = ()

    @property
    def distances(self):
        """Distance of the poles in the complex plane over their frequency, in cents: pitch and decay in one number."""
        return self._distance(self.cents, self.decay_errors)

    @property
    def nearest_distances(self):
        """The same for the nearest poles."""
        return self._distance(*self.nearest) if self.nearest else self.distances

    @property
    def step_distances(self):
        """Distance of the reference's poles from those of the oracle with the same basis: what the step alone does."""
        return self._distance(self.cents - self.cut[0], self.decay_errors - self.cut[1])

    @property
    def cut_distances(self):
        """Distance of the cut oracle's poles from the oracle's: what the basis alone does."""
        return self._distance(*self.cut)

    def _distance(self, cents, decay_errors):
        turned = 1200.0 / np.log(2.0) * decay_errors * self.decay_rates / (2.0 * np.pi * self.frequencies_hz)
        return np.hypot(cents, turned)


def cents_between(found_hz, truth_hz):
    """How far frequencies lie above others, in cents."""
    return 1200.0 * np.log2(np.asarray(found_hz) / truth_hz)


@functools.lru_cache(maxsize=512)
def truth_of(note):
    """The oracle's poles of partials 1 to 8 of a note [rad/s]: tuple, the same for every scheme."""
    guitar, intonation, placed = setting(note)
    return tuple(oracle_poles(guitar, intonation, placed.string, note.fret, note.polarization))


def compare(note, scheme=48000.0):
    """A solver against the oracle for one note: `Comparison`. scheme : `Scheme`, or the engine's sample rate [Hz]."""
    scheme = scheme if isinstance(scheme, Scheme) else Scheme("engine", scheme)
    guitar, intonation, placed = setting(note)
    guitar = replace(guitar, basis=replace(guitar.basis, bandwidth_hz=scheme.basis_hz))
    truth = np.array(truth_of(note))
    partials = tuple(n for n in PARTIALS if frequency(truth[n - 1]) < guitar.basis.bandwidth_hz)
    truth = truth[[n - 1 for n in partials]]
    if scheme.solver == "engine":
        found = nearest_poles(engine_record(guitar, intonation, placed, scheme.rate), scheme.rate, truth)
        more = {}
    else:
        found, more = _reference_poles(guitar, intonation, placed, scheme, truth)
    return Comparison(note, partials, frequency(truth), decay(truth), *errors(found, truth), scheme, **more)


def as_rows(found):
    """Poles [rad/s] as measured ones are written: (k, 2), hertz and 1/s."""
    return np.stack([frequency(found), decay(found)], axis=1)


def errors(found, truth):
    """Cents and relative error of the decay rate of measured poles (k, 2) beside `truth` [rad/s]."""
    return cents_between(found[:, 0], frequency(truth)), found[:, 1] / decay(truth) - 1.0


def _reference_poles(guitar, intonation, note, scheme, truth):
    system = note_system(guitar, intonation, note)
    foretold = cut_poles(system, truth, scheme.basis_hz, scheme.step)
    record = reference_record(guitar, intonation, note, scheme.step)
    found = nearest_poles(*record, foretold)
    more = {
        "nearest": errors(nearest_poles(*record, truth), truth),
        "cut": errors(as_rows(cut_poles(system, truth, scheme.basis_hz)), truth),
        "own": errors(found, foretold),
    }
    return found, more


def note_system(guitar, intonation, note):
    """The oracle's system in which a note's poles are: all strings in Y, its own string in Z."""
    only = note.string if note.polarization == "Z" else None
    return oracle_system(guitar, intonation, {note.string: note.fret}, note.polarization, only)


def nearest_poles(record, sample_rate, truth):
    """The measured pole nearest to each of ``truth`` [rad/s]: (n, 2), hertz and 1/s."""
    rows = []
    for pole in truth:
        width = float(np.clip(2.0 * decay(pole), 50.0, 150.0))
        options = {"half_width_hz": width, "decay_guesses": [decay(pole)]}
        rows.append(poles_from_records(record, sample_rate, [frequency(pole)], **options)[0])
    return np.array(rows)
