"""Whether the guitar is in tune: the pitch of notes measured on the rendered sound, 0.6 to 3.2 s after the release.

The table of all notes is made by tools/measure_intonation.py.
"""

import functools
import json

import numpy as np
import pytest
from measure.forced_notes import after_release, forced_note, note_pitch
from tool_scripts import load_tool

from ukrt.engine.engine import Engine
from ukrt.model.presets import load_preset

LOUDEST = 1.0  # N: what counts as a soft note
LIMIT = 0.5  # cents
# String and fret. Fundamentals that a body mode takes away fast: F3 and F#3 (0.13 to 2.4), F2 and F#2 beside the air
# mode (0.1, 0.2), A3 and A#3 (0.17, 0.18, 1.13); fast decay high up (4.18, 5.18, 5.19), and some plain ones.
HARDEST = [(0, 0), (0, 1), (0, 2), (0, 13), (0, 14), (0, 17), (0, 18), (1, 8), (1, 9), (1, 13), (2, 3), (2, 4)]
OTHERS = [(1, 0), (2, 12), (3, 0), (3, 2), (3, 8), (4, 4), (4, 18), (5, 0), (5, 18), (5, 19)]


@functools.lru_cache(maxsize=2)
def engine(a4_hz="440"):
    return Engine(load_preset("classical", {"playing.idle_strings": "damped", "tuning.a4_hz": a4_hz}))


@pytest.mark.parametrize(("string", "fret"), HARDEST + OTHERS)
def test_a_note_is_in_tune(string, fret):
    """Within 0.5 cents (in truth 0.04). It is the string's pole: the rate is the one it should have, and nothing else
    near it is as strong or decays as slowly."""
    found = note_pitch(engine(), string, fret, LOUDEST)
    assert abs(found.cents) < LIMIT
    assert found.decay_rate == pytest.approx(engine().intonation.decay_rates[string, fret], rel=0.03)
    assert all(rival.energy < found.energy and rival.decay_rate > found.decay_rate for rival in found.rivals)


def test_the_measurement_hears_another_tuning():
    """A guitar in A = 442 Hz is 7.85 cents too high for A = 440 Hz."""
    found = note_pitch(engine("442"), 1, 3, LOUDEST)
    assert found.cents == pytest.approx(1200.0 * np.log2(442.0 / 440.0), abs=0.05)


@pytest.mark.parametrize("midi", [40, 53, 60, 79])
def test_a_forced_note_is_the_note_that_midi_plays(midi):
    one = engine()
    one.reset()
    one.send(0, 0x90, midi, 20)
    heard = after_release(one, 0.5)
    (note,) = one.note_log()
    assert np.array_equal(heard, forced_note(one, note["string"], note["fret"], note["force_n"], 0.5))
    assert np.max(np.abs(heard)) > 1e-3


def test_the_tool_writes_the_notes_it_was_asked_for(tmp_path, capsys):
    load_tool("measure_intonation").main(
        ["--preset", "drop-d", "--frets", "0,7", "--json", str(tmp_path / "notes.json")]
    )
    report = json.loads((tmp_path / "notes.json").read_text())
    notes = report["idle"]["damped"]["notes"]
    assert [note["midi"] for note in notes] == [38, 45, 45, 52, 50, 57, 55, 62, 59, 66, 64, 71]
    assert max(abs(note["cents"]) for note in notes) < LIMIT
    assert "worst" in capsys.readouterr().out
