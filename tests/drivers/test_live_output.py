"""Outputs that die, fall silent, do not open or come back at another rate, and the session that goes on."""

import threading

import pytest
from devices import Device, wait_until
from live_bench import Bench, Tape, make_engine

from ukrt.engine import stage_layout as at
from ukrt.errors import DeviceError


@pytest.fixture
def engine():
    engine = make_engine()
    yield engine
    engine.close()


def test_a_dead_output_is_replaced_and_comes_back(engine):
    first, second = Device(engine, "first"), Device(engine, "second")
    first.gaps, second.gaps = 3, 4
    bench = Bench(engine, first, second)
    with bench.session as session:
        engine.send(-1, 0x90, 52, 90)
        bench.advance()
        first.die()
        bench.wait(lambda: session.away)
        assert session.output.name == "the null output" and session.xruns() == 3
        bench.wait(lambda: session.reconnections and session.output is second)
        bench.advance()
        assert session.reconnections == 1 and session.xruns() == 7
        assert second.refreshed == 1  # a guitar loaded while it was being opened would be seen
    assert bench.news == ["first has ended; the guitar plays on unheard until it is back", "second is back"]
    assert engine.counters()["resets"] == 0
    assert [note["end_s"] for note in engine.note_log()] == [None]  # the key is still held


def test_an_output_that_falls_silent_is_noticed(engine):
    first, second = Device(engine, "first"), Device(engine, "second")
    bench = Bench(engine, first, second)
    with bench.session as session:
        bench.advance()
        first.stall()
        assert first.running
        bench.wait(lambda: session.reconnections and session.output is second)
        bench.advance()
    assert "first has asked for no sound for 1." in bench.news[0]


def test_pauses_between_attempts_grow_to_five_seconds(engine):
    class Ending(threading.Event):
        pauses = []  # noqa: RUF012

        def wait(self, timeout=None):
            self.pauses.append(timeout)
            return super().wait(0.001)

    refusals = [DeviceError("no server")] * 5 + [DeviceError("another reason")] * 4
    bench = Bench(engine, Device(engine, "first"), *refusals, Device(engine, "second"))
    bench.session._keeper._ending = Ending()
    with bench.session as session:
        bench.advance()
        session.output.die()
        bench.wait(lambda: session.reconnections)
    assert Ending.pauses == [0.25, 0.5, 1.0, 2.0, 4.0, 5.0, 5.0, 5.0, 5.0, 5.0]
    assert bench.attempts == 11
    told = [sentence for sentence in bench.news if "still no sound" in sentence]
    assert told == ["still no sound: no server", "still no sound: another reason"]  # each once


class Stubborn(Bench):
    """The second device opens when `open_now` is set."""

    def __init__(self, *arguments):
        super().__init__(*arguments)
        self.open_now = threading.Event()

    def open(self):
        device = super().open()
        assert self.attempts != 2 or self.open_now.wait(20)
        return device

    def wait_for_the_second_attempt(self):
        """The first device dies, the second is being opened."""
        self.session.output.die()
        self.wait(lambda: self.attempts == 2)


def test_tending_never_waits_for_an_output_that_does_not_open(engine):
    second = Device(engine, "second")
    bench = Stubborn(engine, Device(engine, "first"), second)
    with bench.session as session:
        bench.wait_for_the_second_attempt()
        for _ in range(100):
            bench.turn()
        bench.advance()  # the null output goes on meanwhile
        assert session.away and not bench.open_now.is_set()
        bench.open_now.set()
        bench.wait(lambda: session.reconnections and session.output is second)


def test_a_session_ends_while_an_output_is_being_opened(engine, monkeypatch):
    monkeypatch.setattr("ukrt.drivers.live.output._LEAVE_SECONDS", 0.05)
    diary = []
    bench = Stubborn(engine, Device(engine, "first"), Device(engine, "late", diary=diary))
    with bench.session as session:
        bench.wait_for_the_second_attempt()
    assert session.output.name == "the null output" and not session.output.running
    bench.open_now.set()
    wait_until(lambda: diary)
    assert diary == ["late closes"]  # never started


def test_an_output_that_dies_at_its_start_is_tried_again(engine):
    class Broken(Device):
        def start(self):
            raise DeviceError("the wire is hot")

    bench = Bench(engine, Device(engine, "first"), Broken(engine), Device(engine, "third"))
    with bench.session as session:
        session.output.die()
        bench.wait(lambda: session.reconnections)
        bench.advance()
        assert session.output.name == "third"
    assert "still no sound: the wire is hot" in bench.news


def test_a_host_that_dies_within_a_block_brings_the_strings_to_rest(engine):
    bench = Bench(engine, Device(engine, "first"), Device(engine, "second"))
    with bench.session as session:
        engine.send(-1, 0x90, 52, 90)
        bench.advance()
        session.output.die()
        engine.stage.si[at.G_BUSY] = 1  # as a killed process leaves it
        bench.wait(lambda: session.reconnections)
        bench.wait(lambda: engine.counters()["resets"])
        bench.advance()
    assert "first died in the middle of a block: all strings were brought to rest" in bench.news
    assert engine.counters()["resets"] == 1 and engine.energy() < 1e-12


def test_another_sample_rate_is_followed(engine):
    tape = Tape()
    bench = Bench(engine, Device(engine, "first"), Device(engine, "second", 44100.0), recorders=[tape])
    with bench.session as session:
        engine.send(-1, 0x90, 52, 90)
        bench.advance()
        session.output.die()
        bench.wait(lambda: session.reconnections and engine.sample_rate == 44100.0)
        bench.advance()
        assert session.state()["sample_rate"] == 44100.0
    assert [instance.sample_rate for instance in tape.announced] == [44100.0]
    assert "second is back, now at 44100 Hz" in bench.news
    assert engine.counters()["swaps"] == 1 and engine.counters()["resets"] == 0
    assert [note["end_s"] for note in engine.note_log()] == [None]
    assert engine.output_gain == pytest.approx(engine.instance.preset_gain)


def test_the_first_output_may_have_another_sample_rate_too(engine):
    bench = Bench(engine, Device(engine, sample_rate=44100.0))
    with bench.session:
        bench.advance()
        assert engine.sample_rate == 44100.0
