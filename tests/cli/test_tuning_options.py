"""Tunings from the command line: options, warnings on standard error, takes that replay alone."""

import json
import tomllib

import numpy as np
import pytest
import soundfile

from ukrt.cli.main import main
from ukrt.drivers.takes.recorder import Recorder
from ukrt.engine.engine import Engine
from ukrt.model.presets import load_preset

NINETEEN = "19 steps\n19\n" + "".join(f"{1200 * n / 19:.9f}\n" for n in range(1, 19)) + "2/1\n"


@pytest.fixture
def scale(tmp_path):
    path = tmp_path / "nineteen.scl"
    path.write_text(NINETEEN)
    return path


def printed(capsys, *argv):
    assert main(["presets", *map(str, argv)]) == 0
    out, err = capsys.readouterr()
    return tomllib.loads(out), err


def test_options_are_short_for_keys(capsys, tmp_path, scale):
    keys = tmp_path / "keys.kbm"
    keys.write_text("0\n0\n127\n60\n69\n441.5\n0\n")
    options = ("--tuning", "DADGAD", "--capo", 2, "--scale", scale, "--keyboard-map", keys)
    tree, err = printed(capsys, "classical", *options)
    assert [one["note"] for one in tree["strings"]] == [38, 45, 50, 55, 57, 62] and err == ""
    assert tree["playing"]["capo"] == 2 and tree["tuning"]["keyboard"]["reference_hz"] == 441.5
    assert tree["tuning"]["scale"]["name"] == "19 steps" and len(tree["tuning"]["scale"]["cents"]) == 19
    settings = ("tuning.open_strings=DADGAD", "playing.capo=2", f"tuning.scale={scale}", f"tuning.keyboard={keys}")
    assert printed(capsys, "classical", *(word for one in settings for word in ("--set", one)))[0] == tree


def test_warnings_are_sentences_on_standard_error(capsys):
    _, err = printed(capsys, "classical", "--tuning", "E2 A2 D3 G3 B3 A4")
    assert err.startswith("ukrt: tuning: strings.5 (A4) would break") and err.count("\n") == 1


@pytest.mark.parametrize(
    ("argv", "words"),
    [
        (("--tuning", "DADG"), ("6 strings", "dadgad")),
        (("--capo", "13"), ("playing.capo", "13", "0 to 12")),
        (("--scale", "absent.scl"), ("absent.scl", "cannot be read")),
        (("--keyboard-map", "a.scl"), ("tuning.keyboard", ".kbm")),
    ],
)
def test_refusals(capsys, argv, words):
    assert main(["presets", "classical", *argv]) == 2
    out, err = capsys.readouterr()
    assert out == "" and err.count("\n") == 1
    for word in words:
        assert word in err
    assert main(["presets", *argv]) == 2
    assert f"{argv[0]} changes a preset that is printed" in capsys.readouterr().err


def test_a_report_says_how_it_was_tuned_and_how_high_each_note_was(capsys, tmp_path, piece, scale):
    report = tmp_path / "out.json"
    argv = ["render", piece, "-o", tmp_path / "out.wav", "--scale", scale, "--capo", 2, "--report", report]
    assert main(list(map(str, argv))) == 0
    told = json.loads(report.read_text())
    assert (told["tuning"]["capo"], told["tuning"]["scale"]) == (2, "19 steps")
    assert told["tuning"]["open_keys"][0] == 25 and len(told["notes"]) == 2
    for note in told["notes"]:
        assert note["hz"] == pytest.approx(440.0 * 2 ** ((note["midi"] - 69) / 19), rel=1e-9)
    (wolves,) = told["tuning_warnings"]
    assert "out of tune since the body takes part" in wolves
    assert f"ukrt: tuning: {wolves}" in capsys.readouterr().err


def test_a_take_replays_without_the_scales_file(tmp_path, scale):
    guitar = load_preset("classical", {"tuning.scale": str(scale), "playing.capo": 3, "strings.1.fine_tune": "-7"})
    engine = Engine(guitar, 44100, shared=True)
    recorder = Recorder(engine, tmp_path / "take.mid", tmp_path / "take.wav")
    engine.send(100, 0x90, 40, 100)
    engine.process_card(10_000)
    recorder.close()
    engine.close()
    scale.unlink()
    assert main(["render", str(tmp_path / "take.mid"), "-o", str(tmp_path / "out.wav")]) == 0
    heard, again = (soundfile.read(tmp_path / name, dtype="float32")[0] for name in ("take.wav", "out.wav"))
    assert np.any(heard) and np.array_equal(heard.view(np.uint32), again.view(np.uint32))
