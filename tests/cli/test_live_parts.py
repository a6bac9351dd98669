"""The parts of live playing without devices: null output, frame clock, feeder."""

import time

import numpy as np
import pytest
import soundfile
from fake_engine import FakeEngine, FakeInput

from ukrt.drivers.clock import FrameClock
from ukrt.drivers.feeder import Feeder
from ukrt.drivers.live import LiveSession
from ukrt.drivers.midi_file import Score
from ukrt.drivers.null import NullOutput, new_recording_path
from ukrt.errors import AudioFileError, DeviceError


def wait_until(condition, seconds=10.0):
    ends = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < ends, "waited too long"
        time.sleep(0.005)


def make_score(*events, duration_s):
    times, *columns = zip(*events, strict=True)
    return Score(np.array(times), *(np.array(c, np.uint8) for c in columns), duration_s=duration_s, n_notes=1)


@pytest.mark.parametrize("block", [1, 64, 100, 8192])
def test_null_output_writes_every_block_that_the_engine_computed(tmp_path, block):
    engine = FakeEngine()
    output = NullOutput(engine, block, tmp_path / "heard.wav")
    output.start()
    wait_until(lambda: engine.blocks >= 3)
    assert output.running
    assert output.close()
    samples, rate = soundfile.read(tmp_path / "heard.wav", dtype="float32", always_2d=True)
    assert rate == 48000
    assert len(samples) == engine.frame == engine.blocks * block
    expected = (np.arange(engine.frame) / 1000.0).astype(np.float32)
    assert np.array_equal(samples, np.stack([expected, expected], axis=1))
    assert engine.userdata_seen == {engine.userdata_address}


def test_null_output_keeps_real_time_and_not_more(tmp_path):
    engine = FakeEngine()
    output = NullOutput(engine, 480, tmp_path / "heard.wav")
    start = time.perf_counter()
    output.start()
    time.sleep(0.3)
    output.close()
    assert 0 < engine.frame <= (time.perf_counter() - start) * 48000 + 480


def test_null_output_stops_when_the_callback_says_so(tmp_path):
    engine = FakeEngine()
    engine.result = 2
    output = NullOutput(engine, 64, tmp_path / "heard.wav")
    output.start()
    wait_until(lambda: not output.running)
    assert engine.blocks == 1
    output.close()


def test_null_output_names_the_file_that_it_cannot_write(tmp_path):
    with pytest.raises(AudioFileError, match=r"heard\.wav"):
        NullOutput(FakeEngine(), 64, tmp_path / "absent" / "heard.wav")


