"""A JACK server of the tests' own, with JACK's dummy driver."""

import contextlib
import ctypes
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time
import uuid

import pytest

NEEDS_JACK = [
    pytest.mark.jack,
    pytest.mark.skipif(
        shutil.which("jackd") is None or shutil.which("jack_wait") is None,
        reason="needs jackd and jack_wait (Debian: apt-get install jackd2)",
    ),
]
_START_SECONDS = 30.0


class JackServer:
    """``jackd`` under a name that it keeps over its lives.

    Parameters
    ----------
    log : pathlib.Path
        What it says.
    sync : bool
        It waits for its clients (-S); with others a cycle that a busy machine misses loses what a sender had put into
        it.
    realtime : bool
        With real-time priority, where that is ours to give.

    Attributes
    ----------
    environment : dict
        Leads other processes to it.
    log : pathlib.Path
    """

    def __init__(self, log, sync=False, realtime=False):
        self.name, self.log, self.sync = f"ukrt-test-{uuid.uuid4().hex[:8]}", log, sync
        self._process = None
        self._way = {"JACK_DEFAULT_SERVER": self.name, "JACK_NO_START_SERVER": "1"}
        self.environment = {**os.environ, **self._way}
        priority = ["-R", "-P70"] if realtime and os.geteuid() == 0 else ["--no-realtime"]
        self._command = ["jackd", "-n", self.name, *["-S"] * sync, *priority, "-d", "dummy"]

    def lead(self, monkeypatch):
        """Lead clients of this process and its children to it."""
        for name, value in self._way.items():
            monkeypatch.setenv(name, value)

    def start(self, rate=48000, period=128, outputs=2):
        """Start it, again under the same name if it has ended; skip the test where it does not start."""
        command = [*self._command, "-r", str(rate), "-p", str(period), "-P", str(outputs)]
        ends = time.monotonic() + _START_SECONDS
        while not self.ask("jack_wait", "-s", self.name, "-c").startswith("running"):
            if time.monotonic() > ends:
                pytest.skip(f"jackd does not start here: {self.log.read_text()[-300:]}")
            if self._process is None or self._process.poll() is not None:  # JACK has room for eight servers at a time
                with self.log.open("a") as file:
                    self._process = subprocess.Popen(
                        command, stdout=file, stderr=subprocess.STDOUT, preexec_fn=_end_with_us
                    )
            time.sleep(0.1)

    def end(self, with_signal=signal.SIGTERM):
        """End it; after SIGKILL it must be started and ended once more, or its name stays taken."""
        if self._process is None:
            return
        if self._process.poll() is None:
            self.suspend(False)
            self._process.send_signal(with_signal)
        self._process.wait(20)
        for left in pathlib.Path("/dev/shm").glob(f"jack_sem*{self.name}_*"):  # by clients that were killed
            left.unlink(missing_ok=True)

    def suspend(self, stopped):
        """Freeze it, or let it go on."""
        self._process.send_signal(signal.SIGSTOP if stopped else signal.SIGCONT)

    @contextlib.contextmanager
    def frozen(self):
        """Frozen as long as this lasts."""
        self.suspend(True)
        try:
            yield
        finally:
            self.suspend(False)

    def ask(self, *command):
        """What one of JACK's commands says about this server (str)."""
        return subprocess.run(command, capture_output=True, text=True, env=self.environment, timeout=20).stdout


@contextlib.contextmanager
def running_server(folder, monkeypatch=None, **options):
    """A server that runs as long as this lasts; with ``monkeypatch`` this process is led to it."""
    server = JackServer(folder / "jackd.log", **options)
    if monkeypatch is not None:
        server.lead(monkeypatch)
    try:
        server.start()
        yield server
    finally:
        server.end()


def _end_with_us():
    """Linux ends the server when the tests die: one left over takes one of the eight names that all servers share."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(1, signal.SIGTERM)  # PR_SET_PDEATHSIG
