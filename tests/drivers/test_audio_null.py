"""The null output: any block size, the clock it keeps, and what it does when it is late."""

import ctypes

import numpy as np
import pytest
import soundfile
from devices import wait_until

from ukrt.drivers.sound import null
from ukrt.drivers.sound.null import NullOutput
from ukrt.engine.callback_type import CALLBACK
from ukrt.engine.engine import Engine
from ukrt.errors import DeviceError
from ukrt.model.presets import load_preset

ODD = [1, 10, 17, 1024, 1536, 2027, 4096, 16384]
GUITAR = load_preset("paper")


def make_engine():
    engine = Engine(GUITAR, shared=True)
    engine.output_gain = engine.instance.preset_gain
    engine.shed_budget = 0.0  # what is left out on a slow machine is another test's matter
    return engine


@pytest.fixture
def engine():
    engine = make_engine()
    yield engine
    engine.close()


@pytest.fixture(scope="module")
def reference():
    """The first second of a note, in blocks of 64 (ndarray (frames, 2) float32)."""
    engine = make_engine()
    engine.send(100, 0x90, 64, 100)
    blocks = [engine.process_card(64) for _ in range(750)]
    engine.close()
    return np.concatenate(blocks)


@pytest.mark.parametrize("block", ODD)
def test_the_sound_does_not_depend_on_the_block(engine, reference, block, tmp_path):
    """Through the null output itself: what its file holds are the bits that blocks of 64 give."""
    engine.send(100, 0x90, 64, 100)
    output = NullOutput(engine, block, tmp_path / "heard.wav")
    output.start()
    wait_until(lambda: engine.frame >= 2400)
    assert output.running
    assert output.close()
    heard, rate = soundfile.read(tmp_path / "heard.wav", dtype="float32")
    assert (rate, len(heard)) == (48000, engine.frame)
    n = min(len(heard), len(reference))
    assert n >= 2400 and np.abs(reference[:n]).max() > 0.01
    assert np.array_equal(heard[:n], reference[:n])


def test_blocks_that_change_at_random_give_the_same_bits(engine, reference):
    """As from a server whose period is changed while it runs, beyond what anybody announced."""
    engine.send(100, 0x90, 64, 100)
    random, blocks = np.random.default_rng(3), []
    while sum(map(len, blocks)) < len(reference):
        sizes = [1, 10, 17, 64, 1024, 1536, 2027, random.integers(1, 999)]
        blocks.append(engine.process_card(int(random.choice(sizes))))
    assert np.array_equal(np.concatenate(blocks)[: len(reference)], reference)
    assert engine.process_card(16384).shape == (16384, 2)


class Clock:
    """Time that passes only where somebody sleeps, plus what a test adds."""

    def __init__(self):
        self.now, self.slept = 100.0, 0.0

    def perf_counter(self):
        return self.now

    def sleep(self, seconds):
        self.now += seconds
        self.slept += seconds


class Counting:
    """An engine that counts what it is asked for, with something to do in between."""

    channels, userdata_address = 2, 0

    def __init__(self, clock, blocks, lateness=lambda block: 0.0):
        self.sample_rate, self.times, self._clock = 44100.0, [], clock
        self._most, self._lateness = blocks, lateness
        self._callback = CALLBACK(self._render)
        self.callback_address = ctypes.cast(self._callback, ctypes.c_void_p).value

    def _render(self, _input, out, frames, _time, _flags, userdata):
        self.times.append(self._clock.now)
        self._clock.now += self._lateness(len(self.times))
        return 2 if len(self.times) == self._most else 0


def run(monkeypatch, blocks, lateness=lambda block: 0.0, prepare=lambda engine: None):
    clock = Clock()
    monkeypatch.setattr(null, "time", clock)
    engine = Counting(clock, blocks, lateness)
    prepare(engine)
    output = NullOutput(engine, 100, silent=True)
    output._run()
    return np.array(engine.times) - 100.0, output


def test_the_clock_does_not_drift(monkeypatch):
    times, output = run(monkeypatch, 200_000)
    assert np.abs(times - np.arange(200_000) * 100 / 44100).max() < 1e-8
    assert output.late_blocks == 0 and output.path is None


def test_what_is_a_little_late_is_made_up_for(monkeypatch):
    times, output = run(monkeypatch, 1000, lambda block: 0.1 if block == 500 else 0.0)
    assert output.late_blocks == 43  # began 1 period late or more: 100 ms less k periods of 2.27 ms
    assert abs(times[-1] - 999 * 100 / 44100) < 1e-8 and output.skipped_seconds == 0.0


def test_what_is_very_late_is_let_go(monkeypatch):
    times, output = run(monkeypatch, 1000, lambda block: 10.0 if block == 500 else 0.0)
    assert output.late_blocks == 1
    assert output.skipped_seconds == pytest.approx(10.0 - 100 / 44100)
    assert times[-1] == pytest.approx(999 * 100 / 44100 + output.skipped_seconds)


def test_another_sample_rate_is_followed(monkeypatch):
    def change_at_500(engine):
        engine._lateness = lambda block: setattr(engine, "sample_rate", 96000.0 if block >= 500 else 44100.0) or 0.0

    times, output = run(monkeypatch, 1000, prepare=change_at_500)
    assert np.allclose(np.diff(times)[:498], 100 / 44100) and np.allclose(np.diff(times)[501:], 100 / 96000)
    assert output.sample_rate == 96000.0


def test_two_outputs_never_call_one_engine(engine):
    first, second = NullOutput(engine, 64, silent=True), NullOutput(engine, 128, silent=True)
    first.start()
    with pytest.raises(DeviceError, match="the null output is playing; close that one first"):
        second.start()
    wait_until(lambda: engine.frame >= 640)
    assert first.running and engine.frame % 64 == 0
    first.close()
    before = engine.frame
    second.start()
    wait_until(lambda: engine.frame > before)
    second.close()
