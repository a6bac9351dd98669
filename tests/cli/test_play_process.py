"""``ukrt play`` as a process: signals end it with whole files, a terminal gets a line."""

import json
import os
import pathlib
import signal
import subprocess
import sys
import time

import pytest
from take_check import FILES, assert_take_is_what_was_heard

import ukrt

NULL = ("--driver", "null", "--midi-in", "none", "--no-shedding")  # which a busy machine would tell about


def wait_for_line(process, words):
    while words not in (line := process.stderr.readline()):
        assert line, "ukrt play ended early"


@pytest.mark.parametrize("sign", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_tidily(tmp_path, start_ukrt, sign):
    playing = start_ukrt("play", *NULL, *FILES)
    wait_for_line(playing, "bundled piece")
    time.sleep(1.0)
    playing.send_signal(sign)
    out, err = playing.communicate(timeout=20)
    assert playing.returncode == 0 and err == "" and "blocks   " in out
    assert json.loads((tmp_path / "report.json").read_text())["ended"] == "interrupted"
    assert_take_is_what_was_heard(tmp_path)


def test_the_second_signal_leaves_at_once_with_whole_files(tmp_path, start_ukrt):
    """Here a device hangs when it is closed, as those of dead servers do."""
    code = (
        "import sys, time\n"
        "from ukrt.drivers.sound.null import NullOutput\n"
        "from ukrt.cli.main import run\n"
        "NullOutput.close = lambda self: (print('closing', file=sys.stderr, flush=True), time.sleep(60))\n"
        "run()\n"
    )
    playing = start_ukrt("play", *NULL, *FILES, program=("-c", code))
    wait_for_line(playing, "bundled piece")
    time.sleep(1.0)
    playing.send_signal(signal.SIGINT)
    wait_for_line(playing, "closing")
    began = time.monotonic()
    playing.send_signal(signal.SIGINT)
    _, err = playing.communicate(timeout=20)
    assert playing.returncode == 130 and time.monotonic() - began < 20 and err == ""
    assert not (tmp_path / "report.json").exists()
    assert_take_is_what_was_heard(tmp_path)


def test_the_status_line_is_for_terminals(tmp_path, piece):
    """On a terminal of 80 columns the line is there, and gone at the end."""
    pty = pytest.importorskip("pty")
    parent, child = pty.openpty()
    command = [sys.executable, "-m", "ukrt", "play", str(piece), *NULL, "--seconds", "1.5"]
    environment = {**os.environ, "PYTHONPATH": str(pathlib.Path(ukrt.__file__).parents[1]), "TERM": "xterm"}
    environment["COLUMNS"] = "80"
    with subprocess.Popen(command, stderr=child, stdout=subprocess.PIPE, env=environment, text=True) as playing:
        os.close(child)
        shown = b""
        while True:
            try:
                data = os.read(parent, 65536)
            except OSError:  # the other end has been closed
                break
            if not data:
                break
            shown += data
        assert "blocks   " in playing.stdout.read()
    os.close(parent)
    lines = [line for line in shown.decode().replace("\x1b[2K", "\r").split("\r") if "dB" in line or "█" in line]
    assert playing.returncode == 0, shown[-2000:]
    assert len(lines) >= 5 and "MIDI" in lines[-1]
