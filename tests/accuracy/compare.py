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
from .notes import PARTIALS, Note, linear_guitar
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

    `cut_cents` is what the basis alone does and `own_cents` what the measured pole has beyond basis and step (both of
    the reference only, else empty): the latter is what the oracle, cut and stepped alike, does not foretell.
    """

    note: Note
    partials: tuple
    frequencies_hz: np.ndarray
    decay_rates: np.ndarray
    cents: np.ndarray
    decay_errors: np.ndarray
    scheme: Scheme = Scheme("engine")
    cut_cents: np.ndarray = ()
    own_cents: np.ndarray = ()
    own_decay_errors: np.ndarray = ()


def cents_between(found_hz, truth_hz):
    """How far frequencies lie above others, in cents."""
    return 1200.0 * np.log2(np.asarray(found_hz) / truth_hz)


@functools.lru_cache(maxsize=512)
def truth_of(note):
    """The oracle's poles of partials 1 to 8 of a note [rad/s]: tuple, the same for every scheme."""
    guitar, intonation = linear_guitar(note.n_contacts)
    return tuple(oracle_poles(guitar, intonation, note.string, note.fret, note.polarization))


def compare(note, scheme=48000.0):
    """A solver against the oracle for one note: `Comparison`. scheme : `Scheme`, or the engine's sample rate [Hz]."""
    scheme = scheme if isinstance(scheme, Scheme) else Scheme("engine", scheme)
    guitar, intonation = linear_guitar(note.n_contacts)
    guitar = replace(guitar, basis=replace(guitar.basis, bandwidth_hz=scheme.basis_hz))
    truth = np.array(truth_of(note))
    partials = tuple(n for n in PARTIALS if frequency(truth[n - 1]) < guitar.basis.bandwidth_hz)
    truth = truth[[n - 1 for n in partials]]
    if scheme.solver == "engine":
        found = nearest_poles(engine_record(guitar, intonation, note, scheme.rate), scheme.rate, truth)
        more = {}
    else:
        found, more = _reference_poles(guitar, intonation, note, scheme, truth)
    cents = cents_between(found[:, 0], frequency(truth))
    errors = found[:, 1] / decay(truth) - 1.0
    return Comparison(note, partials, frequency(truth), decay(truth), cents, errors, scheme, **more)


def _reference_poles(guitar, intonation, note, scheme, truth):
    system = note_system(guitar, intonation, note)
    cut = cut_poles(system, truth, scheme.basis_hz)
    foretold = cut_poles(system, truth, scheme.basis_hz, scheme.step)
    found = nearest_poles(*reference_record(guitar, intonation, note, scheme.step), foretold)
    more = {
        "cut_cents": cents_between(frequency(cut), frequency(truth)),
        "own_cents": cents_between(found[:, 0], frequency(foretold)),
        "own_decay_errors": found[:, 1] / decay(foretold) - 1.0,
    }
    return found, more


def note_system(guitar, intonation, note):
    """The oracle's system in which a note's poles are: all strings in Y, its own string in Z."""
    only = note.string if note.polarization == "Z" else None
    return oracle_system(guitar, intonation, {note.string: note.fret}, note.polarization, only)


def limits(n_contacts, partial):
    """What the project demands: cents and relative decay rate; None where it demands nothing."""
    if n_contacts > 3:
        return None
    if n_contacts > 1:
        return (0.3, 0.06) if partial <= 5 else None
    return (0.05 if partial <= 5 else 0.3), 0.01


def broken_limits(result):
    """The limits that a `Comparison` breaks, in words: list of str, empty if all is well."""
    words = []
    for n, cents, loss in zip(result.partials, result.cents, result.decay_errors, strict=True):
        allowed = limits(result.note.n_contacts, n)
        if allowed and not abs(cents) <= allowed[0]:
            words.append(f"{result.note}, partial {n}: {cents:+.3f} cents, legal {allowed[0]:g}")
        if allowed and not abs(loss) <= allowed[1]:
            words.append(f"{result.note}, partial {n}: decay {100 * loss:+.2f} %, legal {100 * allowed[1]:g} %")
    return words


def nearest_poles(record, sample_rate, truth):
    """The measured pole nearest to each of ``truth`` [rad/s]: (n, 2), hertz and 1/s."""
    rows = []
    for pole in truth:
        width = float(np.clip(2.0 * decay(pole), 50.0, 150.0))
        options = {"half_width_hz": width, "decay_guesses": [decay(pole)]}
        rows.append(poles_from_records(record, sample_rate, [frequency(pole)], **options)[0])
    return np.array(rows)