def test_recordings_never_take_a_name_that_is_taken(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names = set()
    for _ in range(3):
        path = new_recording_path()
        path.touch()
        names.add(path)
    assert len(names) == 3 and all(path.parent == tmp_path for path in names)


class TestFrameClock:
    """Against a simulated output whose callbacks come late by known amounts."""

    rate, block = 48000.0, 128

    def make(self):
        engine, self.time = FakeEngine(self.rate), 100.0
        return engine, FrameClock(engine, now=lambda: self.time)

    def test_is_smooth_between_blocks_and_never_behind_the_engine(self):
        engine, clock = self.make()
        lateness = np.random.default_rng(1).uniform(0.0, 0.5, 400) * self.block / self.rate
        readings, times = [], []
        for k in range(400):
            for part in range(8):
                due = 100.0 + (k + part / 8) * self.block / self.rate
                self.time = due + (lateness[k] if part == 0 else 0.0)
                if part == 0:
                    engine.frame += self.block
                readings.append(clock.frame())
                times.append(self.time)
                assert readings[-1] >= engine.frame
        late = np.array(readings)[1600:] - (np.array(times)[1600:] - 100.0) * self.rate
        assert np.ptp(late) <= 4  # frames, where the counter itself jumps by 128 and comes late by up to 64

    def test_starts_anew_after_the_output_stood_still(self):
        engine, clock = self.make()
        engine.frame += self.block
        before = clock.frame()
        self.time += 2.0  # two seconds without a callback
        assert clock.frame() - before < 0.1 * self.rate
        self.time += 1.0 / self.rate
        engine.frame += self.block
        assert engine.frame <= clock.frame() <= engine.frame + self.block


class TestFeeder:
    def run_on_null_output(self, tmp_path, engine, feeder, until):
        with LiveSession(engine, NullOutput(engine, 64, tmp_path / "heard.wav"), feeder) as session:
            wait_until(lambda: session.check() or until())

    def test_piece_keeps_its_exact_frames(self, tmp_path):
        engine = FakeEngine()
        feeder = Feeder(engine)
        score = make_score((0.0, 0x90, 60, 99), (0.1, 0x80, 60, 0), (0.30001, 0x90, 62, 80), duration_s=0.4)
        feeder.play(score)
        assert not feeder.piece_over
        self.run_on_null_output(tmp_path, engine, feeder, lambda: feeder.piece_over)
        frames = [event[0] for event in engine.sent]
        assert [f - frames[0] for f in frames] == [0, 4800, 14400]
        assert [event[1:] for event in engine.sent] == [(0x90, 60, 99), (0x80, 60, 0), (0x90, 62, 80)]
        assert engine.frame >= frames[0] + 0.4 * 48000

    def test_keyboard_messages_are_stamped_after_the_engine_frame_and_in_order(self, tmp_path):
        engine, keyboard = FakeEngine(), FakeInput()
        feeder = Feeder(engine, keyboard)
        keyboard.waiting = [(0x90, 60, 99), (0x80, 60, 0)]
        self.run_on_null_output(tmp_path, engine, feeder, lambda: len(engine.sent) == 2)
        keyboard.waiting = [(0x90, 61, 99)]
        assert [event[1:] for event in engine.sent] == [(0x90, 60, 99), (0x80, 60, 0)]
        frames = [event[0] for event in engine.sent]
        assert frames == sorted(frames) and frames[0] > 0
        assert feeder.received == 2 and keyboard.closed

    def test_frames_never_decrease_when_keyboard_and_piece_play_together(self, tmp_path):
        engine, keyboard = FakeEngine(), FakeInput()
        feeder = Feeder(engine, keyboard)
        feeder.play(make_score(*[(0.002 * k, 0x90, 60, 99) for k in range(100)], duration_s=0.2))
        keyboard.waiting = [(0xB0, 64, k) for k in range(50)]
        self.run_on_null_output(tmp_path, engine, feeder, lambda: feeder.piece_over)
        frames = [event[0] for event in engine.sent]
        assert len(frames) == 150 and frames == sorted(frames)

    def test_a_full_queue_is_counted(self, tmp_path):
        engine, keyboard = FakeEngine(capacity=3), FakeInput()
        feeder = Feeder(engine, keyboard)
        keyboard.waiting = [(0x90, 60, 99)] * 5
        self.run_on_null_output(tmp_path, engine, feeder, lambda: feeder.received == 5)
        assert feeder.refused == 2

    def test_a_port_that_fails_is_told_in_a_sentence(self, tmp_path):
        class Broken(FakeInput):
            def poll(self):
                raise OSError("port is gone")

        engine = FakeEngine()
        with pytest.raises(DeviceError, match="port is gone"):
            self.run_on_null_output(tmp_path, engine, Feeder(engine, Broken()), lambda: False)


def test_a_dead_output_is_noticed(tmp_path):
    engine = FakeEngine()
    engine.result = 2  # the callback ends the stream, as an aborted one does
    with (
        pytest.raises(DeviceError, match="stopped asking for sound"),
        LiveSession(engine, NullOutput(engine, 64, tmp_path / "heard.wav"), Feeder(engine)) as session,
    ):
        wait_until(lambda: session.check())
