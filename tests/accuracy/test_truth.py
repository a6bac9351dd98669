"""The truth that solvers are measured against: it is the note's own, and it can be followed to a cut basis."""

from dataclasses import replace

import numpy as np
import pytest
from oracle import frequency, poles_between, rigid_guess, span_share

from .compare import note_system, truth_of
from .notes import PARTIALS, Note, setting
from .truth import HOME, cut_poles


@pytest.mark.parametrize("note", [Note(5, 19, 5), Note(3, 19, 1)], ids=str)
def test_partials_are_the_note_s_own(note):
    """Behind a soft finger the dead length is near in pitch; each partial is near n f1 and on the bridge's side."""
    guitar, intonation, placed = setting(replace(note, alone=True))
    system = note_system(guitar, intonation, placed)
    expected = frequency(rigid_guess(system.strings[0], system.contacts[0], max(PARTIALS)))
    found = np.array(truth_of(note))
    assert np.max(np.abs(frequency(found) - expected)) < HOME * expected[0]
    assert np.min(np.diff(np.sort(frequency(found)))) > 0.5 * expected[0]
    shares = [span_share(note_system(*setting(note)), pole, note.string) for pole in found]
    assert min(shares) > 0.25


def test_poles_are_followed_to_the_cut_basis():
    """What is followed arrives at poles of the cut system, each at its own; nothing moves where nothing is cut."""
    note = Note(2, 7, 3, alone=True)
    system, truth = note_system(*setting(note)), np.array(truth_of(note))
    cut = cut_poles(system, truth, 10e3)
    every = poles_between(replace(system, cut_hz=10e3), 200.0, 1000.0)
    nearest = np.argmin(np.abs(cut[:4, None] - every), axis=1)
    assert np.max(np.abs(cut[:4] - every[nearest])) < 1e-6
    assert len(set(nearest)) == 4
    assert np.max(np.abs(cut_poles(system, truth, system.cut_hz) - truth)) < 1e-6 * np.max(np.abs(truth))
    assert np.all(frequency(cut) > frequency(truth))  # without compliance that is cut away, all is stiffer
