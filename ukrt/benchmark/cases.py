"""What is measured: chords that ring and are plucked again each second, with something left out or added, and a piece.

Nothing sleeps in any of them.
"""

import dataclasses
import itertools

from ..model.fingerboard import fingerboard

# Chords as frets from the bass side; on a guitar each note has only one place that leaves a string to the others. Where
# there are more strings than six they begin again.
G_MAJOR = (3, 2, 0, 0, 0, 3)
F_BARRE = (1, 3, 3, 2, 1, 1)
OPEN = (0, 0, 0, 0, 0, 0)
VELOCITY = 100


@dataclasses.dataclass(frozen=True)
class Case:
    """One thing to measure.

    Attributes
    ----------
    name, words : str
    chord : tuple of int
        The frets that are plucked each second; none: the bundled piece is played over and over.
    contacts : int
        Of the preset's contacts of a finger, how many there are.
    tension_modulation : bool
    signal : str
        As `ukrt.engine.engine.Engine` takes it; without pressure there is no convolution.
    bandwidth_hz : float, optional
        Instead of the preset's.
    """

    name: str
    words: str
    chord: tuple = G_MAJOR
    contacts: int = 3
    tension_modulation: bool = True
    signal: str = "pressure"
    bandwidth_hz: float | None = None


CASES = (
    Case("whole", "whole engine, G major, half the strings stopped, by three contacts each"),
    Case("piece", "the bundled piece, over and over", ()),
    Case("worst", "the whole engine with an F barre, modes to 20 kHz", F_BARRE, bandwidth_hz=20000.0),
    Case("barre", "whole with an F major barre, all strings stopped", F_BARRE),
    Case("open", "whole with open strings, no contact", OPEN),
    Case("one-contact", "whole with one contact on each stopped string", contacts=1),
    Case("linear", "whole without axial stiffness; costs the same, since nothing is left out for it",
         tension_modulation=False),
    Case("bridge-force", "whole without convolution", signal="bridge-force"),
)  # fmt: skip


def guitar_of(case, guitar):
    """The guitar with what the case leaves out or changes."""
    finger = dataclasses.replace(guitar.finger, contacts=guitar.finger.contacts[: case.contacts])
    strings, basis = guitar.strings, guitar.basis
    if not case.tension_modulation:
        strings = tuple(dataclasses.replace(s, axial_stiffness=0.0) for s in strings)
    if case.bandwidth_hz is not None:
        basis = dataclasses.replace(basis, bandwidth_hz=case.bandwidth_hz)
    return dataclasses.replace(guitar, finger=finger, strings=strings, basis=basis)


def chord_keys(frets, guitar):
    """MIDI notes of a chord given as frets from the bass side (list of int)."""
    return [key + fret for key, fret in zip(fingerboard(guitar).open_keys, itertools.cycle(frets), strict=False)]
