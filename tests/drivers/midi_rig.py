"""What the MIDI tests share: a stage in shared memory whose blocks a thread counts and stamps, another program that
sends, and the MIDI process that listens."""

import contextlib
import json
import pathlib
import subprocess
import sys
import threading
import time

from ukrt.drivers.midi.process import MidiProcess
from ukrt.engine import stage_layout as at
from ukrt.engine.memory import Block

RATE = 48000.0
_SENDER = pathlib.Path(__file__).with_name("midi_sender.py")


class Stage:
    """The stage's arrays; ``run`` plays the part of an output that takes from the MIDI lane."""

    def __init__(self):
        self.block = Block({"si": ("i8", at.SI_SIZE), "sd": ("f8", at.SD_SIZE)}, shared=True)
        self.si, self.sd = self.block.arrays["si"], self.block.arrays["sd"]
        self.sd[at.M_RATE] = RATE
        self.taken = []  # (frame, (status, data1, data2)) of all that was in the lane
        self.late = 0

    def manifest(self):
        """What an engine's manifest says about the stage."""
        return {"stage": self.block.manifest()}

    def stamp(self, frame, ns, block):
        """As the callback does at the beginning of a block."""
        self.si[at.G_STAMP_SEQ] += 1
        self.si[at.G_STAMP_FRAME], self.si[at.G_STAMP_NS], self.si[at.G_STAMP_BLOCK] = frame, ns, block
        self.si[at.G_STAMP_SEQ] += 1

    def take(self, until=None):
        """Empty the MIDI lane (up to a frame)."""
        write, read = at.LANE_WRITE + at.LANE_STEP * at.LANE_MIDI, at.LANE_READ + at.LANE_STEP * at.LANE_MIDI
        while self.si[read] < self.si[write]:
            slot = at.QUEUES + at.LANE_SIZE * at.LANE_MIDI + 2 * (int(self.si[read]) % at.QUEUE)
            frame, word = int(self.si[slot]), int(self.si[slot + 1])
            if until is not None and frame >= until:
                break
            self.late += until is not None and frame < self.si[at.G_FRAME]
            self.taken.append((frame, (word >> 16, (word >> 8) & 0xFF, word & 0xFF)))
            self.si[read] += 1
        return self.taken

    @contextlib.contextmanager
    def running(self, block=256):
        """Blocks in real time, as far as Python can."""
        ended = threading.Event()

        def run():
            due = time.monotonic_ns()
            while not ended.is_set():
                due += round(block / RATE * 1e9)
                time.sleep(max(due - time.monotonic_ns(), 0) * 1e-9)
                frame = int(self.si[at.G_FRAME])
                self.stamp(frame, time.monotonic_ns(), block)
                self.take(frame + block)
                self.si[at.G_FRAME] = frame + block

        thread = threading.Thread(target=run, daemon=True)
        thread.start()
        try:
            yield self
        finally:
            ended.set()
            thread.join()

    def messages(self):
        """All messages so far (list of (status, data1, data2))."""
        return [message for _, message in self.taken]

    def close(self):
        """Remove the memory."""
        self.si = self.sd = None
        self.block.close()


def wait_until(condition, seconds=15.0):
    """Wait for something that happens by itself."""
    ends = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < ends, "waited too long"
        time.sleep(0.01)


@contextlib.contextmanager
def listening(stage, **options):
    """A MIDI process that has opened what there is."""
    process = MidiProcess(stage.manifest(), **options)
    process.start()
    try:
        assert process.wait_ready(10), process.news()
        yield process
    finally:
        process.close()
        assert process.pid is None


class Sender:
    """Another program that sends MIDI."""

    def __init__(self, name="sender"):
        command = [sys.executable, str(_SENDER), name]
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
        )
        self.name = f"{name}:out (Jack)"
        assert self._process.stdout.readline(), "the sender has not started"

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._process.stdin.close()
        self._process.wait(10)
        self._process.stdout.close()

    def send(self, *messages, step=0.0):
        """Send messages ``step`` seconds apart; returns at once, `sent` when all are under way."""
        self._process.stdin.write(json.dumps({"messages": messages, "step": step}) + "\n")
        self._process.stdin.flush()

    def sent(self):
        """Wait until all that was to be sent has been."""
        self._process.stdout.readline()


def send_until_heard(sender, stage, message):
    """A server that does not wait for its clients loses what it is sent in a cycle that a busy machine misses."""

    def heard():
        sender.send(message)
        stage.take()
        return message in stage.messages()

    wait_until(heard)
