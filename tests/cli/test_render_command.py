"""``ukrt render`` from arguments to file: what is written, what is said, what odd files become."""

import json
import re

import mido
import numpy as np
import pytest
import soundfile

from ukrt.cli.main import main


@pytest.fixture
def scale_up_the_neck(tmp_path):
    """Quick notes (a path): who knows where they lead goes there early."""
    track = mido.MidiTrack()
    for key in (60, 64, 67, 79, 83):
        track += [mido.Message("note_on", note=key), mido.Message("note_off", note=key, time=96)]
    mido.MidiFile(tracks=[track]).save(tmp_path / "scale.mid")
    return tmp_path / "scale.mid"


def render(*argv):
    return main(["render", *map(str, argv)])


def test_defaults_are_48_khz_24_bit_beside_the_input(capsys, tmp_path, piece):
    assert render(piece) == 0
    info = soundfile.info(tmp_path / "piece.wav")
    assert (info.samplerate, info.subtype, info.channels, info.format) == (48000, "PCM_24", 2, "WAV")
    out, err = capsys.readouterr()
    assert "piece.wav" in out and re.search(r"notes +2, dropped 0", out) and re.search(r"peak +-\d+\.\d dBFS", out)
    assert "\x1b" not in err  # no progress bar where nobody looks
    assert render(piece) == 2
    assert render(piece, "--force") == 0


def test_what_comes_with_ukrt_has_a_name(capsys, tmp_path, monkeypatch):
    """Its sound goes to the current folder; a file of that name there comes first."""
    monkeypatch.chdir(tmp_path)
    assert render("demonstration", "--from", "marker:Tasto", "--to", "marker:ponticello", "--rate", 44100) == 0
    assert soundfile.info(tmp_path / "demonstration.wav").frames == 6 * 44100
    (tmp_path / "romance").write_text("no music")
    assert render("romance", "-o", "romance.wav") == 2
    assert "ukrt: romance: " in capsys.readouterr().err


def test_options_reach_the_file_and_the_report(tmp_path, piece):
    target, report = tmp_path / "out.flac", tmp_path / "out.json"
    assert (
        render(piece, "-o", target, "--rate", 44100, "--bits", 16, "--block", 64, "--normalize", "--report", report)
        == 0
    )
    info = soundfile.info(target)
    assert (info.samplerate, info.subtype, info.format) == (44100, "PCM_16", "FLAC")
    told = json.loads(report.read_text())
    assert told["notes_total"] == 2 and told["notes_dropped"] == 0
    assert told["duration_s"] == pytest.approx(info.frames / 44100)
    assert told["peak_dbfs"] == pytest.approx(-1.0, abs=0.01)
    assert {"times_real_time", "notes"} <= set(told)
    keys = {"time_s", "release_frame", "midi", "string", "fret", "force_n", "end_s", "fate"}
    assert [keys <= set(note) for note in told["notes"]] == [True, True]
    assert [note["release_frame"] for note in told["notes"]] == [0, 11025]


def test_gain_is_in_decibels(tmp_path, piece):
    peaks = []
    for gain in ("0", "-6.0206"):
        assert render(piece, "-o", tmp_path / "a.wav", "--gain", gain, "--bits", "32f") == 0
        peaks.append(np.abs(soundfile.read(tmp_path / "a.wav")[0]).max())
    assert peaks[1] / peaks[0] == pytest.approx(0.5, rel=1e-4)


def test_set_changes_the_sound(tmp_path, piece):
    sounds = []
    for place in ("0.9", "0.7"):
        assert render(piece, "-o", tmp_path / "a.wav", "--set", f"pluck.place={place}") == 0
        sounds.append((tmp_path / "a.wav").read_bytes())
    assert sounds[0] != sounds[1]


