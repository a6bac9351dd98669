"""What is written: pictures, data with units, tables, sounds; all or nothing, and refusals in one sentence."""

import csv
import json
import os
import sys

import numpy as np
import pytest
import soundfile

from ukrt.cli import figures as command
from ukrt.cli.main import main
from ukrt.errors import UkrtError
from ukrt.experiment.case_file import load_case
from ukrt.experiment.result import Quantity
from ukrt.figures import figure_02, figure_06
from ukrt.figures.data import FigureData, Number
from ukrt.figures.runs import Run
from ukrt.figures.write import write_figure

pytest.importorskip("matplotlib", reason="figures are drawn by matplotlib, which `pip install 'ukrt[plot]'` brings")


def refused(capsys, *argv):
    """The one sentence with which ``ukrt figures`` refuses."""
    assert main(["figures", *map(str, argv)]) == 2
    out, err = capsys.readouterr()
    assert out == "" and err.startswith("ukrt: ") and err.count("\n") == 1
    return err


@pytest.fixture
def quick(monkeypatch):
    """The command with figure 6 a fiftieth of a second long."""
    whole = figure_06.oblique_case
    monkeypatch.setattr(figure_06, "oblique_case", lambda name, losses: whole(name, losses, duration=0.02))


def test_a_figure_becomes_picture_data_and_table(capsys, tmp_path, quick):
    assert main(["figures", "6", "-o", str(tmp_path / "figs")]) == 0
    out, err = capsys.readouterr()
    assert "total energy" in out and "about 2" in out and "figure_06.png" in err
    assert {path.name for path in (tmp_path / "figs").iterdir()} == {"figure_06.png", "figure_06.npz", "figure_06.csv"}
    assert (tmp_path / "figs" / "figure_06.png").read_bytes().startswith(b"\x89PNG")
    with np.load(tmp_path / "figs" / "figure_06.npz") as data:
        about = json.loads(str(data["metadata"]))
        assert data["energies"].shape == (len(data["time"]), 4)
    assert about["figure"] == 6 and about["solver"] == "reference" and about["program"].startswith("ukrt ")
    assert about["quantities"]["energies"] == {"unit": "J", "columns": ["STRINGS", "FRET", "BODY", "TOTAL"]}
    assert "E2" in about["cases"][0] and "0.2509" in about["cases"][0]
    with open(tmp_path / "figs" / "figure_06.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [row["what"] for row in rows] == [one["what"] for one in about["numbers"]]
    assert float(rows[0]["value"]) == about["numbers"][0]["value"] and rows[0]["unit"] == "mJ"


def test_sounds_keep_their_samples(tmp_path):
    data = figure_02.make(Run())
    tone = 0.5 * np.sin(np.arange(4800) / 10.0)
    data.sounds["figure_02_tone"] = (48000, tone)
    data.sounds["figure_02_pair"] = (44100.0, np.stack([tone, -tone], axis=1))
    names = {path.name for path in write_figure(2, data, tmp_path, "reference")}
    assert {"figure_02_tone.wav", "figure_02_pair.wav", "figure_02.png"} <= names
    samples, rate = soundfile.read(tmp_path / "figure_02_tone.wav")
    assert rate == 48000 and np.allclose(samples, tone, atol=2**-23)
    assert soundfile.read(tmp_path / "figure_02_pair.wav")[0].shape == (4800, 2)


def test_numbers_of_numpys_own_types_are_written(tmp_path):
    numbers = (Number("a", np.float32(0.5), "m", "b", np.True_), Number("c, d", 2, "", "", None))
    data = figure_02.make(Run())
    write_figure(2, FigureData(data.arrays, numbers), tmp_path, "reference")
    rows = (tmp_path / "figure_02.csv").read_text(encoding="utf-8").splitlines()
    assert rows[1:] == ["a,0.5,m,b,yes,", '"c, d",2.0,,,,']


def test_what_fails_leaves_nothing_and_spoils_nothing(tmp_path, monkeypatch):
    data = figure_02.make(Run())
    (tmp_path / "figure_02.csv").write_text("precious", encoding="utf-8")

    def broken(data, figure):
        raise RuntimeError("no ink")

    monkeypatch.setattr(figure_02, "draw", broken)
    with pytest.raises(RuntimeError, match="no ink"):
        write_figure(2, data, tmp_path, "reference")
    monkeypatch.undo()
    bad = FigureData(data.arrays, (), {"a": (48000, np.array([np.nan]))})
    with pytest.raises(UkrtError, match="not a finite number"):
        write_figure(2, bad, tmp_path, "reference")
    assert [path.name for path in tmp_path.iterdir()] == ["figure_02.csv"]
    assert (tmp_path / "figure_02.csv").read_text(encoding="utf-8") == "precious"


def test_the_same_figure_gives_the_same_data(tmp_path):
    for name in ("a", "b"):
        write_figure(2, figure_02.make(Run()), tmp_path / name, "reference")
    assert (tmp_path / "a" / "figure_02.csv").read_bytes() == (tmp_path / "b" / "figure_02.csv").read_bytes()
    with np.load(tmp_path / "a" / "figure_02.npz") as a, np.load(tmp_path / "b" / "figure_02.npz") as b:
        assert all(np.array_equal(a[name], b[name]) for name in a.files)


def test_cases_in_the_data_can_be_run_again(tmp_path):
    case = figure_06.oblique_case("again", True, duration=0.02)
    write_figure(2, FigureData(figure_02.make(Run()).arrays, (), {}, (case,)), tmp_path, "reference")
    with np.load(tmp_path / "figure_02.npz") as kept:
        (text,) = json.loads(str(kept["metadata"]))["cases"]
    (tmp_path / "again.toml").write_text(text, encoding="utf-8")
    assert load_case(tmp_path / "again.toml") == case


@pytest.mark.parametrize(
    ("argv", "words"),
    [
        (("4",), "'4' is no figure; there are 2, 3, 5"),
        (("six",), "'six' is no figure"),
        (("-6",), "-6"),
        (("6.0",), "'6.0' is no figure"),
        (("6", "--solver", "wishes"), "--solver"),
        (("6", "-o", "file"), "file is a file, figures need a folder"),
        (("6", "-o", "no/such/folder"), "there is no folder"),
    ],
)
def test_refusals_are_one_sentence(capsys, tmp_path, monkeypatch, argv, words):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("mine", encoding="utf-8")
    assert words in refused(capsys, *argv)
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_that_cannot_be_written_is_refused_before_anything_is_computed(capsys, tmp_path):
    tmp_path.chmod(0o500)
    assert "not writable" in refused(capsys, "6", "-o", tmp_path / "figs")
    tmp_path.chmod(0o700)


def test_missing_matplotlib_is_named_before_anything_is_computed(capsys, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    assert "pip install 'ukrt[plot]'" in refused(capsys, "6", "-o", tmp_path / "figs")
    assert list(tmp_path.iterdir()) == []


def test_help_teaches(capsys):
    with pytest.raises(SystemExit):
        main(["figures", "--help"])
    text = capsys.readouterr().out
    assert text.startswith("usage: ukrt figures") and "examples:" in text and "--solver" in text


def test_the_table_has_every_number(capsys):
    numbers = (Number("a thing [m]", 1.0, "J", "about 1", True), Number("other", 2.0, "", "", False))
    command._show({6: FigureData({"x": Quantity(np.zeros(1), "m")}, numbers)})
    out = capsys.readouterr().out
    assert "a thing [m]" in out and "yes" in out and "other" in out and "no" in out
