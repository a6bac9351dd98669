"""A JACK server with its dummy driver for tests, and what they do with ``ukrt play`` on it."""

import json
import os
import signal
import subprocess
import time
import uuid

import mido
import pytest
from take_check import assert_take_is_what_was_heard


class Server:
    """A JACK server of our own, which can be ended and started again.

    Attributes
    ----------
    environment : dict
        Leads clients to it.
    log : pathlib.Path
        What it says.
    """

    def __init__(self, log):
        self.name, self.log, self._process = f"ukrt-test-{uuid.uuid4().hex[:8]}", log, None
        self.environment = {**os.environ, "JACK_DEFAULT_SERVER": self.name, "JACK_NO_START_SERVER": "1"}

    def start(self, rate=48000, period=128):
        command = ["jackd", "-n", self.name, "--no-realtime", "-d", "dummy", "-r", str(rate), "-p", str(period)]
        with self.log.open("w") as file:
            self._process = subprocess.Popen(command, stdout=file, stderr=subprocess.STDOUT)
        ends = time.monotonic() + 20
        while not self._runs():
            if self._process.poll() is not None or time.monotonic() > ends:
                pytest.skip(f"jackd does not start here: {self.log.read_text()[-300:]}")
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
    assert_take_is_what_was_heard(folder)
    return report, err


def outlived(server, playing, folder, rate):
    """End the server while ``ukrt play`` plays, start it again at ``rate``; the report of a session that went on."""
    time.sleep(1.0)
    server.end()
    time.sleep(0.5)
    server.start(rate, 256)
    while ") is back" not in (line := playing.stderr.readline()):
        assert line, "ukrt play ended early"
    time.sleep(1.0)
    playing.send_signal(signal.SIGTERM)
    report, _ = ended(playing, folder)
    assert report["reconnections"] == 1 and report["sample_rate"] == rate and report["block_size"] == 256
    assert report["ended"] == "interrupted"
    times = [news["seconds"] for news in report["news"] if "plays on unheard" in news["text"]]
    assert len(times) == 1 and 0.5 < times[0] < report["seconds"] - 1
    return report


def played_keys(take):
    """The keys of all note-ons of a MIDI file, in order."""
    return [message.note for message in mido.MidiFile(take) if message.type == "note_on" and message.velocity]
