"""``ukrt play`` on a real audio server: JACK with its dummy driver, through PortAudio and as a client of its own."""

import json
import os
import re
import shutil
import signal
import subprocess
import time
import uuid

import mido
import numpy as np
import pytest
import soundfile

from ukrt.cli.main import main

pytestmark = [
    pytest.mark.jack,
    pytest.mark.skipif(shutil.which("jackd") is None, reason="needs jackd (Debian: apt-get install jackd2)"),
]
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


@pytest.fixture
def server(tmp_path):
    server = Server(tmp_path / "jackd.log")
    try:
        server.start()
        yield server
    finally:
        server.end()


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


def test_devices_lists_the_server(server, ukrt_process):
    code, out, _ = ukrt_process("devices", environment=server.environment)
    assert code == 0
    assert re.search(r"\*.*system.*JACK", out)
    assert f"JACK server {server.name}: 48000 Hz, 128 frames, not real time" in out
    assert "system:playback_1" in out


@pytest.mark.parametrize("driver", [("portaudio", "--channels", "1"), ("jack",)])
def test_a_piece_is_played_and_kept(begin, piece, tmp_path, driver):
    report, err = ended(begin(piece, "--seconds", 2, "--driver", *driver), tmp_path)
    assert "JACK" in report["output"] and err == "" and not report["session"]["away"]
    assert (report["sample_rate"], report["block_size"]) == (48000.0, 128)
    assert report["counters"]["notes_on"] == 2 and report["counters"]["late_messages"] == 0
    assert report["counters"]["blocks"] > 0.5 * 2 * 48000 / 128  # machines are noisy


def test_a_rate_that_the_server_does_not_run_at_is_refused(server, ukrt_process, piece):
    code, out, err = ukrt_process("play", piece, "--rate", "44100", environment=server.environment)
    assert (code, out) == (2, "")
    assert err.splitlines()[-1].startswith("ukrt: ") and "--rate 48000" in err


def test_without_a_server_its_driver_is_refused(capsys, monkeypatch, piece, tmp_path):
    monkeypatch.setenv("JACK_DEFAULT_SERVER", "ukrt-test-absent")
    monkeypatch.setenv("JACK_NO_START_SERVER", "1")
    assert main(["play", str(piece), "--driver", "jack", "--record", str(tmp_path / "take.mid")]) == 2
    assert "no JACK server 'ukrt-test-absent'" in capsys.readouterr().err
    assert not (tmp_path / "take.mid").exists()


def test_another_client_plays_the_guitar(begin, sequencer, ukrt_process, server, tmp_path):
    assert "sequencer" in ukrt_process("devices", environment=server.environment)[1]
    playing = begin("--midi-in", "sequencer")
    time.sleep(2.5)
    playing.send_signal(signal.SIGINT)
    report, err = ended(playing, tmp_path)
    assert 2 <= report["counters"]["notes_on"] <= 8  # 2 a second, once the port has been opened
    assert "sequencer" in err and report["counters"]["late_messages"] == 0
    assert report["midi"][0]["received"] == report["counters"]["midi_received"]


def test_a_piece_waits_for_the_first_note(begin, sequencer, piece, tmp_path):
    sequencer.send_signal(signal.SIGSTOP)
    playing = begin(piece, "--driver", "jack", "--wait-for-midi", "--midi-in", "sequencer", "--seconds", 3)
    time.sleep(0.7)
    sequencer.send_signal(signal.SIGCONT)
    ended(playing, tmp_path)
    keys = played_keys(tmp_path / "take.mid")
    assert 60 in keys and {52, 64} <= set(keys) and keys.index(60) < min(keys.index(52), keys.index(64))


def played_keys(take):
    """The keys of all note-ons of a MIDI file, in order."""
    return [message.note for message in mido.MidiFile(take) if message.type == "note_on" and message.velocity]


@pytest.mark.parametrize(("driver", "rate"), [("portaudio", 48000), ("jack", 44100)])
def test_a_server_that_dies_and_comes_back(begin, server, piece, tmp_path, driver, rate):
    playing = begin(piece, "--driver", driver, "--loop")
    time.sleep(1.0)
    server.end()
    time.sleep(0.5)
    server.start(rate, 256)
    while ") is back" not in (line := playing.stderr.readline()):
        assert line, "ukrt play ended early"
    time.sleep(1.0)
    playing.send_signal(signal.SIGTERM)
    report, _ = ended(playing, tmp_path)
    assert report["reconnections"] == 1 and report["sample_rate"] == rate and report["block_size"] == 256
    assert report["ended"] == "interrupted" and report["session"]["changes"] == (rate != 48000)
    assert (tmp_path / "heard-2.wav").exists() == (rate != 48000)
    times = [news["seconds"] for news in report["news"] if "plays on unheard" in news["text"]]
    assert len(times) == 1 and 0.5 < times[0] < report["seconds"] - 1


def test_a_piece_follows_the_transport(begin, server, piece, tmp_path, monkeypatch):
    jack = pytest.importorskip("jack")
    monkeypatch.setenv("JACK_DEFAULT_SERVER", server.name)
    playing = begin(piece, "--driver", "jack", "--transport", "--seconds", 3)
    master = jack.Client("master", no_start_server=True)
    try:
        time.sleep(0.5)
        for _ in range(2):
            master.transport_frame = 0
            master.transport_start()
            time.sleep(0.7)
            master.transport_stop()
            time.sleep(0.2)
    finally:
        master.close()
    report, _ = ended(playing, tmp_path)
    assert played_keys(tmp_path / "take.mid").count(64) == 2, (
        "the piece's second note, half a second into it, both times"
    )
    assert report["ended"] == "3 s are over"
