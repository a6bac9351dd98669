"""Scales, chords and a beginning that every guitar method fingers alike: the search must find the same places.

Strings are counted as guitarists do, 1 the highest.
"""

import pytest

from ukrt.model.presets import load_preset
from ukrt.playing.fingering import Note, find_fingering
from ukrt.playing.grips import neck_of

OPEN = {6: 40, 5: 45, 4: 50, 3: 55, 2: 59, 1: 64}
# Scales in first position (frets 0 to 4 of each string, 0 to 3 of the third), as in the methods of Carulli (op. 27),
# Sor and Carcassi (op. 59): string: frets.
SCALES = {
    "chromatic": {
        6: (0, 1, 2, 3, 4),
        5: (0, 1, 2, 3, 4),
        4: (0, 1, 2, 3, 4),
        3: (0, 1, 2, 3),
        2: (0, 1, 2, 3, 4),
        1: (0, 1, 2, 3, 4),
    },
    "C major": {5: (3,), 4: (0, 2, 3), 3: (0, 2), 2: (0, 1, 3), 1: (0, 1, 3)},
    "G major": {6: (3,), 5: (0, 2, 3), 4: (0, 2, 4), 3: (0, 2), 2: (0, 1, 3), 1: (0, 2, 3)},
    "E minor": {6: (0, 2, 3), 5: (0, 2, 3), 4: (1, 2, 4), 3: (0, 2), 2: (0, 1, 4), 1: (0,)},
    "A minor": {5: (0, 2, 3), 4: (0, 2, 3), 3: (1, 2), 2: (0, 1, 3), 1: (0, 2)},
    "F major": {6: (1, 3), 5: (0, 1, 3), 4: (0, 2, 3), 3: (0, 2, 3), 2: (1, 3), 1: (0, 1)},
}
# Open chords and the full barre, string 6 first; None is not played.
CHORDS = {
    "E": (0, 2, 2, 1, 0, 0),
    "Em": (0, 2, 2, 0, 0, 0),
    "A": (None, 0, 2, 2, 2, 0),
    "Am": (None, 0, 2, 2, 1, 0),
    "D": (None, None, 0, 2, 3, 2),
    "Dm": (None, None, 0, 2, 3, 1),
    "G": (3, 2, 0, 0, 0, 3),
    "C": (None, 3, 2, 0, 1, 0),
    "E7": (0, 2, 0, 1, 0, 0),
    "A7": (None, 0, 2, 0, 2, 0),
    "D7": (None, None, 0, 2, 1, 2),
    "B7": (None, 2, 1, 2, 0, 2),
    "F": (1, 3, 3, 2, 1, 1),
    "Bm": (None, 2, 4, 4, 3, 2),
}


@pytest.fixture(scope="module")
def neck():
    return neck_of(load_preset("classical"))


def places(notes, neck):
    """(string number, fret) of each note."""
    return [(6 - place.string, place.fret) for place in find_fingering(notes, neck).places]


@pytest.mark.parametrize("name", SCALES)
@pytest.mark.parametrize("step", [0.15, 0.5])
def test_scales_in_first_position(neck, name, step):
    wanted = [(string, fret) for string in (6, 5, 4, 3, 2, 1) for fret in SCALES[name].get(string, ())]
    wanted += wanted[-2::-1]
    notes = [
        Note(k * step, (k + 1) * step, (k + 1) * step, OPEN[string] + fret) for k, (string, fret) in enumerate(wanted)
    ]
    assert places(notes, neck) == wanted


@pytest.mark.parametrize("name", CHORDS)
def test_chords(neck, name):
    wanted = [(6 - k, fret) for k, fret in enumerate(CHORDS[name]) if fret is not None]
    assert places([Note(0.0, 1.0, 1.0, OPEN[string] + fret) for string, fret in wanted], neck) == wanted
    grip = neck.grip(tuple(-1 if fret is None else fret for fret in CHORDS[name]))
    assert grip.possible and grip.stretch_m == 0.0 and grip.barre == (name in ("F", "Bm"))


def test_chords_from_one_to_the_next(neck):
    progression = ["C", "Am", "Dm", "G", "E7", "Am", "F", "C"]
    notes, wanted = [], []
    for k, name in enumerate(progression):
        for number, fret in enumerate(CHORDS[name]):
            if fret is not None:
                notes.append(Note(float(k), k + 1.0, k + 1.0, OPEN[6 - number] + fret))
                wanted.append((6 - number, fret))
    assert places(notes, neck) == wanted


def test_the_beginning_of_the_spanish_romance(neck):
    """Its melody lies on the first string, from the seventh fret, over the open second, third and sixth."""
    step, notes, wanted = 0.25, [], []
    for bar, melody in enumerate(((71, 71, 71), (71, 69, 67), (67, 66, 64), (64, 67, 71), (76, 76, 76))):
        start = 9 * step * bar
        for beat, pitch in enumerate(melody):
            for k, (string, key) in enumerate(((1, pitch), (2, 59), (3, 55))):
                at = start + (3 * beat + k) * step
                notes.append(Note(at, at + (3 - k) * step, at + (3 - k) * step, key))
                wanted.append((string, key - OPEN[string]))
        notes.append(Note(start, start + 9 * step, start + 9 * step, 40))
        wanted.append((6, 0))
    assert places(notes, neck) == wanted
