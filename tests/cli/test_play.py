"""``ukrt play`` without devices: a piece through the null output, its end, its interruption, its summary."""

import pathlib
import re
import signal
import time

import numpy as np
import pytest
import soundfile

import ukrt.cli.play
from ukrt.cli.main import main
from ukrt.drivers.midi_file import load_midi_file


@pytest.fixture(autouse=True)
def short_tail(monkeypatch):
    """Open strings ring for many seconds, in which nothing new would be seen."""
    monkeypatch.setattr(ukrt.cli.play, "_TAIL_SECONDS", 0.2)


def recording(folder):
    (path,) = folder.glob("ukrt-play-*.wav")
    return path


def test_a_piece_is_played_on_the_null_output_and_kept(capsys, tmp_path, monkeypatch, piece):
    monkeypatch.chdir(tmp_path)
    assert main(["play", str(piece), "--audio-out", "null", "--midi-in", "none", "--block", "256"]) == 0
    out, err = capsys.readouterr()
    heard = recording(tmp_path)
    assert "null output" in err and heard.name in err
    assert re.search(r"blocks +\d+", out) and "load" in out and heard.name in out
    samples, rate = soundfile.read(heard, always_2d=True)
    assert rate == 48000 and samples.shape[1] == 2
    assert 0.001 < np.abs(samples).max() < 1.0


def test_what_was_played_is_what_would_be_rendered(tmp_path, monkeypatch, piece):
    """The live path, its thread and its clock add nothing but a delay of whole frames."""
    monkeypatch.chdir(tmp_path)
    assert main(["play", str(piece), "--audio-out", "null", "--midi-in", "none"]) == 0
    played, _ = soundfile.read(recording(tmp_path), always_2d=True, dtype="float64")
    rendered, _ = ukrt.render(piece)
    rendered = rendered[: int(0.5 * 48000)]
    start = np.flatnonzero(np.abs(played).max(axis=1) > 0)[0] - np.flatnonzero(np.abs(rendered).max(axis=1) > 0)[0]
    best = min(
        np.abs(played[at : at + len(rendered)] - rendered).max()
        for at in range(max(0, start - 2000), start + 2000)
        if len(played) >= at + len(rendered)
    )
    assert best < 1e-6 * max(1.0, np.abs(rendered).max())  # float32 of the live path


@pytest.mark.parametrize("sign", [signal.SIGINT, signal.SIGTERM])
def test_interruption_ends_with_a_summary(tmp_path, start_ukrt, sign):
    playing = start_ukrt("play", "--audio-out", "null", "--midi-in", "none")
    while "bundled piece" not in (line := playing.stderr.readline()):
        assert line, "ukrt play ended early"
    time.sleep(1.0)
    playing.send_signal(sign)
    out, err = playing.communicate(timeout=20)
    assert playing.returncode == 0 and "Traceback" not in err
    assert re.search(r"blocks +\d+", out)
    samples, _ = soundfile.read(recording(tmp_path))
    assert len(samples) > 4800 and np.abs(samples).max() > 0.001


def test_the_bundled_piece_has_two_voices_and_a_minute():
    from ukrt.cli.play import bundled_piece

    score = load_midi_file(bundled_piece())
    assert score.duration_s >= 60 and score.n_notes > 100 and score.warnings == ()
    assert pathlib.Path(bundled_piece()).is_relative_to(pathlib.Path(ukrt.__file__).parent)
