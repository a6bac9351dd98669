"""Intonations that other processes have solved: the same numbers, or solved again."""

import numpy as np
import pytest

from ukrt.engine import solved_intonations as solved
from ukrt.model import intonation
from ukrt.model.presets import load_preset

NAMES = ("tensions", "places", "cents_left", "decay_rates")
QUICK = {"tuning.mode": "published", "playing.frets": "3"}  # nothing to search for


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """A cache of our own, and a process that remembers nothing."""
    monkeypatch.setenv("UKRT_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(intonation, "_known", {})
    return tmp_path / "intonations"


@pytest.fixture
def forget(monkeypatch):
    """As if another process went on, which cannot solve."""

    def forget():
        monkeypatch.setattr(intonation, "_known", {})
        monkeypatch.setattr(intonation, "_solve", None)

    return forget


@pytest.mark.parametrize("preset, overrides", [("classical", {}), ("paper", QUICK)])
def test_another_process_finds_the_same_numbers(forget, preset, overrides):
    first = solved.solved_intonation(load_preset(preset, overrides))
    forget()
    again = solved.solved_intonation(load_preset(preset, overrides))
    for name in NAMES:
        one, other = getattr(first, name), getattr(again, name)
        assert one is not other and one.shape == other.shape and one.tobytes() == other.tobytes()
        assert not other.flags.writeable
    assert intonation.make_intonation(load_preset(preset, overrides)) is again


def test_what_the_solution_depends_on_names_its_file(monkeypatch):
    def place(**overrides):
        return solved._place(intonation.what_counts(load_preset("paper", QUICK | overrides)))

    usual = place()
    assert place() == usual and place(**{"basis.bandwidth_hz": "7000"}) == usual  # the solution has modes to 400 kHz
    assert place(**{"strings.2.tension": "60"}) != usual
    assert place(**{"damper.damping_ratio": "0.9"}) != usual
    monkeypatch.setattr(np, "__version__", "another")
    assert place() != usual


@pytest.mark.parametrize("content", [b"", b"no array", None])
def test_a_file_that_is_not_whole_is_solved_again(folder, content):
    guitar = load_preset("paper", QUICK)
    first = solved.solved_intonation(guitar)
    (path,) = folder.iterdir()
    whole = path.read_bytes()
    path.write_bytes(whole[:-5] if content is None else content)
    intonation._known.clear()
    assert solved.solved_intonation(guitar).places.tobytes() == first.places.tobytes()
    assert path.read_bytes() == whole


def test_only_the_newest_are_kept(folder, monkeypatch):
    monkeypatch.setattr(solved, "_MOST", 2)
    for tension in ("60", "61", "62"):
        solved.solved_intonation(load_preset("paper", QUICK | {"strings.2.tension": tension}))
    assert len(list(folder.iterdir())) == 2


def test_a_cache_that_cannot_be_written_is_no_hindrance(folder):
    folder.write_bytes(b"a file where the folder would be")
    assert len(solved.solved_intonation(load_preset("paper", QUICK)).tensions) == 6
