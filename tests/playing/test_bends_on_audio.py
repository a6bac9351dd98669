"""Files as MIDI guitars send them: the pitch follows the bends of its own string, and leaves the others alone.

Every gesture on every string, and all pairs of strings: tools/measure_bends.py.
"""

import numpy as np
import pytest
from measure.bent_guitar import GESTURES, follow, neighbours
from measure.guitar_file import BentNote


@pytest.fixture(scope="module")
def followed():
    """Some gestures on some strings, one after another."""
    chosen = (("whole tone up", 4, 5), ("slide over five frets", 6, 7), ("vibrato", 1, 5))
    notes = [BentNote(name, s, fret, 0.1 + 2.5 * k, 2.0, *GESTURES[name]) for k, (name, s, fret) in enumerate(chosen)]
    return follow(notes, "damped")


def test_the_pitch_follows_the_bends_while_the_note_lasts(followed):
    """Within 5 cents of the same note unbent, though the bend itself goes further."""
    for one in followed:
        assert one.times[-1] > 1.5 and np.ptp(one.sent) > 50.0
        assert np.abs(one.off).max() < 5.0


@pytest.fixture(scope="module")
def others():
    return neighbours((5, 3, 0, 4, 7, 2), ((3, 4), (6, 2), (5, 3)))


def test_a_bend_leaves_strings_alone_that_share_no_partial(others):
    """Partials with none of the other string within 50 cents, but those that a body mode couples (below)."""
    alone = [one for one in others if one.near > 50.0 and abs(one.expected) < 0.1]
    assert len(alone) >= 6
    assert max(abs(one.shift) for one in alone) < 0.2


def test_what_moves_another_string_is_the_bridge(others):
    """Where a body mode couples strings, or they share a partial, it moves as the equations say without time steps."""
    moved = [one for one in others if abs(one.expected) > 0.2]
    assert len(moved) >= 2
    for one in moved:
        assert one.shift == pytest.approx(one.expected, abs=0.05 * abs(one.expected))
