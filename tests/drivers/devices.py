"""Outputs whose fate is in the test's hands, and a JACK server that can be killed, frozen and started again."""

import contextlib
import os
import pathlib
import shutil
import signal
import subprocess
import time
import uuid

import pytest

from ukrt.drivers.sound.null import NullOutput


def wait_until(condition, seconds=20.0, meanwhile=lambda: None):
    """Wait for ``condition()``, calling ``meanwhile()`` as often as a main loop would."""
    ends = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < ends, "waited too long"
        meanwhile()
        time.sleep(0.02)


class Device:
    """A clocked output that can die, or stop asking without a word."""

    def __init__(self, engine, name="the device", sample_rate=48000.0, diary=None):
        self._clock = NullOutput(engine, 128, silent=True)
        self.name, self.sample_rate, self.block_size, self.latency = name, sample_rate, 128, 0.0027
        self.running = False
        self.refreshed, self.gaps = 0, 0
        self._diary = [] if diary is None else diary
        self._alive = False

    def start(self):
        self._diary.append(f"{self.name} starts")
        self._clock.start()
        self.running = self._alive = True

    def stall(self):
        """Ask for nothing any more, and say nothing."""
        if self._alive:
            self._clock.close()
        self._alive = False

    def die(self):
        self.stall()
        self.running = False

    def refresh(self):
        self.refreshed += 1

    def xruns(self):
        return self.gaps

    def close(self):
        self._diary.append(f"{self.name} closes")
        self.die()
        return True


needs_jack = [
    pytest.mark.jack,
    pytest.mark.skipif(shutil.which("jackd") is None, reason="needs jackd (Debian: apt-get install jackd2)"),
]


class JackServer:
    """A JACK server of our own with the dummy driver, on a name that it keeps over its lives."""

    def __init__(self, log):
        self.name = f"ukrt-test-{uuid.uuid4().hex[:8]}"
        self._log, self._process = log, None

    @property
    def environment(self):
        """What leads clients to this server."""
        return {"JACK_DEFAULT_SERVER": self.name, "JACK_NO_START_SERVER": "1"}

    def start(self, rate=48000, period=128, outputs=2):
        command = ["jackd", "-n", self.name, "--no-realtime", "-d", "dummy", "-r", str(rate), "-p", str(period)]
        command += ["-P", str(outputs)]
        ends = time.monotonic() + 30
        while not self._ask("jack_wait", "-s", self.name, "-c").startswith("running"):
            if time.monotonic() > ends:
                pytest.skip(f"jackd does not start here: {self._log.read_text()[-300:]}")
            if self._process is None or self._process.poll() is not None:  # JACK has room for eight servers at a time
                with self._log.open("a") as file:
                    self._process = subprocess.Popen(command, stdout=file, stderr=subprocess.STDOUT)
            time.sleep(0.1)

    def stop(self):
        """End it as a user would; a server that is killed outright leaves its name in JACK's registry."""
        if self._process is not None:
            self._process.send_signal(signal.SIGCONT)
            self._process.send_signal(signal.SIGTERM)
            self._process.wait(10)
            self._process = None
            for left in pathlib.Path("/dev/shm").glob(f"jack_sem*{self.name}_*"):  # by clients that were killed
                left.unlink(missing_ok=True)

    @contextlib.contextmanager
    def frozen(self):
        self._process.send_signal(signal.SIGSTOP)
        try:
            yield
        finally:
            self._process.send_signal(signal.SIGCONT)

    def set_period(self, frames):
        self._ask("jack_bufsize", str(frames))

    def ports(self):
        """The names of all ports (list of str)."""
        return self._ask("jack_lsp").split()

    def _ask(self, *command):
        environment = {**os.environ, **self.environment}
        return subprocess.run(command, capture_output=True, text=True, env=environment, timeout=20).stdout
