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
    """A solver with its sample rate [Hz] (engine) or step [s] (reference), and the frequency [Hz] its basis goes to."""

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

    The solver's pole is the one nearest to the oracle's, for either solver: the kindest reading where a dead length, an
    open string or a finger's own mode is near too. `theory` is there of the reference if it was asked for.
    """

    note: Note
    partials: tuple
    frequencies_hz: np.ndarray
    decay_rates: np.ndarray
    cents: np.ndarray
    decay_errors: np.ndarray
    scheme: Scheme = Scheme("engine")
    theory: object = None

    @property
    def distances(self):
        """Distance of the poles in the complex plane over their frequency, in cents: pitch and decay in one number."""
        return self.distance(self.cents, self.decay_errors)

    def distance(self, cents, decay_errors):
        """The same of other errors of these partials: ndarray (partials,) [cents]."""
        turned = 1200.0 / np.log(2.0) * decay_errors * self.decay_rates / (2.0 * np.pi * self.frequencies_hz)
        return np.hypot(cents, turned)


@dataclass(frozen=True)
class Theory:
    """What the oracle foretells of the reference's poles; each a pair of arrays: cents, relative errors of the decay.

    cut : the oracle with the same basis, in continuous time, against the oracle: what the basis does.
    followed : measured poles against the oracle, each the one that the oracle's becomes when the modes beyond the basis
    fade and time falls into steps (`truth.cut_poles`).
    step : those against the oracle with the same basis: what the step does.
    own : those against the oracle cut and stepped alike: nothing, if reference and oracle are right.
    """

    cut: tuple
    followed: tuple
    step: tuple
    own: tuple


def cents_between(found_hz, truth_hz):
    """How far frequencies lie above others, in cents."""
    return 1200.0 * np.log2(np.asarray(found_hz) / truth_hz)


@functools.lru_cache(maxsize=512)
def truth_of(note):
    """The oracle's poles of partials 1 to 8 of a note [rad/s]: tuple, the same for every scheme."""
    guitar, intonation, placed = setting(note)
    return tuple(oracle_poles(guitar, intonation, placed.string, note.fret, note.polarization))


def compare(note, scheme=48000.0, theory=False):
    """A solver against the oracle for one note: `Comparison`.

    scheme : `Scheme`, or the engine's sample rate [Hz]. theory : also what the oracle foretells (reference only).
    """
    scheme = scheme if isinstance(scheme, Scheme) else Scheme("engine", scheme)
    guitar, intonation, placed = setting(note)
    guitar = replace(guitar, basis=replace(guitar.basis, bandwidth_hz=scheme.basis_hz))
    truth = np.array(truth_of(note))
    partials = tuple(n for n in PARTIALS if frequency(truth[n - 1]) < guitar.basis.bandwidth_hz)
    truth = truth[[n - 1 for n in partials]]
    if scheme.solver == "engine":
        record = engine_record(guitar, intonation, placed, scheme.rate), scheme.rate
    else:
        record = reference_record(guitar, intonation, placed, scheme.step)
    found = nearest_poles(*record, truth)
    foretold = None
    if theory and scheme.solver == "reference":
        foretold = _theory(record, note_system(guitar, intonation, placed), truth, scheme)
    return Comparison(
        note, partials, frequency(truth), decay(truth), *errors(found, truth), scheme=scheme, theory=foretold
    )


def _theory(record, system, truth, scheme):
    cut = cut_poles(system, truth, scheme.basis_hz)
    foretold = cut_poles(system, truth, scheme.basis_hz, scheme.step)
    found = nearest_poles(*record, foretold)
    against = (errors(found, poles) for poles in (truth, cut, foretold))
    return Theory(errors(as_rows(cut), truth), *against)


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
    return np.array([_nearest(record, sample_rate, pole) for pole in truth])


def _nearest(record, sample_rate, pole):
    width = float(np.clip(2.0 * decay(pole), 50.0, 150.0))
    for widen in (1.0, 2.0, 4.0):
        options = {"half_width_hz": widen * width, "decay_guesses": [decay(pole)]}
        try:
            return poles_from_records(record, sample_rate, [frequency(pole)], **options)[0]
        except ValueError as error:  # no pole so near
            missing = error
    raise missing
