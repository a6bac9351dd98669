"""``ukrt play`` on a real audio server: JACK with its dummy driver, PortAudio, the compiled callback, a MIDI client."""

import os
import re
import shutil
import signal
import subprocess
import time
import uuid

import pytest

pytestmark = [
    pytest.mark.jack,
    pytest.mark.skipif(shutil.which("jackd") is None, reason="needs jackd (Debian: apt-get install jackd2)"),
]


@pytest.fixture
def jack(tmp_path):
    """A JACK server of our own; gives the environment that leads clients to it."""
    name = f"ukrt-test-{uuid.uuid4().hex[:8]}"
    log = tmp_path / "jackd.log"
    command = ["jackd", "-n", name, "--no-realtime", "-d", "dummy", "-r", "48000", "-p", "128"]
    with log.open("w") as file:
        server = subprocess.Popen(command, stdout=file, stderr=subprocess.STDOUT)
    environment = {**os.environ, "JACK_DEFAULT_SERVER": name, "JACK_NO_START_SERVER": "1"}
    try:
        ends = time.monotonic() + 10
        while (
            subprocess.run(["jack_wait", "-s", name, "-c"], capture_output=True, text=True).stdout.find("running") != 0
        ):
            if server.poll() is not None or time.monotonic() > ends:
                pytest.skip(f"jackd does not start here: {log.read_text()[-300:]}")
            time.sleep(0.1)
        yield environment
    finally:
        server.send_signal(signal.SIGTERM)
        server.wait(10)


def test_devices_lists_the_server(jack, ukrt_process):
    code, out, _ = ukrt_process("devices", environment=jack)
    assert code == 0
    assert re.search(r"\*.*system.*JACK", out)


def test_a_piece_through_portaudio(jack, ukrt_process, tmp_path, piece):
    code, out, err = ukrt_process("play", piece, "--midi-in", "none", environment=jack)
    assert code == 0, err
    assert "JACK" in err and "null output" not in err
    blocks = int(re.search(r"blocks +(\d+)", out).group(1))
    assert blocks > 0.3 * 48000 / 128  # the piece alone lasts 0.5 s
    assert re.search(r"notes +2, dropped 0", out)
    assert list(tmp_path.glob("*.wav")) == []


def test_a_rate_that_the_server_does_not_run_at_is_refused(jack, ukrt_process, piece):
    code, out, err = ukrt_process("play", piece, "--rate", "44100", environment=jack)
    assert (code, out) == (2, "")
    assert err.splitlines()[-1].startswith("ukrt: ") and "--rate 48000" in err


@pytest.mark.skipif(shutil.which("jack_midiseq") is None, reason="needs jack_midiseq (Debian: in jackd2)")
def test_another_jack_client_plays_the_guitar(jack, ukrt_process, start_ukrt):
    """A sequencer sends a note each half second; it is received, plucked and heard until Ctrl-C."""
    sequencer = subprocess.Popen(["jack_midiseq", "sequencer", "24000", "0", "60", "12000"], env=jack)
    try:
        time.sleep(0.5)
        assert "sequencer" in ukrt_process("devices", environment=jack)[1]
        playing = start_ukrt("play", "--midi-in", "sequencer", environment=jack)
        while "Ctrl-C ends" not in (line := playing.stderr.readline()):
            assert line, "ukrt play ended early"
        time.sleep(4.0)
        playing.send_signal(signal.SIGINT)
        out, err = playing.communicate(timeout=20)
    finally:
        sequencer.send_signal(signal.SIGTERM)
        sequencer.wait(10)
    assert playing.returncode == 0, err
    assert 5 <= int(re.search(r"notes +(\d+)", out).group(1)) <= 10  # 2 a second in 4 s