@pytest.mark.parametrize(("rate", "block", "suffix"), [(44100, 64, ".flac"), (48000, 1000, ".wav")])
def test_a_part_is_bit_for_bit_that_of_the_whole(capsys, tmp_path, piece, rate, block, suffix):
    whole, part, report = tmp_path / f"whole{suffix}", tmp_path / f"part{suffix}", tmp_path / "part.json"
    assert render(piece, "-o", whole, "--rate", rate, "--tail-db", -20) == 0
    capsys.readouterr()
    options = ("--rate", rate, "--block", block, "--tail-db", -20, "--report", report)
    assert render(piece, "-o", part, "--from", 0.1, "--to", "bar:1.2", *options) == 0
    assert "0.4 s from 0.1 s on" in capsys.readouterr().out
    expected = soundfile.read(whole, dtype="int32")[0][rate // 10 : rate // 2]
    assert np.any(expected) and np.array_equal(soundfile.read(part, dtype="int32")[0], expected)
    told = json.loads(report.read_text())
    assert [note["midi"] for note in told["notes"]] == [64] and told["notes_total"] == 1


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--from", "bar:x"), "no place in a piece"),
        (("--from", "bar:9"), "has 1 bar and"),
        (("--to", "marker:Coda"), "no marker"),
        (("--from", "1", "--to", "0.5"), "after the start"),
        (("--from", "100"), "the sound ends"),
    ],
)
def test_parts_that_are_not_there_are_refused(capsys, tmp_path, piece, options, words):
    assert render(piece, *options) == 2
    err = capsys.readouterr().err
    assert words in err and err.count("\n") == 1 and [p.name for p in tmp_path.iterdir()] == ["piece.mid"]


def test_the_choice_of_strings_is_said_and_can_be_left_to_the_player(capsys, tmp_path, scale_up_the_neck):
    strings = {}
    for choice, options in (("look-ahead", ()), ("causal", ("--fingering", "causal"))):
        report = tmp_path / "out.json"
        assert render(scale_up_the_neck, "-o", tmp_path / "a.wav", "--tail-db", "-1", "--report", report, *options) == 0
        told = json.loads(report.read_text())
        assert told["fingering"]["choice"] == choice and told["counters"]["forces_refused"] == 0
        assert f"fingering       {choice}" in capsys.readouterr().out
        strings[choice] = [note["string"] for note in told["notes"]]
    assert strings["look-ahead"] != strings["causal"]


def test_a_refused_file_leaves_nothing(capsys, tmp_path):
    (tmp_path / "bad.mid").write_bytes(b"This is no MIDI file")
    assert render(tmp_path / "bad.mid", "--report", tmp_path / "bad.json") == 2
    err = capsys.readouterr().err
    assert "bad.mid" in err and err.count("\n") == 1
    assert [p.name for p in tmp_path.iterdir()] == ["bad.mid"]


def test_interruption_leaves_nothing(capsys, tmp_path, piece, monkeypatch):
    import ukrt.drivers.files.offline

    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(ukrt.drivers.files.offline.Performance, "_done", interrupted)
    assert render(piece) == 130
    assert [p.name for p in tmp_path.iterdir()] == ["piece.mid"]
    assert capsys.readouterr().err.count("\n") == 1


def odd_files(folder):
    return sorted(p for p in folder.rglob("*") if p.is_file() and p.suffix.lower() in (".mid", ".kar", ".rmi", ".midi"))


@pytest.mark.slow
def test_odd_files_are_rendered_or_refused_in_a_sentence(shared_data, capsys, tmp_path):
    files = odd_files(shared_data / "midi_odd")
    assert files
    outcomes = set()
    for number, path in enumerate(files):
        target = tmp_path / f"{number}.wav"
        code = render(path, "-o", target, "--max-minutes", "1", "--tail-db", "-20")
        out, err = capsys.readouterr()
        assert code in (0, 2), path
        assert "Traceback" not in err, path
        if code == 0:
            assert soundfile.info(target).samplerate == 48000, path
        else:
            assert err.startswith("ukrt: ") and err.count("\n") == 1 and out == "", path
        assert [p.name for p in tmp_path.iterdir()] == ([target.name] if code == 0 else []), path
        target.unlink(missing_ok=True)
        outcomes.add(code)
    assert outcomes == {0, 2}
