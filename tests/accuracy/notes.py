"""Notes whose poles are compared: a string, a fret and a finger enter, a linear guitar and where it is held leave."""

import functools
from dataclasses import dataclass, replace

from ukrt.model.contacts import held_by_finger
from ukrt.model.intonation import Intonation, make_intonation
from ukrt.model.parameters import Contact, Finger
from ukrt.model.poles import with_tensions
from ukrt.model.presets import load_preset

ALL_FRETS = tuple(range(20))
CONTACTS = (0, 1, 3, 5)
PARTIALS = (1, 2, 3, 4, 5, 8)
PLUCKS = (0.23, 0.41)  # of the sounding span from the bridge: no node of partials 1 to 8
TEST_PLUCK = 1.0  # N
SECONDS = 2.0  # of record; the same to four digits as with 4 s and every string's force by itself

# Figs. 12 and 13 of the paper: the first contact is the string on the fret, the others the soft fingertip behind it.
# The text gives the width, 15 mm, but not the places: evenly spread over it (a choice).
PAPER_TIP = {"mass": 5e-3, "damping": 10.0, "stiffness": 1e4}
FIVE = Finger(
    (Contact(0.0, mass=5e-3, damping=1.0, stiffness=1e6), *(Contact(-0.00375 * n, **PAPER_TIP) for n in range(1, 5)))
)


@dataclass(frozen=True)
class Note:
    """String index, fret (0: open, no contact), how many contacts the finger has, the direction Y or Z, and whether the
    other strings are left out."""

    string: int
    fret: int
    n_contacts: int = 0
    polarization: str = "Y"
    alone: bool = False

    def __str__(self):
        where = "open" if self.fret == 0 else f"fret {self.fret}, {self.n_contacts} contact(s)"
        return f"{'EADGBe'[self.string]} {where}, {self.polarization}{', alone' if self.alone else ''}"


def all_notes(frets=ALL_FRETS, contacts=CONTACTS, strings=range(6), polarization="Y"):
    """Every string open (where 0 is among the contacts) and at every fret with every other number of contacts."""
    fingers = {fret: [n for n in contacts if n] if fret else [n for n in contacts if n == 0] for fret in frets}
    return [Note(s, fret, n, polarization) for n in contacts for s in strings for fret in frets if n in fingers[fret]]


@functools.lru_cache(maxsize=8)
def linear_guitar(n_contacts):
    """The `classical` guitar, linear, with the finger of that many contacts; and its intonation.

    One contact is the paper's finger, three the classical preset's, five `FIVE`. The damping hand never touches a
    string here, and it is absent where it would not fit beside five contacts.
    """
    guitar = load_preset("classical")
    finger = {0: guitar.finger, 1: load_preset("paper").finger, 3: guitar.finger, 5: FIVE}[n_contacts]
    damper = guitar.damper if n_contacts < 5 else replace(guitar.damper, places=())
    strings = tuple(replace(string, axial_stiffness=0.0) for string in guitar.strings)
    guitar = replace(guitar, strings=strings, finger=finger, damper=damper)
    assert n_contacts in (0, len(finger.contacts))
    return guitar, make_intonation(guitar)


def setting(note):
    """Guitar and intonation for a note, and the note as they count strings (its own is 0 where it is alone)."""
    guitar, intonation = linear_guitar(note.n_contacts)
    if not note.alone:
        return guitar, intonation, note
    only = slice(note.string, note.string + 1)
    parts = {name: getattr(intonation, name)[only] for name in ("tensions", "places", "cents_left", "decay_rates")}
    return replace(guitar, strings=guitar.strings[only]), Intonation(**parts), replace(note, string=0)


def note_place(intonation, note):
    """Where the finger's first contact stands [m from the nut]; 0 for an open string."""
    return float(intonation.places[note.string, note.fret]) if note.fret else 0.0


def pluck_place(guitar, intonation, note, share):
    """Place of a pluck at ``share`` of the sounding span from the bridge, as a fraction of the string from the nut."""
    return 1.0 - share * (1.0 - note_place(intonation, note) / guitar.strings[note.string].length)


def tuned_and_held(guitar, intonation, note):
    """The guitar with the tensions of its intonation, and what holds each string: as the reference solver has it."""
    held = [()] * len(guitar.strings)
    if note.fret:
        held[note.string] = held_by_finger(guitar.finger, note_place(intonation, note))
    return with_tensions(guitar, intonation.tensions), held
