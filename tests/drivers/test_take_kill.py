"""Recording processes that are killed or whose disk is full: what is on the disk is whole and equals the render."""

import os
import pathlib
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
import soundfile

from ukrt.drivers.files.midi import load_midi_file
from ukrt.drivers.takes.files import render_take
from ukrt.drivers.takes.reader import read_take
from ukrt.drivers.takes.wav_series import PIECE

VICTIM = pathlib.Path(__file__).with_name("recording_victim.py")
ROOT = pathlib.Path(__file__).resolve().parents[2]
MOST_LOST = 12_000  # frames: a quarter of a second

pytest.importorskip("resource", reason="needs limits on files' sizes, which only POSIX systems have")


@pytest.fixture
def start(tmp_path):
    """Starts the victim; ends it where the test has not."""
    started = []

    def begin(most=0):
        path = os.pathsep.join(filter(None, [str(ROOT), os.environ.get("PYTHONPATH")]))
        command = [sys.executable, str(VICTIM), str(tmp_path), str(most)]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env={**os.environ, "PYTHONPATH": path})
        started.append(process)
        return process

    yield begin
    for process in started:
        if process.poll() is None:
            process.kill()
            process.communicate()


def rendered(folder):
    render_take(folder / "take.mid", folder / "out.wav", block_size=1000)
    return soundfile.read(folder / "out.wav", dtype="float32")[0].view(np.uint32)


def recorded(folder):
    return soundfile.read(folder / "take.wav", dtype="float32")[0].view(np.uint32)


@pytest.mark.parametrize("seconds", [0.7, 1.23])
def test_a_killed_recording_lacks_less_than_a_quarter_of_a_second_and_equals_its_render(tmp_path, start, seconds):
    process = start()
    process.stdout.readline()
    time.sleep(seconds)
    process.send_signal(signal.SIGKILL)
    frames = int([line for line in process.communicate()[0].splitlines(keepends=True) if line.endswith("\n")][-1])
    take, sound = read_take(tmp_path / "take.mid"), recorded(tmp_path)
    assert frames > MOST_LOST and take.warnings == () and len(take.event_words) > 10
    assert frames - MOST_LOST <= take.frames <= frames + 64
    assert frames - MOST_LOST <= len(sound) <= frames + 64
    assert len(load_midi_file(tmp_path / "take.mid").time_s) == len(take.event_words)
    both = min(take.frames, len(sound))
    np.testing.assert_array_equal(rendered(tmp_path)[:both], sound[:both])
    assert np.any(sound)


def test_files_that_may_not_grow_end_recording_but_not_playing(tmp_path, start):
    process = start(most=100_000)
    out, _ = process.communicate(timeout=120)
    assert process.returncode == 0
    assert [line for line in out.splitlines() if "take.wav" in line and "recording has stopped" in line]
    take, sound = read_take(tmp_path / "take.mid"), recorded(tmp_path)
    assert take.frames >= 60_000 and take.warnings == ()  # the take is small and goes on
    assert 100_000 // 8 - PIECE <= len(sound) <= 100_000 // 8  # all that fits, but for less than one piece
    np.testing.assert_array_equal(rendered(tmp_path)[: len(sound)], sound)
    assert (tmp_path / "take.wav").stat().st_size == 58 + 8 * len(sound)


def test_a_disk_that_is_really_full(tmp_path, start):
    """A file system of 200 kB in memory, where this process may mount one."""
    import ctypes

    folder = tmp_path / "disk"
    folder.mkdir()
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.mount(b"tmpfs", bytes(folder), b"tmpfs", 0, b"size=200k") != 0:
        pytest.skip(f"mounting a file system: {os.strerror(ctypes.get_errno())}")
    try:
        process = subprocess.run(
            [sys.executable, str(VICTIM), str(folder), "1000000"],
            capture_output=True, text=True, timeout=120, env={**os.environ, "PYTHONPATH": str(ROOT)},
        )  # fmt: skip
        assert process.returncode == 0, process.stderr
        told = [line for line in process.stdout.splitlines() if "recording has stopped" in line]
        assert len(told) >= 1 and all("No space left" in line for line in told)
        take, sound = read_take(folder / "take.mid"), recorded(folder)
        render_take(folder / "take.mid", tmp_path / "out.wav")
        out = soundfile.read(tmp_path / "out.wav", dtype="float32")[0].view(np.uint32)
        both = min(take.frames, len(sound))
        assert both > 0 and take.warnings == ()
        np.testing.assert_array_equal(out[:both], sound[:both])
    finally:
        libc.umount(bytes(folder))
