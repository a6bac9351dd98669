"""Live sessions without a server: the order of things, outputs that die or fall silent, other guitars and rates."""

import dataclasses
import threading

import pytest
from devices import Device, wait_until

from ukrt.drivers.live import LiveSession
from ukrt.drivers.live_watch import MissingFrames, StallWatch
from ukrt.engine.engine import Engine
from ukrt.engine.instance import Instance
from ukrt.errors import DeviceError, PresetError
from ukrt.model.presets import load_preset

GUITAR = load_preset("paper")
OTHER = dataclasses.replace(load_preset("drop-d"), name="other")


@pytest.fixture
def engine():
    engine = Engine(GUITAR, shared=True)
    engine.output_gain = engine.instance.preset_gain
    engine.shed_budget = 0.0
    yield engine
    engine.close()


class Bench:
    """A session on devices of the test's making; `news` keeps all that was told."""

    def __init__(self, engine, *devices, **options):
        self.engine, self.devices, self.news = engine, list(devices), []
        self.attempts = 0
        self.session = LiveSession(engine, self.open, **options)

    def open(self):
        """The next device; an exception among them is raised, and so is the last one again and again."""
        self.attempts += 1
        device = self.devices.pop(0) if len(self.devices) > 1 else self.devices[0]
        if isinstance(device, Exception):
            raise device
        return device

    def turn(self):
        self.session.tend()
        self.news += self.session.news()

    def wait(self, condition):
        wait_until(condition, meanwhile=self.turn)
        self.turn()

    def advance(self, frames=4800):
        """Let that many frames go by."""
        end = self.engine.frame + frames
        self.wait(lambda: self.engine.frame >= end)


class Part:
    """Anything that is started and closed, with a diary."""

    def __init__(self, name, diary, failing=None):
        self.name, self._diary, self._failing = name, diary, failing

    def start(self):
        self._diary.append(f"{self.name} starts")
        if self._failing == "start":
            raise DeviceError(f"{self.name} cannot start")

    def close(self):
        self._diary.append(f"{self.name} closes")
        if self._failing == "close":
            raise KeyboardInterrupt


class Tape(Part):
    """A recorder that notes what it is told."""

    def __init__(self):
        super().__init__("tape", [])
        self.announced = []

    def announce(self, instance):
        self.announced.append(instance)


def make_bench_of_parts(engine, **failing):
    diary = []
    parts = {name: Part(name, diary, failing.get(name)) for name in ("keys", "piece", "tape")}
    device = Device(engine, "card", diary=diary)
    bench = Bench(engine, device, midi_sources=[parts["keys"]], player=parts["piece"], recorders=[parts["tape"]])
    return bench, diary


ENDS = ["piece closes", "keys closes", "card closes", "tape closes"]


class TestOrder:
    def test_everything_starts_and_ends_in_the_safe_order(self, engine):
        bench, diary = make_bench_of_parts(engine)
        with bench.session:
            bench.advance()
            assert bench.session.output.running and not bench.session.away
        assert diary == ["tape starts", "card starts", "keys starts", "piece starts", *ENDS]
        assert bench.session.closed_cleanly and bench.session.seconds > 0
        frame = engine.frame
        assert engine.process_card(1).shape == (1, 2) and engine.frame == frame + 1  # nobody else asks any more

    def test_a_part_that_cannot_start_leaves_nothing_running(self, engine):
        bench, diary = make_bench_of_parts(engine, keys="start")
        with pytest.raises(DeviceError, match="keys cannot start"), bench.session:
            pytest.fail("it has started")
        assert diary == ["tape starts", "card starts", "keys starts", *ENDS]

    @pytest.mark.parametrize("part", ["piece", "keys", "tape"])
    def test_an_interrupt_while_closing_closes_the_rest_too(self, engine, part):
        bench, diary = make_bench_of_parts(engine, **{part: "close"})
        with pytest.raises(KeyboardInterrupt), bench.session:
            pass
        assert diary[-4:] == ENDS

    def test_an_output_that_cannot_be_opened_at_the_start_is_told_at_once(self, engine):
        diary = []
        bench = Bench(engine, DeviceError("no such card"), recorders=[Part("tape", diary)])
        with pytest.raises(DeviceError, match="no such card"), bench.session:
            pytest.fail("it has started")
        assert diary == ["tape starts", "tape closes"]


