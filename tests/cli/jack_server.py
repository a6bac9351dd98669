"""A JACK server with its dummy driver for tests, and what they do with ``ukrt play`` on it."""

import json
import os
import signal
import subprocess
import time
import uuid

import mido
import numpy as np
import pytest
import soundfile

from ukrt.cli.main import main

FILES = ("--record", "take.mid", "--record-audio", "heard.wav", "--report", "report.json")


class Server:
    """A JACK server of our own, which can be ended and started again.

    Attributes
    ----------
    environment : dict
        Leads clients to it.
    """

    def __init__(self, log):
        self.name, self._log, self._process = f"ukrt-test-{uuid.uuid4().hex[:8]}", log, None
        self.environment = {**os.environ, "JACK_DEFAULT_SERVER": self.name, "JACK_NO_START_SERVER": "1"}

    def start(self, rate=48000, period=128):
        command = ["jackd", "-n", self.name, "--no-realtime", "-d", "dummy", "-r", str(rate), "-p", str(period)]
        with self._log.open("w") as file:
            self._process = subprocess.Popen(command, stdout=file, stderr=subprocess.STDOUT)
        ends = time.monotonic() + 20
        while not self._runs():
            if self._process.poll() is not None or time.monotonic() > ends:
                pytest.skip(f"jackd does not start here: {self._log.read_text()[-300:]}")
            time.sleep(0.1)

    def _runs(self):
        asked = subprocess.run(["jack_wait", "-s", self.name, "-c"], capture_output=True, text=True)
        return asked.stdout.startswith("running")

    def end(self):
        if self._process.poll() is None:
            self._process.send_signal(signal.SIGTERM)
        self._process.wait(20)


def ended(playing, folder, code=0):
    """Wait for the end, check that the take gives the same bits; the report and standard error."""
    _, err = playing.communicate(timeout=40)
    assert playing.returncode == code and "Traceback" not in err, err
    report = json.loads((folder / "report.json").read_text())
    assert main(["render", str(folder / "take.mid"), "-o", str(folder / "again.wav")]) == 0
    for part in ("", "-2"):
        if (folder / f"heard{part}.wav").exists():
            heard, rate = soundfile.read(folder / f"heard{part}.wav", dtype="float32", always_2d=True)
            again, again_rate = soundfile.read(folder / f"again{part}.wav", dtype="float32", always_2d=True)
            assert rate == again_rate and heard.shape == again.shape and np.array_equal(heard, again)
            assert np.abs(heard).max() > 0.001
    return report, err


def played_keys(take):
    """The keys of all note-ons of a MIDI file, in order."""
    return [message.note for message in mido.MidiFile(take) if message.type == "note_on" and message.velocity]
