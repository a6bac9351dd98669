"""Slurs and fingering together: files with legato keep their slurs when strings are chosen beforehand."""

import pathlib
from dataclasses import replace

import numpy as np
import pytest

from ukrt.drivers.files.midi import load_midi_file
from ukrt.engine import controller_layout as cc
from ukrt.model.presets import load_preset
from ukrt.notation.silent import play_silently
from ukrt.playing import fingering_costs, keyswitches
from ukrt.playing.fingering import Note, find_fingering
from ukrt.playing.grips import neck_of
from ukrt.playing.written_fingering import write_fingering
from ukrt.playing.written_notes import written_notes

GUITAR = load_preset("classical")
ON, OFF, CONTROL = 0x90, 0x80, 0xB0


@pytest.fixture(scope="module")
def piece():
    """Any score without slurs, for its other fields."""
    return load_midi_file(pathlib.Path(keyswitches.__file__).parents[1] / "data" / "romance.mid")


def score_of(piece, rows):
    rows = sorted(rows, key=lambda row: (row[0], row[1] != OFF))
    time_s, *data = zip(*rows, strict=True)
    columns = (np.array(column, dtype=np.uint8) for column in data)
    return replace(
        piece,
        time_s=np.array(time_s),
        duration_s=time_s[-1] + 1.0,
        **dict(zip(("status", "data1", "data2"), columns, strict=True)),
    )


def legato_line(keys, overlap=0.03, step=0.25, channel=0, held=None):
    rows = [(0.0, CONTROL | channel, cc.LEGATO, 127)]
    for k, key in enumerate(keys):
        rows += [(1.0 + step * k, ON | channel, key, 80), (1.0 + step * (k + 1) + overlap, OFF | channel, key, 64)]
    if held is not None:
        rows += [(0.9, ON | channel, held, 80), (1.2 + step * len(keys), OFF | channel, held, 64)]
    return rows


def played(score, guitar=GUITAR):
    fingered, summary = write_fingering(score, guitar)
    notes, _, counters = play_silently(guitar, fingered)
    return notes, counters, summary


# Slurs of method books, but not those that the cheapest hand would have on one string anyway: groups of two and three
# up and down, over open strings and in position, with bass notes of another channel under them.
_GROUPS = ((60, 62), (62, 64, 62), (64, 65, 67), (67, 65, 64), (71, 72, 71), (67, 69), (69, 71), (55, 57, 59), (59, 60),
           (72, 74, 76), (76, 74, 72), (62, 60), (57, 55), (65, 64))  # fmt: skip


def slurred_piece(piece):
    """The score, and how many of its notes are to be slurred."""
    rows, time_s, wanted = [(0.0, CONTROL, cc.LEGATO, 127)], 1.0, 0
    for group in _GROUPS * 2:
        rows += [
            (time_s, ON | 1, 40 + 5 * (len(group) % 2), 70),
            (time_s + 0.7, OFF | 1, 40 + 5 * (len(group) % 2), 64),
        ]
        for k, key in enumerate(group):
            last = k + 1 == len(group)
            rows.append((time_s, ON, key, 80))
            time_s += 0.2
            rows.append((time_s - 0.02 if last else time_s + 0.03, OFF, key, 64))
        wanted += len(group) - 1
    return score_of(piece, rows), wanted


def test_slurs_survive_the_choice_of_strings(piece):
    score, wanted = slurred_piece(piece)
    notes, counters, summary = played(score)
    assert counters["notes_slurred"] == wanted == 42 and counters["forces_refused"] == 0
    assert counters["notes_dropped"] == counters["notes_stolen"] == summary.cut_short == summary.let_go == 0
    without = replace(score, data2=np.where(score.data1 == cc.LEGATO, 0, score.data2).astype(np.uint8))
    strings = [note["string"] for note in played(without)[0]]
    assert strings != [note["string"] for note in notes], "the piece does not need the search to know"


@pytest.mark.parametrize("overlap", [-0.1, 0.0])
def test_a_trill_by_a_held_key_keeps_its_string(piece, overlap):
    score = score_of(piece, legato_line([62] * 5, overlap=overlap, held=60))
    notes, counters, summary = played(score)
    assert counters["notes_resumed"] == counters["notes_slurred"] == 5
    assert len({note["string"] for note in notes}) == 1 and summary.cut_short == summary.let_go == 0


@pytest.mark.parametrize("low, high", [(60, 67), (57, 64), (59, 76)])
def test_what_no_hand_can_slur_is_plucked_and_nothing_is_dropped(piece, low, high):
    notes, counters, _ = played(score_of(piece, legato_line((low, high))))
    assert [note["articulation"] for note in notes][1:] == ["hammer-on" if high - low < 5 else "pluck"]
    assert counters["notes_dropped"] == 0 and counters["notes_played"] == 2


def test_a_lost_slur_costs_what_the_table_says():
    neck = neck_of(GUITAR)
    plain = [Note(0.0, 0.6, 0.6, 60), Note(0.5, 1.0, 1.0, 67)]
    slurred = [plain[0], replace(plain[1], slurred_from=0, hammers=True)]
    points = find_fingering(slurred, neck).points - find_fingering(plain, neck).points
    assert points == pytest.approx(fingering_costs.SLUR_LOST)
    assert find_fingering(slurred, neck).places == find_fingering(plain, neck).places
    slid = [plain[0], replace(plain[1], slurred_from=0, slides=True)]
    places = find_fingering(slid, neck).places
    assert places[0].string == places[1].string and places[1].fret - places[0].fret == 7


def test_of_several_notes_the_highest_goes_on_from_the_last():
    class Rows:
        time_s = np.array([0.0, 0.0, 0.1, 1.0, 1.0, 1.0, 2.0, 2.5])
        status = np.array([CONTROL, ON, ON, ON, ON, ON, CONTROL, ON], dtype=np.uint8)
        data1 = np.array([cc.LEGATO, 50, 55, 57, 60, 55, cc.RESET, 62], dtype=np.uint8)
        data2 = np.array([127, 80, 80, 80, 80, 80, 0, 80], dtype=np.uint8)
        duration_s = 3.0

    sources = [note.slurred_from and note.slurred_from.key for note in written_notes(Rows)]
    assert sources == [None, 50, None, 50, None, None], "a key struck again is plucked, and not gone on from"


def test_without_legato_the_search_is_what_it_was(piece):
    for note in written_notes(piece):
        assert note.slurred_from is None and note.up_s == note.key_up_s
