"""Poles of the engine beside those of the oracle: a string, a fret and a finger enter, both sets of poles leave.

The engine's come from its own compiled loop: a note is stopped by the gesture PRESS, plucked within two samples, and
let ring; what is analysed are the strings' forces on the bridge. The oracle has modes to 400 kHz in continuous time.
All six strings are there in both, the others open. Import with ``tests`` on the path, as pytest has it.
"""

import functools
from dataclasses import dataclass, replace

import numpy as np
from measure import poles_from_records
from oracle import ContactData, bridge_residues, decay, frequency, make_system, poles, string_partials

from ukrt.engine import gestures
from ukrt.engine import layout as at
from ukrt.engine.discretize import fill_instance, make_arrays
from ukrt.engine.kernels.advance import advance
from ukrt.engine.kernels.hands import perform
from ukrt.model.intonation import make_intonation
from ukrt.model.presets import load_preset

FINGERS = {1: "paper", 3: "classical"}  # contacts -> the preset whose finger it is
FRETS = (0, 1, 5, 7, 12, 19)
PARTIALS = (1, 2, 3, 4, 5, 8)
SECONDS = 2.0  # the same to four digits as with 4 s and every string's force by itself
PLUCKS = (0.23, 0.41)  # of the sounding span from the bridge: no node of partials 1 to 8
HEARD_AT = 0.15  # of the string from the bridge: the pluck that decides which of two mixed poles is the note's
TEST_PLUCK = 1.0  # N


@dataclass(frozen=True)
class Note:
    """String index, fret (0: open, no contact), how many contacts the finger has, and the direction Y or Z."""

    string: int
    fret: int
    n_contacts: int = 0
    polarization: str = "Y"

    def __str__(self):
        where = "open" if self.fret == 0 else f"fret {self.fret}, {self.n_contacts} contact(s)"
        return f"{'EADGBe'[self.string]} {where}, {self.polarization}"


@dataclass(frozen=True)
class Comparison:
    """Partial by partial (those of `PARTIALS` within the basis): oracle [Hz, 1/s], engine minus oracle [cents, 1]."""

    note: Note
    partials: tuple
    frequencies_hz: np.ndarray
    decay_rates: np.ndarray
    cents: np.ndarray
    decay_errors: np.ndarray


@functools.lru_cache(maxsize=8)
def linear_guitar(n_contacts):
    """The `classical` guitar, linear, with the finger of that many contacts; and its intonation."""
    guitar = load_preset("classical")
    finger = load_preset(FINGERS[n_contacts or 3]).finger
    strings = tuple(replace(string, axial_stiffness=0.0) for string in guitar.strings)
    guitar = replace(guitar, strings=strings, finger=finger)
    assert n_contacts in (0, len(finger.contacts))
    return guitar, make_intonation(guitar)


def fretted_contacts(guitar, place):
    """The guitar's finger at ``place`` [m], as the oracle's records."""
    return tuple(ContactData(place + c.offset, c.mass, c.damping, c.stiffness, c.rigid) for c in guitar.finger.contacts)


def oracle_system(guitar, intonation, held, polarization="Y", only=None):
    """The oracle's system of ``guitar`` at its intonation; held : {string: fret}; only : one string alone, or all."""
    strings = tuple(replace(one, tension=float(t)) for one, t in zip(guitar.strings, intonation.tensions, strict=True))
    contacts = {s: fretted_contacts(guitar, float(intonation.places[s, fret])) for s, fret in held.items() if fret}
    tuned = replace(guitar, strings=strings)
    return make_system(tuned, contacts, None if only is None else [only], polarization)


def oracle_poles(guitar, intonation, string, fret, polarization="Y"):
    """Poles [rad/s] of partials 1 to 8 of one note, the other strings open: ndarray (8,).

    Another string in unison may take a label on the way; of the labelled pole and the one that Newton reaches from
    the string alone on the body, the one is meant that a pluck makes louder at the bridge.
    """
    count = max(PARTIALS)
    alone = oracle_system(guitar, intonation, {string: fret}, polarization, string)
    found = string_partials(alone, 0, count)
    if polarization == "Z":  # on a rigid bridge no string knows of another
        return found
    whole = oracle_system(guitar, intonation, {string: fret})
    candidates = np.array([string_partials(whole, string, count), poles(whole, found)])
    place = (1.0 - HEARD_AT) * guitar.strings[string].length
    if fret:
        place = max(place, 0.5 * (guitar.strings[string].length + float(intonation.places[string, fret])))
    loud = np.array([np.abs(bridge_residues(whole, row, string, place) / row) for row in candidates])
    return candidates[np.argmax(loud, axis=0), np.arange(count)]


def engine_record(guitar, intonation, note, sample_rate, seconds=SECONDS):
    """Bridge forces after two plucks side by side [N]: the own string's and the other strings' sum, (samples, 4).

    In Z it is the constraint force of the note's own string, the others have none: (samples, 2).
    """
    d, i = make_arrays()
    own, length, runs = note.string, guitar.strings[note.string].length, []
    for share in PLUCKS:
        fill_instance(d, i, guitar, intonation, sample_rate)
        place = 0.0
        if note.fret:
            place = float(intonation.places[own, note.fret])
            perform(d, i, gestures.PRESS, own, place, 1.0, 0.0, 0.0)
            advance(d, i, at.CHUNK)
        angle = 0.0 if note.polarization == "Y" else 0.5 * np.pi
        pluck = 1.0 - share * (1.0 - place / length)
        perform(d, i, gestures.PLUCK, own, pluck, TEST_PLUCK, angle, 2.0)
        advance(d, i, at.CHUNK)
        assert i[at.H_BUSY] == 0, "a gesture is still under way"
        count = int(seconds * sample_rate)
        runs.append(_forces_y(d, i, count, own) if note.polarization == "Y" else _forces_z(d, i, count, own))
    return np.concatenate(runs, axis=1)


def _forces_y(d, i, count, string):
    out = np.empty((count // at.CHUNK, at.CHUNK, at.LANES))
    forces = d[at.STRINGS_OUT : at.STRINGS_OUT + at.CHUNK * at.LANES].reshape(at.CHUNK, at.LANES)
    for block in out:
        advance(d, i, at.CHUNK)
        block[:] = forces
    out = out.reshape(-1, at.LANES)
    return np.stack([out[:, string], out.sum(axis=1) - out[:, string]], axis=1)


def _forces_z(d, i, count, string):
    out = np.empty((count, 1))
    for k in range(count):
        advance(d, i, 1)
        out[k] = d[at.LAM_Z + string]
    return out


def compare(note, sample_rate=48000.0):
    """Engine against oracle for one note: `Comparison`."""
    guitar, intonation = linear_guitar(note.n_contacts)
    truth = oracle_poles(guitar, intonation, note.string, note.fret, note.polarization)
    partials = tuple(n for n in PARTIALS if frequency(truth[n - 1]) < guitar.basis.bandwidth_hz)
    truth = truth[[n - 1 for n in partials]]
    record = engine_record(guitar, intonation, note, sample_rate)
    found = nearest_poles(record, sample_rate, truth)
    cents = 1200.0 * np.log2(found[:, 0] / frequency(truth))
    return Comparison(note, partials, frequency(truth), decay(truth), cents, found[:, 1] / decay(truth) - 1.0)


def limits(n_contacts, partial):
    """What the project demands: cents and relative decay rate; None for partial 8 with three contacts."""
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
