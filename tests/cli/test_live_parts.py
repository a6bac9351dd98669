"""The null output, which stands in for a sound card."""

import time

import numpy as np
import pytest
import soundfile
from fake_engine import FakeEngine

from ukrt.drivers.sound.null import NullOutput, new_recording_path
from ukrt.errors import AudioFileError


def wait_until(condition, seconds=10.0):
    ends = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < ends, "waited too long"
        time.sleep(0.005)


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
