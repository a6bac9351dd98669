"""Live sessions without a server: the order of things, other guitars, what is told."""

import json
import threading

import pytest
from devices import Device
from live_bench import GUITAR, OTHER, Bench, Part, Tape, make_engine

from ukrt.engine import stage_layout as at
from ukrt.engine.instance import Instance
from ukrt.errors import DeviceError, PresetError


@pytest.fixture
def engine():
    engine = make_engine()
    yield engine
    engine.close()


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


def test_what_is_left_out_on_a_slow_computer_is_told(engine):
    bench = Bench(engine, Device(engine, "card"))
    with bench.session:
        engine.stage.si[at.G_SHED_WANTED] = 2
        bench.wait(lambda: any("level 2" in sentence for sentence in bench.news))
        assert bench.session.state()["shed_level"] == 2
        engine.shed_budget = 0.0
        bench.wait(lambda: any("nothing is left out" in sentence for sentence in bench.news))


def test_the_output_is_looked_after_and_what_it_says_is_told(engine):
    class Wired(Device):
        sentences = ("a cable is in", "a cable is out")

        def tend(self):
            said, self.sentences = self.sentences[:1], self.sentences[1:]
            return said

    bench = Bench(engine, Wired(engine))
    with bench.session:
        bench.wait(lambda: len(bench.news) == 2)
    assert bench.news == ["a cable is in", "a cable is out"]