class TestReconnection:
    def test_a_dead_output_is_replaced_and_comes_back(self, engine):
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

    def test_an_output_that_falls_silent_is_noticed(self, engine):
        first, second = Device(engine, "first"), Device(engine, "second")
        bench = Bench(engine, first, second)
        with bench.session as session:
            bench.advance()
            first.stall()
            assert first.running
            bench.wait(lambda: session.reconnections and session.output is second)
            bench.advance()
        assert "first has asked for no sound for 1." in bench.news[0]

    def test_pauses_between_attempts_grow_to_five_seconds(self, engine):
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

    def test_tending_never_waits_for_an_output_that_does_not_open(self, engine):
        open_now = threading.Event()
        second = Device(engine, "second")

        class Stubborn(Bench):
            def open(self):
                device = super().open()
                assert device is not second or open_now.wait(20)
                return device

        bench = Stubborn(engine, Device(engine, "first"), second)
        with bench.session as session:
            session.output.die()
            bench.wait(lambda: bench.attempts == 2)
            for _ in range(100):
                bench.turn()
            bench.advance()  # the null output goes on meanwhile
            assert session.away and not open_now.is_set()
            open_now.set()
            bench.wait(lambda: session.reconnections and session.output is second)

    def test_a_session_ends_while_an_output_is_being_opened(self, engine, monkeypatch):
        monkeypatch.setattr("ukrt.drivers.live_output._LEAVE_SECONDS", 0.05)
        open_now, diary = threading.Event(), []
        late = Device(engine, "late", diary=diary)

        class Stubborn(Bench):
            def open(self):
                device = super().open()
                assert device is not late or open_now.wait(20)
                return device

        bench = Stubborn(engine, Device(engine, "first"), late)
        with bench.session as session:
            session.output.die()
            bench.wait(lambda: bench.attempts == 2)
        assert session.output.name == "the null output" and not session.output.running
        open_now.set()
        wait_until(lambda: diary)
        assert diary == ["late closes"]  # never started

    def test_an_output_that_dies_at_its_start_is_tried_again(self, engine):
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

    def test_a_host_that_dies_within_a_block_brings_the_strings_to_rest(self, engine):
        from ukrt.engine import stage_layout as at

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

    def test_another_sample_rate_is_followed(self, engine):
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

    def test_the_first_output_may_have_another_sample_rate_too(self, engine):
        bench = Bench(engine, Device(engine, sample_rate=44100.0))
        with bench.session:
            bench.advance()
            assert engine.sample_rate == 44100.0


class TestGuitars:
    def change(self, bench, guitar):
        bench.session.change_preset(guitar)
        bench.wait(lambda: bench.news)

    def test_another_guitar_takes_over_at_the_loudness_the_old_one_was_turned_to(self, engine):
        tape = Tape()
        bench = Bench(engine, Device(engine), recorders=[tape])
        engine.output_gain = 0.5 * engine.instance.preset_gain
        with bench.session as session:
            engine.send(-1, 0x90, 52, 90)
            bench.advance()
            self.change(bench, OTHER)
            bench.wait(lambda: engine.guitar is OTHER and not engine.swapping)
            assert session.state()["changes"] == 1 and session.output.refreshed == 2
        assert bench.news == ["the guitar is now other"]
        assert [instance.guitar for instance in tape.announced] == [OTHER]
        assert engine.output_gain == pytest.approx(0.5 * engine.instance.preset_gain)
        assert engine.counters()["resets"] == 0

    def test_several_one_after_another(self, engine):
        bench = Bench(engine, Device(engine))
        with bench.session:
            for guitar in (OTHER, GUITAR, OTHER):
                bench.session.change_preset(guitar)
            bench.wait(lambda: "the guitar is now other" in bench.news and engine.guitar is OTHER)
            bench.advance()
            assert engine.guitar is OTHER

    @pytest.mark.parametrize("fault", [PresetError("guitar.toml: strings is missing"), ZeroDivisionError("by zero")])
    def test_a_broken_preset_leaves_the_guitar_as_it_is(self, engine, fault):
        def load():
            raise fault

        bench = Bench(engine, Device(engine))
        with bench.session as session:
            bench.advance()
            self.change(bench, load)
            bench.advance()
            assert engine.guitar is GUITAR and session.output.running
            bench.news.clear()
            self.change(bench, OTHER)  # and the next one is changed to
            bench.wait(lambda: engine.guitar is OTHER)
        assert engine.counters()["swaps"] == 1

    def test_a_guitar_that_cannot_be_built_leaves_the_old_one(self, engine):
        def prepare(engine, guitar, sample_rate):
            raise DeviceError("no memory")

        bench = Bench(engine, Device(engine), prepare=prepare)
        with bench.session:
            bench.advance()
            self.change(bench, OTHER)
        assert bench.news == ["the guitar stays as it is: no memory"] and engine.guitar is GUITAR

    def test_a_host_that_will_not_take_it_over_keeps_the_old_one(self, engine):
        class Refusing(Device):
            def refresh(self):
                if self.running:
                    raise DeviceError("it does not answer")

        bench = Bench(engine, Refusing(engine))
        with bench.session:
            bench.advance()
            self.change(bench, OTHER)
            bench.advance()
        assert bench.news == ["the guitar stays as it is: it does not answer"]
        assert engine.guitar is GUITAR and engine.counters()["swaps"] == 0

    def test_it_is_changed_while_the_output_is_away(self, engine):
        bench = Bench(engine, Device(engine, "first"), DeviceError("no server"))
        with bench.session as session:
            session.output.die()
            bench.wait(lambda: session.away)
            session.change_preset(OTHER)
            bench.wait(lambda: engine.guitar is OTHER)

    def test_a_guitar_prepared_for_a_rate_that_has_passed_is_prepared_again(self, engine):
        """The output comes back at another rate while a guitar is being built for the old one."""
        rates, building, go_on = [], threading.Event(), threading.Event()

        def prepare(engine, guitar, sample_rate):
            if guitar is OTHER:
                rates.append(sample_rate)
                building.set()
                assert go_on.wait(20)
            return Instance(guitar, sample_rate, engine.signal, shared=True)

        bench = Bench(engine, Device(engine, "first"), Device(engine, "second", 44100.0), prepare=prepare)
        with bench.session as session:
            bench.advance()
            session.change_preset(OTHER)
            assert building.wait(20)
            session.output.die()
            bench.wait(lambda: engine.sample_rate == 44100.0)
            go_on.set()
            bench.wait(lambda: engine.guitar is OTHER)
            assert engine.sample_rate == 44100.0
        assert rates == [48000.0, 44100.0]


