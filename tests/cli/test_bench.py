"""``ukrt bench``: what it measures, told as numbers and as a table. Speeds themselves are no test's business."""

import contextlib
import io
import json
import os

import pytest

from ukrt.benchmark.machine import one_core
from ukrt.cli.main import main


@pytest.fixture(scope="module")
def report():
    text = io.StringIO()
    with contextlib.redirect_stdout(text):
        assert main(["bench", "--json", "--seconds", "1", "--block", "256"]) == 0
    return json.loads(text.getvalue())


def test_every_case_plucks_all_six_strings(report):
    assert {case["name"] for case in report["cases"]} >= {
        "whole",
        "barre",
        "open",
        "one-contact",
        "linear",
        "bridge-force",
        "piece",
        "worst",
    }
    chords = [case for case in report["cases"] if case["name"] != "piece"]
    assert [case["strings_plucked"] for case in chords] == [6] * len(chords)


def test_every_block_is_in_the_histogram(report):
    blocks = report["runs"] * round(report["seconds"] * report["rate_hz"] / report["block_frames"])
    for case in report["cases"]:
        histogram = case["histogram"]
        assert sum(histogram["blocks"]) == blocks
        assert len(histogram["edges_us"]) == len(histogram["blocks"]) + 1


def test_parts_cost_something_and_nothing_beats_the_roofline(report):
    parts = report["parts_ns"]
    assert {"strings without contact", "strings with 3 contacts", "constraint solve and body", "convolution"} <= set(
        parts
    )
    assert all(cost > 0 for cost in parts.values())
    assert all(cost > 0 for cost in report["gestures_us"].values())
    roof = report["roofline"]
    assert roof["flops"] > 10_000 and roof["bytes"] > 10_000
    assert 0 < roof["share"] == pytest.approx(roof["least_ns"] / roof["measured_ns"])


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--cases", "whole,wholly"], "--cases wholly: there is no such case; legal are whole, piece"),
        (["--growth", "--json"], "leave --json away"),
        (["--json", "--compare", "x.json"], "leave one of them away"),
        (["--compare", "nowhere.json"], "nowhere.json: No such file"),
        (["--plot", "nowhere/x.png"], "--plot nowhere/x.png"),
    ],
)
def test_contradictions_are_refused_before_anything_is_measured(capsys, options, words):
    assert main(["bench", *options]) == 2
    assert words in capsys.readouterr().err


def test_quantiles_and_speeds_are_ordered(report):
    assert report["period_ms"] == pytest.approx(1e3 * 256 / 48000)
    for case in report["cases"]:
        quantiles = list(case["block_us"].values())
        assert quantiles == sorted(quantiles) and quantiles[0] > 0
        runs = case["times_real_time_runs"]
        assert len(runs) == report["runs"] and min(runs) <= case["times_real_time"] <= max(runs)


@pytest.mark.skipif(not hasattr(os, "sched_getaffinity"), reason="this system keeps no process on a core")
def test_one_core_is_used_and_all_are_given_back():
    before = os.sched_getaffinity(0)
    with one_core() as core:
        assert os.sched_getaffinity(0) == {core} <= before
    assert os.sched_getaffinity(0) == before


def test_the_tables_fit_a_terminal_and_compare(capsys, monkeypatch, tmp_path, report):
    pytest.importorskip("matplotlib")
    monkeypatch.setenv("COLUMNS", "80")
    old = tmp_path / "old.json"
    old.write_text(json.dumps(report))
    picture = tmp_path / "blocks.png"
    options = ["--seconds", "1", "--cases", "whole, open", "--compare", str(old), "--plot", str(picture)]
    assert main(["bench", *options]) == 0
    printed = capsys.readouterr()
    assert "x real time" in printed.out and "p99.9 of period" in printed.out and "ratio" in printed.out
    assert "block_frames was 256 and is 128" in printed.err
    assert "…" not in printed.out and "barre" not in printed.out
    assert picture.read_bytes().startswith(b"\x89PNG")
