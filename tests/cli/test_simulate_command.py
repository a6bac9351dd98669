"""``ukrt simulate``: a case file in, a result file and a summary out; one-sentence refusals, nothing half-written."""

import numpy as np
import pytest
from test_arguments import refused, shown

from ukrt.experiment.result import load_result

CASE = """
name = "quick"
duration = 0.01
strings = ["E2"]
plucks = [{ string = "E2", duration = 0.004, force_y = 1.0 }]
guitar = { base = "paper", basis = { bandwidth_hz = 2000.0 } }
record = { energies = true }
"""


@pytest.fixture
def case_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "case.toml"
    path.write_text(CASE, encoding="utf-8")
    return path


@pytest.mark.parametrize("solver", ["reference", "engine"])
def test_a_case_becomes_a_result(capsys, case_file, solver):
    text = shown(capsys, "simulate", case_file, "-o", "out.npz", "--solver", solver, "--set", "plucks.0.force_y=2")
    for words in (f"solver             {solver}", "steps", "modes", "largest drift", "energy at the end", "real time"):
        assert words in text
    result = load_result("out.npz")
    assert result.solver == solver and result.case.plucks[0].force_y == 2.0
    assert result.column("energies", "total")[-1] > 0.0
    assert np.isclose(result.times[-1], 0.01)


def test_the_reference_is_the_default_and_quiet_is_quiet(capsys, case_file):
    assert shown(capsys, "simulate", case_file, "-o", "out.npz", "--quiet") == ""
    assert load_result("out.npz").solver == "reference"


def test_help_and_template(capsys, tmp_path):
    assert "a short case:" in shown(capsys, "simulate", "--help")
    (tmp_path / "case.toml").write_text(shown(capsys, "simulate", "--template"), encoding="utf-8")
    out = tmp_path / "out.npz"
    shown(capsys, "simulate", tmp_path / "case.toml", "-o", out, "--set", "duration=0.001", "--set", 'strings=["E2"]')
    assert load_result(out)["displacement"].shape == (101, 2)


@pytest.mark.parametrize(
    ("argv", "words"),
    [
        ((), "CASE.toml"),
        (("case.toml",), "-o"),
        (("--template", "case.toml"), "--template"),
        (("case.toml", "-o", "out.csv"), ".npz, .h5, .hdf5"),
        (("case.toml", "-o", "no/out.npz"), "no folder"),
        (("absent.toml", "-o", "out.npz"), "absent.toml cannot be read"),
        (("case.toml", "-o", "out.npz", "--solver", "spice"), "--solver"),
        (("case.toml", "-o", "out.npz", "--set", "step=3"), "the settings: step is 3"),
        (("case.toml", "-o", "out.npz", "--set", "step"), "KEY=VALUE"),
        (
            ("case.toml", "-o", "out.npz", "--set", "step=1e-4", "--set", "guitar=paper"),
            "case case.toml: step is 0.0001",
        ),
    ],
)
def test_refusals(capsys, case_file, argv, words):
    assert words in refused(capsys, "simulate", *argv)
    assert [path.name for path in case_file.parent.iterdir()] == ["case.toml"]
