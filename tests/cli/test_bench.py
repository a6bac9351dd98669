"""``ukrt bench``: what it measures, told as numbers and as a table. Speeds themselves are no test's business."""

import contextlib
import io
import json
import os

import pytest

from ukrt.cli.bench import one_core
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
    }
    assert [case["strings_plucked"] for case in report["cases"]] == [6] * len(report["cases"])


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


def test_the_table_fits_a_terminal(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    assert main(["bench", "--seconds", "1"]) == 0
    out = capsys.readouterr().out
    assert "x real time" in out and "p99.9 of period" in out and "convolution" in out
    assert "…" not in out
