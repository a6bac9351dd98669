"""A JACK server of one's own: a period enters, the environment that leads clients to it leaves; and child processes."""

import contextlib
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time
import uuid

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCRIPT = ROOT / "tools" / "prove_live.py"
RATE = 48000
_REALTIME = ("-R", "-P70")
_START_SECONDS = 10.0
_ATTEMPTS = 8  # no more than eight servers can run at once, whoever else has some


class ProofError(Exception):
    """A proof could not be carried out; the message says what was missing."""


@contextlib.contextmanager
def jack_server(period, sync=False):
    """Run ``jackd`` with its dummy driver at ``period`` frames; real-time where allowed, told as ``realtime``.

    Yields
    ------
    environment : dict
        For clients, with ``UKRT_PROOF_REALTIME`` "yes" or "no".
    """
    from ukrt.drivers.doctor.system_facts import scheduling_facts

    realtime = bool(scheduling_facts()["allowed"])
    for attempt in range(_ATTEMPTS):
        time.sleep(attempt)
        name = f"ukrt-proof-{uuid.uuid4().hex[:8]}"
        server, log = _start(name, period, realtime, sync)
        if _answers(name, server):
            break
        _end(server)
    else:
        raise ProofError(f"jackd does not start here: {log.read_text()[-300:]}")
    try:
        yield {
            **os.environ,
            "JACK_DEFAULT_SERVER": name,
            "JACK_NO_START_SERVER": "1",
            "UKRT_PROOF_REALTIME": "yes" if realtime else "no",
        }
    finally:
        _end(server)
        log.unlink(missing_ok=True)


def _start(name, period, realtime, sync):
    handle, path = tempfile.mkstemp(prefix=name, suffix=".log")
    command = ["jackd", "-n", name, *(_REALTIME if realtime else ["--no-realtime"]), *(["-S"] if sync else [])]
    try:
        with os.fdopen(handle, "w") as file:
            tail = ["-d", "dummy", "-r", str(RATE), "-p", str(period)]
            return subprocess.Popen([*command, *tail], stdout=file, stderr=subprocess.STDOUT), pathlib.Path(path)
    except FileNotFoundError as error:
        raise ProofError("jackd is missing (Debian: apt-get install jackd2)") from error


def _answers(name, server):
    ends = time.monotonic() + _START_SECONDS
    wait = ["jack_wait", "-s", name, "-c"]
    while not subprocess.run(wait, capture_output=True, text=True).stdout.startswith("running"):
        if server.poll() is not None or time.monotonic() > ends:
            return False
        time.sleep(0.1)
    return True


def _end(process):
    """SIGTERM, so that a server gives its name back to the registry; SIGKILL only to what does not listen."""
    if process.poll() is None:
        process.send_signal(signal.SIGTERM)
    try:
        process.wait(10)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


@contextlib.contextmanager
def child(*arguments, environment, stderr=None):
    """A process of this script with another subcommand; ended when the context is left."""
    path = os.pathsep.join(filter(None, [str(ROOT), environment.get("PYTHONPATH")]))
    process = subprocess.Popen(
        [sys.executable, str(SCRIPT), *map(str, arguments)],
        env={**environment, "PYTHONPATH": path},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=stderr,
        text=True,
    )
    try:
        yield process
    finally:
        _end(process)
        process.stdin.close()
        process.stdout.close()


def answer(process, what):
    """The next line of JSON that a child writes, or a sentence about what it did not do."""
    line = process.stdout.readline()
    if not line.strip():
        raise ProofError(f"the process for {what} ended early (exit code {process.wait(10)})")
    return json.loads(line)
