"""What the tests of the command line share."""

import os
import pathlib
import subprocess
import sys

import mido
import pytest

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
