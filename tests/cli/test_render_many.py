"""``ukrt render`` with several files: the same files as one by one, whatever fails beside them."""

import json
import os
import pathlib
import signal
import subprocess
import sys
import time

import mido
import pytest

from ukrt.cli.main import main

NO_RESPONSE = ["--signal", "bridge-force", "--tail-db", "-20"]


@pytest.fixture
def pieces(tmp_path):
    """Three short files, each a note of its own."""
    paths = []
    for n, note in enumerate((52, 57, 64)):
        track = mido.MidiTrack(
            [mido.Message("note_on", note=note, time=0), mido.Message("note_off", note=note, time=90)]
        )
        paths.append(tmp_path / f"piece{n}.mid")
        mido.MidiFile(tracks=[track]).save(paths[-1])
    return [str(path) for path in paths]


def test_several_files_become_what_each_becomes_by_itself(tmp_path, pieces, capsys):
    alone = []
    for path in pieces:
        assert main(["render", path, *NO_RESPONSE, "-o", str(tmp_path / "alone.wav")]) == 0
        alone.append((tmp_path / "alone.wav").read_bytes())
    capsys.readouterr()
    folder, report = tmp_path / "out", tmp_path / "report.json"
    assert main(["render", *pieces, *NO_RESPONSE, "-o", str(folder), "--jobs", "2", "--report", str(report)]) == 0
    assert [(folder / f"piece{n}.wav").read_bytes() for n in range(3)] == alone
    said = capsys.readouterr().out
    assert [said.index(f"piece{n}.wav") for n in range(3)] == sorted(said.index(f"piece{n}.wav") for n in range(3))
    files = json.loads(report.read_text())["files"]
    assert [entry["input"] for entry in files] == pieces
    assert all(entry["notes_total"] == 1 for entry in files)


def test_a_file_that_is_refused_does_not_hold_up_the_others(tmp_path, pieces, capsys):
    broken = tmp_path / "broken.mid"
    broken.write_bytes(b"MThd")
    code = main(["render", pieces[0], str(broken), pieces[1], *NO_RESPONSE, "-o", str(tmp_path / "out"), "--jobs", "2"])
    printed = capsys.readouterr()
    assert code == 2
    assert "broken.mid" in printed.err and "1 of 3 files could not be rendered" in printed.err
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["piece0.wav", "piece1.wav"]


def test_what_would_overwrite_or_meet_is_refused(tmp_path, pieces, capsys):
    (tmp_path / "other").mkdir()
    twin = tmp_path / "other" / "piece0.mid"
    twin.write_bytes(pathlib.Path(pieces[0]).read_bytes())
    assert main(["render", pieces[0], str(twin), "-o", str(tmp_path / "out")]) == 2
    assert "would both become piece0.wav" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
    assert main(["render", pieces[0], pieces[1], "-o", pieces[2]]) == 2
    assert "is a file, several renders need a folder" in capsys.readouterr().err
    (tmp_path / "piece1.wav").write_bytes(b"kept")
    assert main(["render", pieces[0], pieces[1]]) == 2
    assert "exists already" in capsys.readouterr().err
    assert (tmp_path / "piece1.wav").read_bytes() == b"kept"
    assert main(["render", pieces[0], "--jobs", "2"]) == 2
    assert "--jobs is for several files" in capsys.readouterr().err


@pytest.mark.skipif(not hasattr(os, "killpg"), reason="no process groups here")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interruption_ends_all_workers_and_leaves_nothing_half_written(tmp_path, number):
    track = mido.MidiTrack([mido.Message("note_on", note=52, time=0), mido.Message("note_off", note=52, time=480_000)])
    for name in ("a", "b"):
        mido.MidiFile(tracks=[track]).save(tmp_path / f"{name}.mid")  # some minutes
    command = [sys.executable, "-m", "ukrt", "render", "a.mid", "b.mid", "-o", "out", "--jobs", "2"]
    process = subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.PIPE, text=True)
    folder, end = tmp_path / "out", time.monotonic() + 60.0
    while time.monotonic() < end and not (folder.is_dir() and len(list(folder.iterdir())) == 2):
        time.sleep(0.05)  # both have begun to write
    assert len(list(folder.iterdir())) == 2
    process.send_signal(number)
    said = process.communicate(timeout=30)[1]
    assert process.returncode == 130 and "interrupted" in said
    end = time.monotonic() + 10.0
    while time.monotonic() < end and list(folder.iterdir()):
        time.sleep(0.05)
    assert not list(folder.iterdir())


def test_a_worker_that_dies_is_said_and_the_others_go_on(tmp_path, pieces, monkeypatch, capsys):
    """The second file kills its worker."""
    from ukrt.cli import render, render_many

    monkeypatch.setattr(render, "render_one", die_at_the_second)
    assert render_many.choose_jobs(8, 3) == 3
    assert main(["render", *pieces, "-o", str(tmp_path / "out"), "--jobs", "2"]) == 2
    printed = capsys.readouterr()
    assert "piece1.mid: its process died" in printed.err and "1 of 3 files" in printed.err
    assert "piece0" in printed.out and "piece2" in printed.out


def die_at_the_second(args, _progress):
    if "piece1" in args.midi:
        os.kill(os.getpid(), signal.SIGKILL)
    return {
        "output": args.output,
        "warnings": [],
        "peak_dbfs": None,
        "times_real_time": None,
        "start_s": 0.0,
        "duration_s": 1.0,
        "sample_rate": 48000,
        "channels": 1,
        "bits": "24",
        "notes_total": 1,
        "notes_dropped": 0,
        "clipped_samples": 0,
    }
