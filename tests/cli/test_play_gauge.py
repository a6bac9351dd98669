"""What the status line is fed with, from an engine whose numbers the test sets."""

import types

import numpy as np
import pytest

from ukrt.cli.gauge import Gauge, held_strings
from ukrt.engine import player_layout as player
from ukrt.engine.engine import Engine
from ukrt.model.presets import load_preset


class Dials:
    """An engine that is nothing but its counters."""

    sample_rate = 48000.0

    def __init__(self):
        self.loads = {0.1: 0}
        self.counts = {"midi_received": 0}
        self.instance = types.SimpleNamespace(i=np.zeros(player.S_STATE + 8, np.int64))

    def counters(self):
        return {**self.counts, "load_histogram": sorted(self.loads.items())}


STATE = {
    "seconds": 3.0,
    "output": "a card",
    "sample_rate": 48000.0,
    "block_size": 128,
    "xruns": 7,
    "late_blocks": 0,
    "missing_frames": 0,
    "peak_db": None,
    "limiter_db": 0.0,
    "shed_level": 0,
}


@pytest.fixture
def watched():
    """The dials, and a function that gives the moment with what the session says otherwise."""
    dials = Dials()
    dials.time = 100.0
    gauge = Gauge(dials, now=lambda: dials.time)
    return dials, lambda **state: gauge.moment({**STATE, **state})


def test_loads_are_those_of_the_last_seconds(watched):
    dials, moment = watched
    assert moment().loads is None
    dials.loads = {0.1: 90, 0.9: 10}
    dials.time += 0.1
    assert moment().loads == (0.1, 0.9, 0.9)
    for _ in range(100):
        dials.time += 0.1
        dials.loads[0.1] += 37
        loads = moment().loads
    assert loads == (0.1, 0.1, 0.1), "the slow blocks at the beginning are long past"


def test_messages_are_counted_by_the_second(watched):
    dials, moment = watched
    rates = []
    for k in range(40):
        dials.counts["midi_received"] += 20 * (k < 20)
        rates.append(moment().messages_per_s)
        dials.time += 0.1
    assert rates[0] == 0 and rates[15] == pytest.approx(200, rel=0.11) and rates[-1] == 0


def test_what_goes_wrong_is_trouble_for_a_while(watched):
    dials, moment = watched
    assert not moment().trouble, "what was there before is not news"
    seen = []
    for what in ({"xruns": 8}, {"missing_frames": 250, "xruns": 8}, {"missing_frames": 250, "xruns": 8}):
        dials.time += 1.0
        seen.append(moment(**what).trouble)
    assert seen == [True, True, True] and moment(**what).missing == 2, "blocks, not frames"
    dials.time += 5.0
    assert not moment(**what).trouble
    assert moment(**what, late_blocks=1).trouble


def test_the_rest_is_as_the_session_says(watched):
    _, moment = watched
    assert moment().peak_db == -200.0
    now = moment(peak_db=-6.0, limiter_db=-1.5, shed_level=3)
    assert (now.peak_db, now.limiter_db, now.shed, now.output, now.block) == (-6.0, -1.5, 3, "a card", 128)


def test_strings_that_are_held_are_counted():
    engine = Engine(load_preset("classical"), 48000.0)
    try:
        counts = [held_strings(engine)]
        for message in ((0x90, 52, 90), (0x90, 64, 90), (0xB0, 64, 127), (0x80, 52, 0), (0xB0, 64, 0), (0x80, 64, 0)):
            engine.send(engine.frame, *message)
            engine.process(4096)
            counts.append(held_strings(engine))
    finally:
        engine.close()
    assert counts == [0, 1, 2, 2, 2, 1, 0]