def test_the_state_can_be_written_as_json(engine):
    import json

    bench = Bench(engine, Device(engine))
    with bench.session as session:
        engine.send(-1, 0x90, 52, 100)
        bench.advance(9600)
        state = session.state()
    assert json.loads(json.dumps(state)) == state
    assert state["output"] == "the device" and state["block_size"] == 128 and state["latency_ms"] == 2.7
    assert 0 < state["load_p50"] <= state["load_p99"] <= state["load_p999"] <= state["load_max"]
    assert state["blocks"] * 128 >= 9600 and -60 < state["peak_db"] < 20
    assert session.state()["output"] == "the device"  # and also afterwards


def test_a_thread_that_has_failed_is_told_once(engine):
    bench = Bench(engine, Device(engine), player=Part("piece", []))
    with bench.session:
        bench.session.player.failure = OSError("the disk is gone")
        for _ in range(3):
            bench.turn()
    assert bench.news == ["Part has failed: the disk is gone"]


class TestStallWatch:
    def test_standing_still_for_a_second_or_eight_blocks(self):
        def looks(frame, first, last, block_seconds):
            return [watch.look(frame, 0.05 * k, block_seconds) for k in range(first, last)]

        watch = StallWatch()
        assert not any(looks(0, 0, 20, 0.01) + looks(64, 20, 41, 0.01))  # 1 s each
        assert all(looks(64, 42, 44, 0.01))
        assert not any(looks(128, 44, 77, 0.2))  # blocks of 200 ms: 1.6 s
        assert all(looks(128, 78, 80, 0.2))
        watch.restart(4.0)
        assert not any(looks(128, 80, 100, 0.01))

    def test_who_did_not_look_himself_blames_nobody(self):
        watch = StallWatch()
        assert not watch.look(64, 10.0, 0.01)
        assert not watch.look(64, 100.0, 0.01)  # this process was stopped, and so may the other have been
        assert not watch.look(128, 100.05, 0.01)


class TestMissingFrames:
    """An output with blocks of 128 frames at 48 kHz whose lateness, gaps and clock the test makes."""

    def play(self, missing, blocks=18750, lost=lambda k: 0, late=lambda k: 0.0, clock=1.0):
        frames, gone = 0, 0
        for k in range(blocks):
            gone += lost(k)
            seconds = (k + gone) * 128 / 48000 * clock + late(k)
            if k % 19 == 0:  # twenty looks a second
                missing.look(frames, 1_000_000_000 + round(seconds * 1e9), 48000.0, 128)
            frames += 128
        return missing.frames

    def test_none_where_all_were_asked_for(self):
        assert self.play(MissingFrames()) == 0

    def test_neither_lateness_nor_a_slow_clock_is_a_gap(self):
        noise = iter(range(10**9))
        late = lambda k: 0.002 * (next(noise) * 7919 % 1000) / 1000  # noqa: E731
        assert self.play(MissingFrames(), late=late) == 0
        assert self.play(MissingFrames(), clock=1.0002) == 0
        assert self.play(MissingFrames(), clock=0.9998) == 0

    def test_every_block_that_was_left_out_counts(self):
        assert self.play(MissingFrames(), lost=lambda k: {4000: 1, 9000: 40, 9100: 2}.get(k, 0)) == 43 * 128

    def test_what_is_made_up_for_is_not_missing(self):
        """A server that stops for half a second and then calls as often as it takes to catch up."""
        late = lambda k: max(0.0, 0.5 - 0.001 * (k - 5000)) if k >= 5000 else 0.0  # noqa: E731
        assert self.play(MissingFrames(), late=late) == 0

    def test_the_time_between_two_outputs_is_not_missing(self):
        missing = MissingFrames()
        self.play(missing, 5000)
        missing.restart()
        missing.look(5000 * 128, 90_000_000_000, 48000.0, 128)
        assert missing.frames == 0 and self.play(missing, 5000) == 0

    def test_a_stamp_without_a_time_is_no_stamp(self):
        missing = MissingFrames()
        missing.look(0, 0, 48000.0, 128)
        assert self.play(missing) == 0
