"""The MIDI process on a real JACK server: nothing lost, ports and servers that go and come back, children that die."""

import contextlib
import ctypes
import gc
import json
import os
import pathlib
import signal
import subprocess
import sys
import threading
import time

import pytest
from jack_servers import NEEDS_JACK, running_server
from midi_rig import Sender, Stage, listening, send_until_heard, wait_until

from ukrt.drivers.midi.lane import StageView

pytest.importorskip("rtmidi")
pytestmark = NEEDS_JACK


@pytest.fixture
def server(monkeypatch, tmp_path):
    with running_server(tmp_path, monkeypatch) as server:
        yield server


@pytest.fixture
def patient_server(monkeypatch, tmp_path):
    with running_server(tmp_path, monkeypatch, sync=True) as server:
        yield server


@pytest.fixture
def stage():
    stage = Stage()
    yield stage
    stage.close()


def numbered(count):
    """Messages that are all different up to 14 bits."""
    return [(0xE0, k & 127, (k >> 7) & 127) for k in range(count)]


def compute(ended):
    while not ended.is_set():
        sum(range(1000))


def collect(ended):
    kept = [[k] for k in range(100_000)]
    while not ended.is_set():
        gc.collect()
    return kept


def hold_the_lock(ended):
    """Hold the interpreter's lock for 20 ms again and again, in C."""
    usleep = ctypes.PyDLL(None).usleep
    while not ended.is_set():
        usleep(20_000)


@contextlib.contextmanager
def busy(work):
    """A thread of this process that works."""
    ended = threading.Event()
    thread = threading.Thread(target=work, args=(ended,), daemon=True)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()


@pytest.mark.parametrize("work", [None, compute, collect, hold_the_lock])
def test_a_thousand_messages_a_second_beside_a_busy_parent(patient_server, stage, work):
    expected = numbered(3000)
    with Sender() as sender, listening(stage, wanted="sender") as process, stage.running():
        with busy(work) if work else contextlib.nullcontext():
            sender.send(*expected, step=0.001)
            sender.sent()
        wait_until(lambda: stage.messages()[-1:] == expected[-1:])
        wait_until(lambda: process.counts()["received"] == 3000)
    frames = [frame for frame, _ in stage.taken]
    assert stage.messages() == expected
    assert frames == sorted(frames)
    assert process.counts()["refused"] == {"other": 0, "note_on": 0, "note_end": 0}


def test_bursts_of_2000(patient_server, stage):
    burst = numbered(2000)
    with Sender() as sender, listening(stage, wanted="sender"):
        for k in range(1, 4):
            sender.send(*burst, step=0.0)
            sender.sent()
            wait_until(lambda k=k: len(stage.take()) == 2000 * k)
    assert stage.messages() == burst * 3


def test_ten_thousand_a_second(patient_server, stage):
    expected = numbered(16384)
    with Sender() as sender, listening(stage, wanted="sender") as process, stage.running():
        sender.send(*expected, step=0.0001)
        sender.sent()
        wait_until(lambda: len(stage.taken) == len(expected))
        wait_until(lambda: process.counts()["received"] == len(expected))
    assert stage.messages() == expected


def test_a_lane_that_nobody_empties_keeps_the_ends_of_notes(patient_server, stage):
    notes = [message for k in range(9000) for message in ((0x90, k % 128, 1), (0x80, k % 128, 0))]
    with Sender() as sender, listening(stage, wanted="sender") as process:
        for k in range(0, len(notes), 2000):
            sender.send(*notes[k : k + 2000])
            sender.sent()
            time.sleep(0.05)
        wait_until(lambda: process.counts()["received"] == len(notes))
        refused = process.counts()["refused"]
    stage.take()
    kinds = [status for status, _, _ in stage.messages()]
    assert kinds.count(0x90) + refused["note_on"] == kinds.count(0x80) + refused["note_end"] == 9000
    assert refused["note_on"] > refused["note_end"] and refused["other"] == 0


def test_a_port_that_vanishes_lets_go_and_is_opened_again(patient_server, stage):
    with listening(stage, wanted=["sender"]) as process:
        assert "no MIDI input 'sender' yet" in process.news()[0]
        with Sender() as sender:
            wait_until(lambda: process.ports() == [sender.name])
            sender.send((0x90, 60, 100), (0x90, 64, 100), (0xB0, 64, 127), (0x80, 64, 0))
            wait_until(lambda: len(stage.take()) == 4)
        wait_until(lambda: process.ports() == [])
        wait_until(lambda: stage.take() and stage.messages()[4:] == [(0x80, 60, 0), (0xB0, 64, 0)])
        assert any("has gone; the note it held ends" in sentence for sentence in process.news())
        with Sender() as sender:
            wait_until(lambda: process.ports() == [sender.name])
            sender.send((0x90, 61, 100))
            wait_until(lambda: stage.take()[-1][1] == (0x90, 61, 100))


def test_two_inputs_and_a_new_one_are_merged(patient_server, stage):
    with Sender("one") as one, Sender("two") as two, listening(stage, wanted="all") as process:
        assert sorted(process.ports()) == [one.name, two.name]
        with Sender("three") as three:
            wait_until(lambda: len(process.ports()) == 3)
            for k, sender in enumerate((one, two, three)):
                sender.send(*[(0xE0 | k, n, 0) for n in range(100)], step=0.001)
            wait_until(lambda: len(stage.take()) == 300)
    for k in range(3):
        assert [m for m in stage.messages() if m[0] == 0xE0 | k] == [(0xE0 | k, n, 0) for n in range(100)]


