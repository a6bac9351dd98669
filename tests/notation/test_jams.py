"""JAMS as in GuitarSet: a note_midi annotation for each string, beats and tempo from the bars."""

import json

import pytest
from scores import OPEN, make_score, random_sheet, row

from ukrt.notation.jams_file import make_jams
from ukrt.notation.sheet import make_sheet


def test_strings_frets_and_times_are_read_back():
    score, rows, sheet = random_sheet(7)
    tree = json.loads(make_jams(sheet, score, "test"))
    strings = [a for a in tree["annotations"] if a["namespace"] == "note_midi"]
    assert [a["annotation_metadata"]["data_source"] for a in strings] == list("012345")
    found = []
    for s, annotation in enumerate(strings):
        data, frets = annotation["data"], annotation["sandbox"]["frets"]
        assert annotation["sandbox"]["open_string"] == OPEN[s] and len(annotation["sandbox"]["articulations"]) == len(
            data
        )
        assert [note["value"] for note in data] == [OPEN[s] + fret for fret in frets]
        ends = [note["time"] + note["duration"] for note in data]
        starts = [note["time"] for note in data[1:]] + [score.duration_s]
        assert ends == pytest.approx(starts), "notes that ring end with the next on their string, or the piece"
        found += [(note["time"], s, fret) for note, fret in zip(data, frets, strict=True)]
    assert sorted(found) == sorted((note["time_s"], note["string"], note["fret"]) for note in rows)
    assert tree["file_metadata"]["duration"] == score.duration_s


def test_notes_end_when_their_strings_are_damped():
    score = make_score([], 8)
    sheet = make_sheet(score, "g", [row(score, 1, 3, 2, "hammer-on", end=3)], OPEN)
    annotation = json.loads(make_jams(sheet, score, "test"))["annotations"][3]
    assert annotation["data"] == [{"time": 0.5, "duration": 1.0, "value": 57.0, "confidence": None}]
    assert annotation["sandbox"]["articulations"] == ["hammer-on"]


def test_beats_and_tempo_follow_the_bars_also_where_the_tempo_changes_within_one():
    score = make_score([], 8, tempos=[(0, 500_000), (2, 1_000_000)], signatures=[(0, 3, 4), (4, 6, 8)])
    *_, beats, tempo = json.loads(make_jams(make_sheet(score, "g", [], OPEN), score, "test"))["annotations"]
    values = [
        (b["time"], b["value"]["position"], b["value"]["measure"], b["value"]["beat_units"]) for b in beats["data"]
    ]
    assert values[:5] == [(0.0, 1, 1, 4), (0.5, 2, 1, 4), (1.0, 3, 1, 4), (2.0, 1, 2, 4), (3.0, 1, 3, 8)]
    assert [(t["time"], t["value"]) for t in tempo["data"]] == [(0.0, 120.0), (2.0, 60.0)]


def test_the_package_jams_finds_nothing_to_complain_of(tmp_path):
    jams = pytest.importorskip("jams", reason="needs the package jams, which nothing else does")
    score, rows, sheet = random_sheet(8)
    (tmp_path / "a.jams").write_text(make_jams(sheet, score, "test"), encoding="utf-8")
    found = jams.load(str(tmp_path / "a.jams"), validate=True, strict=True)
    assert len(found.search(namespace="note_midi")) == 6
    assert sum(len(a.data) for a in found.search(namespace="note_midi")) == len(rows)
