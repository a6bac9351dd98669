"""Random messages of every kind: afterwards no note, finger or damper is stuck, and what rings along dies away.

A million of them: tools/stuck_notes.py.
"""

import pytest
from engine.storm import leftovers, storm

from ukrt.engine.engine import Engine
from ukrt.model.presets import load_preset

GUITARS = {
    "classical": ("classical", "open", "keyboard"),
    "classical, damped": ("classical", "damped", "guitar-mpe"),
    "ukulele": ("ukulele", "open", "mpe"),
    "eight-string": ("eight-string", "open", "guitar"),
}


@pytest.fixture(scope="module", params=GUITARS)
def engine(request):
    preset, idle, mode = GUITARS[request.param]
    settings = {"playing.idle_strings": idle, "playing.midi_mode": mode}
    engine = Engine(load_preset(preset, settings), signal="bridge-force")
    yield engine
    engine.close()


@pytest.mark.parametrize("seed, count, per_second", [(1, 400, 200.0), (2, 2000, 2000.0), (3, 10000, 20000.0)])
def test_nothing_is_stuck_after_a_storm(engine, seed, count, per_second):
    outcome = storm(engine, seed, count, per_second)
    assert outcome.complaints() == []
    assert outcome.counters["notes_played"] > 0.1 * count and outcome.before_j > 1e-6, "hardly anything sounded"


def test_what_is_stuck_is_told(engine):
    storm(engine, 4, 500, 2000.0)
    engine.send(engine.frame, 0x90, 64, 90)
    engine.process(24000)
    found = " ".join(leftovers(engine))
    assert "the player's state" in found and ("no damper" in found) == (engine.guitar.playing.idle_strings == "damped")