def test_ports_that_come_and_go_leave_the_others_alone(server, stage):
    """Those after a port that goes move up in the list."""
    one = Sender("one")
    with Sender("two") as two, listening(stage, wanted="all") as process:
        with one:
            assert process.ports() == [one.name, two.name]
        wait_until(lambda: process.ports() == [two.name])
        with Sender("three") as three:
            wait_until(lambda: process.ports() == [two.name, three.name])
        news = process.news()
    assert [sentence for sentence in news if two.name in sentence] == [f"listening to {two.name}"]


def test_a_virtual_port(patient_server, stage):
    with Sender() as sender, listening(stage, wanted=[], virtual="strings") as process:
        wait_until(lambda: process.ports() == ["strings"])
        subprocess.run(["jack_connect", "sender:out", "ukrt:strings"], check=True, capture_output=True)
        sender.send((0x90, 60, 100))
        wait_until(lambda: stage.take() and stage.messages() == [(0x90, 60, 100)])


def test_real_time_bytes_and_sysex_on_the_way(patient_server, stage):
    with Sender() as sender, listening(stage, wanted="sender") as process:
        sender.send((0xF8,), (0x90, 60, 1), (0xF0, 1, 2, 3, 0xF7), (0xFE,), (0xFA,), (0x90, 61, 1))
        wait_until(lambda: len(stage.take()) == 5)  # silence after active sensing ends both notes
        passed_over = (0xF5, 0, 0)  # another maker's
        assert stage.messages() == [(0x90, 60, 1), passed_over, (0x90, 61, 1), (0x80, 60, 0), (0x80, 61, 0)]
        wait_until(lambda: process.counts()["sensing_timeouts"] == 1)


def test_a_child_that_is_killed_is_followed_by_another(server, stage):
    with Sender() as sender, listening(stage, wanted="sender") as process:
        send_until_heard(sender, stage, (0x90, 60, 100))
        first = process.pid
        os.kill(first, signal.SIGKILL)
        wait_until(lambda: process.counts()["restarts"] == 1 and process.ports() == [sender.name])
        assert process.pid not in (None, first)
        send_until_heard(sender, stage, (0x90, 61, 100))
        assert any("exit code -9" in sentence for sentence in process.news())
    assert {(0xB0 | c, 123, 0) for c in range(16)} <= set(stage.messages())  # nobody knew what was held


def test_a_child_that_hangs_ends_itself_and_is_followed_by_another(server, stage):
    """The server stands still while the child asks it for another port: libjack waits for it, the interpreter too."""
    with Sender("one") as one, listening(stage, wanted="all") as process:
        os.kill(process.pid, signal.SIGSTOP)
        with Sender("two") as two:
            server.suspend(True)
            os.kill(process.pid, signal.SIGCONT)
            wait_until(lambda: process.counts()["restarts"] == 1)
            server.suspend(False)
            wait_until(lambda: sorted(process.ports()) == [one.name, two.name])


def test_a_server_that_stands_still_holds_up_neither_start_nor_end(server, stage):
    server.suspend(True)
    try:
        with listening(stage, wanted="all") as process:
            assert process.ports() == []
    finally:
        server.suspend(False)
    with Sender() as sender, listening(stage, wanted="all") as process:
        wait_until(lambda: process.ports() == [sender.name])
        server.suspend(True)
        process.close()
        server.suspend(False)
        assert process.pid is None


def test_a_server_that_dies_and_comes_back(patient_server, stage):
    with listening(stage, wanted="all") as process:
        with Sender() as sender:
            wait_until(lambda: process.ports() == [sender.name])
            sender.send((0x90, 60, 100))
            wait_until(lambda: len(stage.take()) == 1)
            patient_server.end()
            wait_until(lambda: process.ports() == [])
            wait_until(lambda: stage.take()[-1][1] == (0x80, 60, 0))
        assert any("JACK server has gone" in sentence for sentence in process.news())
        patient_server.start()
        with Sender() as sender:
            wait_until(lambda: process.ports() == [sender.name])
            sender.send((0x90, 61, 100))
            wait_until(lambda: stage.take()[-1][1] == (0x90, 61, 100))


def test_ends_with_its_parent(server, stage):
    program = (
        "import json, os, sys, time\nfrom ukrt.drivers.midi.process import MidiProcess\n"
        "process = MidiProcess(json.loads(sys.argv[1]), 'all')\nprocess.start()\nprocess.wait_ready(10)\n"
        "print(process.pid, flush=True)\ntime.sleep(60)\n"
    )
    command = [sys.executable, "-c", program, json.dumps(stage.manifest())]
    root = str(pathlib.Path(__file__).parents[2])
    parent = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env={**os.environ, "PYTHONPATH": root})
    child = int(parent.stdout.readline())
    parent.kill()
    parent.wait()
    parent.stdout.close()
    wait_until(lambda: not _lives(child))
    view = StageView(stage.manifest()["stage"])  # the memory is still there
    view.close()


def _lives(pid):
    try:
        return pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except FileNotFoundError:
        return False


def test_ctrl_c_is_the_parents_to_hear(server, stage):
    with listening(stage, wanted="all") as process:
        os.kill(process.pid, signal.SIGINT)
        time.sleep(0.3)
        assert process.pid is not None and process.counts()["restarts"] == 0


def test_the_child_imports_nothing_heavy():
    program = "import sys, ukrt.drivers.midi.host\nprint([n for n in ('numpy', 'numba', 'cffi') if n in sys.modules])"
    root = str(pathlib.Path(__file__).parents[2])
    environment = {**os.environ, "PYTHONPATH": root}
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, env=environment)
    assert done.stdout.strip() == "[]", done.stderr
