"""What the tests of the command line share."""

import os
import pathlib
import shutil
import signal
import subprocess
import sys

import mido
import pytest
from jack_servers import running_server
from take_check import FILES

ROOT = pathlib.Path(__file__).resolve().parents[2]


@pytest.fixture
def start_ukrt(tmp_path):
    """Starts ``ukrt`` in a process of its own, in an empty folder and without a terminal."""
    started = []

    def start(*arguments, environment=os.environ, program=("-m", "ukrt")):
        path = os.pathsep.join(filter(None, [str(ROOT), environment.get("PYTHONPATH")]))
        process = subprocess.Popen(
            [sys.executable, *program, *map(str, arguments)],
            cwd=tmp_path,
            env={**environment, "PYTHONPATH": path},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        started.append(process)
        return process

    yield start
    for process in started:
        if process.poll() is None:
            process.kill()
            process.communicate()


@pytest.fixture
def ukrt_process(start_ukrt):
    """Runs ``ukrt`` in a process of its own to its end; gives (exit code, standard output, standard error)."""

    def run(*arguments, **options):
        process = start_ukrt(*arguments, **options)
        out, err = process.communicate(timeout=300)  # the first run on a machine compiles
        return process.returncode, out, err

    return run


@pytest.fixture
def piece(tmp_path):
    """A MIDI file with two notes in half a second."""
    file = mido.MidiFile(ticks_per_beat=480)
    track = mido.MidiTrack()
    file.tracks.append(track)
    track.append(mido.Message("note_on", note=52, velocity=90))
    track.append(mido.Message("note_on", note=64, velocity=90, time=240))
    track.append(mido.Message("note_off", note=52, time=120))
    track.append(mido.Message("note_off", note=64, time=120))
    file.save(tmp_path / "piece.mid")
    return tmp_path / "piece.mid"


@pytest.fixture
def server(tmp_path):
    with running_server(tmp_path) as server:
        yield server


@pytest.fixture
def sequencer(server):
    """A client that plays a note each half second."""
    if shutil.which("jack_midiseq") is None:
        pytest.skip("needs jack_midiseq (Debian: in jackd2)")
    process = subprocess.Popen(["jack_midiseq", "sequencer", "24000", "0", "60", "12000"], env=server.environment)
    yield process
    process.send_signal(signal.SIGTERM)
    process.wait(10)


@pytest.fixture
def begin(start_ukrt, server):
    """Starts ``ukrt play`` with a recording and a report; returns when it plays."""

    def run(*arguments):
        playing = start_ukrt("play", *arguments, *FILES, environment=server.environment)
        while "Ctrl-C ends" not in (line := playing.stderr.readline()):
            assert line, "ukrt play ended early"
        return playing

    return run
