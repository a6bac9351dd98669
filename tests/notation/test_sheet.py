"""Onsets on a grid: exact ones where they are, human ones near, none lost in silence."""

import random
from fractions import Fraction

import pytest
from scores import OPEN, make_score, random_sheet, row

from ukrt.errors import MidiFileError
from ukrt.notation.sheet import DIVISIONS, LOOSE_SECONDS, make_sheet


def places(sheet):
    """(bar, quarter notes, string, fret) of every note in the bars."""
    return [
        (measure.bar.number, at, tone.string, tone.fret)
        for measure in sheet.measures
        for at, tones in measure.moments.items()
        for tone in sorted(tones, key=lambda tone: tone.string)
    ]


@pytest.mark.parametrize("parts", DIVISIONS)
def test_each_division_is_found_where_it_is_needed(parts):
    score = make_score([], 4)
    rows = [row(score, 1 + cell / parts, 2, cell) for cell in range(parts)]
    sheet = make_sheet(score, "g", rows, OPEN)
    assert [measure.divisions for measure in sheet.measures] == [[1, parts, 1, 1]]
    assert places(sheet) == [(1, 1 + Fraction(cell, parts), 2, cell) for cell in range(parts)]
    assert (sheet.moved, sheet.unshown) == (0, 0)


@pytest.mark.parametrize("seed", range(8))
def test_exact_onsets_stay_where_they_are_through_tempo_and_signature(seed):
    score, rows, sheet = random_sheet(seed)
    assert (sheet.moved, sheet.unshown, len(sheet.tones)) == (0, 0, len(rows))
    assert len(places(sheet)) == len(rows)
    for measure in sheet.measures:
        for at, tones in measure.moments.items():
            for tone in tones:
                number, quarters = score.bars.place(tone.start_s + 1e-9)
                assert number == measure.bar.number and quarters == pytest.approx(float(at), abs=0.002)


def test_human_timing_is_written_as_it_was_meant():
    """Eighths at 120 within 24 ms: all on the eighths, none across a bar line, and the largest shift is told."""
    rng, score = random.Random(3), make_score([], 16)
    shifts = [rng.uniform(-0.024, 0.024) for _ in range(31)]
    rows = [row(score, (k + 1) / 2, k % 6, 3, late_s=shift) for k, shift in enumerate(shifts)]
    sheet = make_sheet(score, "g", rows, OPEN)
    meant = [(1 + (k + 1) // 8, Fraction((k + 1) % 8, 2), k % 6, 3) for k in range(31)]
    assert places(sheet) == meant
    assert sheet.moved_s == pytest.approx(max(map(abs, shifts)), abs=1e-4) and sheet.moved_s < LOOSE_SECONDS


def test_a_chord_that_is_spread_is_one_moment():
    score = make_score([], 4)
    sheet = make_sheet(score, "g", [row(score, 2, s, 0, late_s=0.004 * s) for s in range(6)], OPEN)
    assert [(at, len(tones)) for at, tones in sheet.measures[0].moments.items()] == [(2, 6)]


def test_no_string_has_two_notes_at_once_and_what_has_no_room_is_counted():
    score = make_score([], 4)
    rows = [row(score, 1 + k / 40, 0, k % 20) for k in range(40)]
    sheet = make_sheet(score, "g", rows, OPEN)
    assert all(len({tone.string for tone in tones}) == len(tones) for tones in sheet.measures[0].moments.values())
    assert len(places(sheet)) + sheet.unshown == 40 and sheet.unshown >= 40 - 18 and 0 < sheet.moved_s <= 0.125 * 0.5


def test_a_part_holds_its_notes_and_bars_and_a_bar_cut_short_its_own():
    score, rows, whole = random_sheet(9)
    first = score.bars.seconds(2)
    last = score.bars.seconds(4)
    sheet = make_sheet(score, "g", rows, OPEN, first, last)
    assert [measure.bar.number for measure in sheet.measures] == [2, 3]
    assert places(sheet) == [place for place in places(whole) if place[0] in (2, 3)]
    cut = make_sheet(make_score([], 5, signatures=[(2.5, 2, 4)]), "g", [], OPEN)
    assert [(m.bar.quarters, m.divisions) for m in cut.measures] == [
        (Fraction(5, 2), [1, 1, 1]),
        (2, [1, 1]),
        (2, [1, 1]),
    ]


def test_what_was_not_played_is_listed_with_its_place():
    score = make_score([], 8)
    lost = row(score, 5.5, 0, 30) | {"string": None, "fret": None, "fate": "dropped"}
    sheet = make_sheet(score, "g", [lost], OPEN)
    assert [(bar.number, quarters, midi, fate) for bar, quarters, midi, fate in sheet.lost] == [
        (2, pytest.approx(1.5, abs=1e-6), 70, "dropped")
    ]


def test_too_many_bars_are_refused():
    with pytest.raises(MidiFileError, match="30000 bars"):
        make_sheet(make_score([], 1875, signatures=[(0, 1, 16), (0, 1, 64)]), "g", [], OPEN)


def test_what_a_string_went_back_to_and_left_at_once_is_not_written():
    """A key comes up and another goes down in one instant, over a third that is held: only the second is heard."""
    score = make_score([], 4)
    rows = [row(score, 1, 2, 5), row(score, 2, 2, 3), row(score, 2, 2, 7), row(score, 3, 2, 3)]
    rows[1] |= {"end_s": rows[1]["time_s"], "fate": "slurred"}
    assert [tone.fret for tone in make_sheet(score, "g", rows, OPEN).tones] == [5, 7, 3]
