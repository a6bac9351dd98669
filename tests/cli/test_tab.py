"""``ukrt tab`` from arguments to text and files."""

import json
import os
import re
import sys
from xml.etree import ElementTree

import mido
import pytest

from ukrt.cli.main import main


@pytest.fixture
def song(tmp_path):
    """Two bars of 3/4: a scale in quarters, then a chord of two notes and a marker; two notes no guitar has at once."""
    file = mido.MidiFile(ticks_per_beat=96)
    track = file.add_track("Scale")
    track.append(mido.MetaMessage("time_signature", numerator=3, denominator=4))
    for key in (64, 65, 67):
        track.append(mido.Message("note_on", note=key))
        track.append(mido.Message("note_off", note=key, time=96))
    track.append(mido.MetaMessage("marker", text="End"))
    for key in (40, 52, 41):
        track.append(mido.Message("note_on", note=key))
    track.append(mido.Message("note_off", note=40, time=288))
    file.save(tmp_path / "song.mid")
    return tmp_path / "song.mid"


def tab(*argv):
    return main(["tab", *map(str, argv)])


EXPECTED = """\
Scale
classical, strings from the bass side: E2 A2 D3 G3 B3 E4

   1 3/4 q=120 2 [End]
    1 2 3       1 2 3
E4|-0-1-3-----|-------|
B3|-----------|-------|
G3|-----------|-------|
D3|-----------|-2-----|
A2|-----------|-------|
E2|-----------|-0-----|

dropped: bar 2, beat 1: F2 (MIDI note 41)
"""


def test_tablature_is_printed(capsys, song):
    tab(song)
    capsys.readouterr()  # whoever comes first is told that something is compiled
    assert tab(song, "--width", 60) == 0
    out, err = capsys.readouterr()
    assert out == EXPECTED and err == ""


def test_strings_are_those_of_a_rendering_whichever_way_they_are_chosen(capsys, tmp_path):
    track = mido.MidiTrack()
    for key in (60, 64, 67, 79, 83):
        track += [mido.Message("note_on", note=key), mido.Message("note_off", note=key, time=96)]
    mido.MidiFile(tracks=[track]).save(tmp_path / "quick.mid")
    drawn = []
    for options in ((), ("--fingering", "causal")):
        assert tab(tmp_path / "quick.mid", *options) == 0
        drawn.append(capsys.readouterr().out)
        report = tmp_path / "report.json"
        argv = [
            "render",
            tmp_path / "quick.mid",
            "-o",
            tmp_path / "a.wav",
            "--tail-db",
            "-1",
            "--report",
            report,
            *options,
        ]
        assert main([str(word) for word in argv]) == 0
        for string, line in enumerate(reversed([one for one in drawn[-1].splitlines() if "|-" in one])):
            frets = [note["fret"] for note in json.loads(report.read_text())["notes"] if note["string"] == string]
            assert [int(fret) for fret in re.findall(r"\d+", line.split("|", 1)[1])] == frets
        capsys.readouterr()
    assert drawn[0] != drawn[1]


def test_a_part_is_cut_out(capsys, song):
    assert tab(song, "--from", "marker:end") == 0
    out = capsys.readouterr().out
    assert "E2|-0-------" in out and "E4|---------" in out and "   2 3/4 q=120 [End]" in out
    assert tab(song, "--to", "bar:1.3") == 0
    out = capsys.readouterr().out
    assert "E4|-0-1-------" in out and "dropped" not in out


def test_files_are_written_by_their_suffix(capsys, tmp_path, song):
    pytest.importorskip("musicxml", reason="needs the package musicxml (ukrt[notation])")
    for suffix in ("txt", "musicxml", "jams"):
        assert tab(song, "-o", tmp_path / f"out.{suffix}") == 0
        assert f"out.{suffix}: 5 notes in 2 bars, not played 1" in capsys.readouterr().out
    assert (tmp_path / "out.txt").read_text() == EXPECTED
    assert len(ElementTree.parse(tmp_path / "out.musicxml").findall(".//fret")) == 5
    strings = json.loads((tmp_path / "out.jams").read_text())["annotations"][:6]
    assert [len(string["data"]) for string in strings] == [1, 0, 1, 0, 0, 3]
    assert sorted(p.name for p in tmp_path.iterdir()) == ["out.jams", "out.musicxml", "out.txt", "song.mid"]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("-o", "song.pdf"), ".txt, .musicxml, .xml, .jams are legal"),
        (("-o", "no folder/song.txt"), "folder"),
        (("--from", "bar:9"), "has 2 bars"),
        (("--from", "20"), "ends at 3.0 s"),
        (("--width", "10"), "from 40 to 1000"),
        (("--preset", "ukulele-of-glass"), "ukulele-of-glass"),
    ],
)
def test_what_cannot_be_done_is_refused(capsys, tmp_path, song, options, words, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert tab(song, *options) == 2
    out, err = capsys.readouterr()
    assert words in err and err.count("\n") == 1 and out == ""
    assert [p.name for p in tmp_path.iterdir()] == ["song.mid"]


def test_too_many_bars_are_refused_naming_the_file(capsys, song):
    file = mido.MidiFile(song)
    file.tracks[0].insert(0, mido.MetaMessage("time_signature", numerator=1, denominator=64, time=96 * 1000))
    file.tracks[0].insert(0, mido.MetaMessage("time_signature", numerator=1, denominator=64))
    file.save(song)
    assert tab(song) == 2
    err = capsys.readouterr().err
    assert "song.mid: there are 16" in err and err.count("\n") == 1


def test_the_package_that_is_missing_is_named(capsys, tmp_path, song, monkeypatch):
    monkeypatch.setitem(sys.modules, "musicxml", None)
    assert tab(song, "-o", tmp_path / "out.musicxml") == 2
    assert "pip install 'ukrt[notation]'" in capsys.readouterr().err


def test_letters_that_the_terminal_has_not_are_replaced(start_ukrt, song):
    file = mido.MidiFile(song, charset="utf-8")
    file.tracks[0][0].name = "Étude"
    file.save(song)
    process = start_ukrt("tab", song, environment={**os.environ, "PYTHONIOENCODING": "ascii"})
    out, err = process.communicate(timeout=300)
    assert process.returncode == 0 and out.startswith("?tude\n"), err
