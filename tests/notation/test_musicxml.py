"""MusicXML read back by another parser: string, fret, pitch and onset of every note; bars are full."""

from fractions import Fraction
from xml.etree import ElementTree

import pytest
from scores import OPEN, make_score, random_sheet, row

from ukrt.notation.sheet import make_sheet

pytest.importorskip("musicxml", reason="needs the package musicxml (ukrt[notation])")
from ukrt.notation.musicxml_file import DIVISIONS, make_musicxml

STEPS = {"C": 0, "D": 2, "E": 4, "F": 5, "G": 7, "A": 9, "B": 11}
LENGTHS = {"whole": 192, "half": 96, "quarter": 48, "eighth": 24, "16th": 12, "32nd": 6, "64th": 3}


def number(element, path, default=0):
    return int(element.findtext(path, str(default)))


def read_measure(element):
    """(notes, length): notes as (onset, string from 0 the lowest, fret, MIDI note), in quarter notes."""
    notes, at, start = [], 0, 0
    for item in element:
        if item.tag == "forward":
            at += number(item, "duration")
        if item.tag != "note":
            continue
        length = number(item, "duration")
        shown = Fraction(LENGTHS[item.findtext("type")]) * Fraction(3, 2) ** len(item.findall("dot"))
        if item.find("time-modification") is not None:
            change = item.find("time-modification")
            shown *= Fraction(number(change, "normal-notes"), number(change, "actual-notes"))
        assert shown == length, "the note's look and its duration agree"
        if item.find("chord") is None:
            start, at = at, at + length
        if item.find("rest") is None:
            pitch = (
                STEPS[item.findtext("pitch/step")]
                + number(item, "pitch/alter")
                + 12 * number(item, "pitch/octave")
                + 12
            )
            technical = item.find("notations/technical")
            notes.append(
                (Fraction(start, DIVISIONS), 6 - number(technical, "string"), number(technical, "fret"), pitch)
            )
    return notes, Fraction(at, DIVISIONS)


@pytest.mark.parametrize("seed", range(3))
def test_every_note_is_read_back(seed):
    _, _, sheet = random_sheet(seed)
    part = ElementTree.fromstring(make_musicxml(sheet, "test").split("\n", 1)[1]).find("part")
    measures = part.findall("measure")
    assert [element.get("number") for element in measures] == [str(m.bar.number) for m in sheet.measures]
    for element, measure in zip(measures, sheet.measures, strict=True):
        notes, length = read_measure(element)
        assert length == measure.bar.quarters
        expected = [(at, t.string, t.fret, t.pitch) for at, tones in measure.moments.items() for t in tones]
        assert sorted(notes) == sorted(expected)


def test_staff_key_time_tempo_and_markers():
    _, _, sheet = random_sheet(2)
    root = ElementTree.fromstring(make_musicxml(sheet, "test").split("\n", 1)[1])
    assert root.findtext("work/work-title") == "Étude" and root.findtext(".//clef/sign") == "TAB"
    tunings = root.findall(".//staff-tuning")
    keys = [STEPS[t.findtext("tuning-step")] + 12 * number(t, "tuning-octave") + 12 for t in tunings]
    assert keys == OPEN and [t.get("line") for t in tunings] == list("123456")
    times = [(number(t, "beats"), number(t, "beat-type")) for t in root.findall(".//time")]
    assert times[1:] == [(6, 8), (2, 2)] and root.findtext(".//key/fifths") == "-2"
    assert [float(s.get("tempo")) for s in root.findall(".//sound")] == [100.0, 60.0]
    assert [r.text for r in root.findall(".//rehearsal")] == ["Chorus"]


def test_articulations_tie_a_note_to_the_one_before_on_its_string():
    score = make_score([], 4)
    ways = [("hammer-on", 4), ("pluck", 4), ("pluck", 2), ("hammer-on", 4), ("pull-off", 4), ("slide", 4)]
    rows = [row(score, k / 2, string, k, way) for k, (way, string) in enumerate(ways)]
    text = make_musicxml(make_sheet(score, "g", rows, OPEN), "test")
    notes = [note for note in ElementTree.fromstring(text.split("\n", 1)[1]).iter("note") if note.find("rest") is None]
    marks = [[(mark.tag, mark.get("type")) for mark in note.iter() if mark.get("type")] for note in notes]
    assert marks == [
        [],
        [("hammer-on", "start")],
        [],
        [("hammer-on", "stop"), ("pull-off", "start")],
        [("pull-off", "stop"), ("slide", "start")],
        [("slide", "stop")],
    ]


def test_a_bar_of_any_length_is_filled():
    score = make_score([], 6, signatures=[(2.2, 4, 4)])
    sheet = make_sheet(score, "g", [row(score, 1 + 2 / 3, 0, 1), row(score, 2.2 + 15 / 16, 1, 2)], OPEN)
    root = ElementTree.fromstring(make_musicxml(sheet, "test").split("\n", 1)[1])
    lengths = [read_measure(element)[1] for element in root.iter("measure")]
    assert lengths == [Fraction(round(2.2 * DIVISIONS), DIVISIONS), 4]
