"""The bundled demonstration: what its script writes, and played as it says."""

import io
import pathlib

import numpy as np
import pytest
from tool_scripts import load_tool

from ukrt.drivers.files.midi import load_midi_file
from ukrt.model.presets import load_preset
from ukrt.notation.silent import play_silently

ROOT = pathlib.Path(__file__).resolve().parents[2]
PIECE = ROOT / "ukrt" / "data" / "demonstration.mid"


@pytest.fixture(scope="module")
def script():
    return load_tool("make_demonstration")


@pytest.fixture(scope="module")
def score():
    return load_midi_file(PIECE)


def test_the_script_reproduces_the_file(script):
    buffer = io.BytesIO()
    script.make_demonstration().save(file=buffer)
    assert buffer.getvalue() == PIECE.read_bytes()


def test_each_section_has_a_marker_where_it_begins(script, score):
    assert score.warnings == ()
    assert score.markers == tuple((script.starts(k)[0], one.name) for k, one in enumerate(script.SECTIONS))


def test_everything_in_it_means_something_to_the_player(score):
    _, _, counters = play_silently(load_preset("classical"), score)
    assert counters["notes_played"] == counters["notes_on"] == score.n_notes
    unheard = ("notes_folded", "messages_ignored", "controllers_ignored", "rpn_ignored", "forces_refused", "stretches")
    assert {name: counters[name] for name in unheard} == dict.fromkeys(unheard, 0)


def test_each_section_is_played_as_it_says(script, score):
    """Halves begin with the same keys on the same strings, the last note of the second in the section's own way."""
    notes, _, _ = play_silently(load_preset("classical"), score)
    for k, section in enumerate(script.SECTIONS):
        plain, played, end = script.starts(k)
        halves = [[n for n in notes if a <= n["time_s"] < b] for a, b in ((plain, played), (played, end))]
        sounds = [[(note["midi"], note["string"]) for note in half] for half in halves]
        assert len(sounds[0]) >= 1 and sounds[0][0][0] == sounds[1][0][0]
        assert halves[1][-1]["articulation"] == section.way, section.name
        assert {note["articulation"] for note in halves[0]} == {"pluck"}, section.name


def test_every_section_ends_as_it_began(script, score):
    """Nothing of one section is left in the next: no note, and no controller but where a plain note has it."""
    held, values = set(), {}
    begun = {script.starts(k)[half]: k for k in range(len(script.SECTIONS)) for half in (0, 1)}
    for time, status, first, second in zip(score.time_s, score.status, score.data1, score.data2, strict=True):
        if any(np.isclose(time, start) for start in begun):
            assert not held
            begun = {start: k for start, k in begun.items() if not np.isclose(time, start)}
            assert all(values.get(number, rest) == rest for number, rest in script.STAY.items())
        if status == 0x90 and second:
            held.add(int(first))
        elif status == 0x80:
            held.discard(int(first))
        elif status == 0xB0:
            values[int(first)] = int(second)
