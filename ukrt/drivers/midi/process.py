"""MIDI inputs that this process cannot disturb: an engine in shared memory enters, a child process writes into it.

The child (`midi_host`) is watched by one thread, which starts it again when it dies.
"""

import contextlib
import json
import subprocess
import tempfile
import threading
import time

from ukrt.child_process import python_module
from ukrt.drivers.midi.host import NO_PRIORITY, SERVER_GONE
from ukrt.drivers.midi.port import load_rtmidi

_FIRST_WAIT, _LONGEST_WAIT = 0.25, 5.0  # [s] before a child that died is followed by another: doubled each time
_GOOD_LIFE = 10.0  # [s] after which a death counts as the first again
_CLOSE_SECONDS = 1.0  # for the child to end by itself; measured: 0.05 s
_SUMMED = ("received", "sensing_timeouts", "clock_restarts")  # what every child counts from zero


class MidiProcess:
    """MIDI inputs in a process of their own, merged into one lane of a stage.

    Parameters
    ----------
    manifest : dict
        ``engine.manifest()`` of an engine with ``shared=True``.
    wanted : None, "all", str, int or list of str or int
        None: one device, the first there is or appears. "all": every device, also those that appear later. Else an
        index (as in `list_inputs`), a name or a part of one, or several of them; what is not there yet is opened when
        it appears. The empty list: none.
    virtual : str, optional
        Name of a port of our own for other programs to connect to.
    delay_frames : int, optional
        From arrival to effect; if left out one block and 0.75 ms, so that no message comes too late.

    Raises
    ------
    MissingExtraError
        Without python-rtmidi.
    """

    def __init__(self, manifest, wanted=None, virtual=None, delay_frames=None):
        load_rtmidi()
        if wanted is not None and wanted != "all":
            wanted = [str(one) for one in (wanted if isinstance(wanted, list | tuple) else [wanted])]
        self._settings = {
            "stage": manifest["stage"],
            "choice": {"wanted": wanted},
            "virtual": virtual,
            "delay_frames": delay_frames,
            "resume": False,
        }
        self._lock = threading.Lock()
        self._ports, self._news, self._counts = [], [], {}
        self._earlier = dict.fromkeys(_SUMMED, 0)
        self._restarts, self._told = 0, set()
        self._process, self._closing, self._ready = None, threading.Event(), threading.Event()
        self._thread = threading.Thread(target=self._keep_alive, name="ukrt-midi-watch", daemon=True)

    def start(self):
        """Start the child; returns at once."""
        self._thread.start()

    def wait_ready(self, seconds):
        """Wait until the inputs that there are have been opened; False if that takes longer (JACK servers hang)."""
        return self._ready.wait(seconds)

    def close(self):
        """End what the inputs hold down, and the child, within two seconds."""
        self._closing.set()
        with self._lock:
            process = self._process
        if process is not None:
            with contextlib.suppress(OSError):
                process.stdin.close()
            try:
                process.wait(_CLOSE_SECONDS)
            except subprocess.TimeoutExpired:
                process.kill()
        if self._thread.ident is not None:
            self._thread.join(_CLOSE_SECONDS)

    @property
    def pid(self):
        """Process number of the child (int), None while there is none."""
        with self._lock:
            return self._process.pid if self._process is not None and self._process.poll() is None else None

    def ports(self):
        """Names of the inputs that are open now (list of str)."""
        return list(self._ports)

    def news(self):
        """Sentences since the last call (list of str)."""
        with self._lock:
            news, self._news = self._news, []
        return news

    def counts(self):
        """Numbers so far (dict): ``received``, ``refused`` by class, ``sensing_timeouts``, ``restarts`` of the child,
        ``clock_restarts``, ``longest_poll_ms`` (in the last half second) and ``scheduling`` in words."""
        with self._lock:
            counts = {"received": 0, "refused": {}, "sensing_timeouts": 0, "clock_restarts": 0, **self._counts}
            return {
                **counts,
                **{name: counts[name] + self._earlier[name] for name in _SUMMED},
                "restarts": self._restarts,
            }

    def _keep_alive(self):
        wait = _FIRST_WAIT
        while not self._closing.is_set():
            born = time.monotonic()
            self._live_once()
            if self._closing.is_set():
                return
            wait = _FIRST_WAIT if time.monotonic() - born > _GOOD_LIFE else min(2.0 * wait, _LONGEST_WAIT)
            self._closing.wait(wait)

    def _live_once(self):
        """Start a child and take in what it says until it ends."""
        with tempfile.TemporaryFile() as complaints:
            try:
                with self._lock:
                    self._process = process = subprocess.Popen(
                        **python_module("ukrt.drivers.midi.host"),
                        stdin=subprocess.PIPE,
                        stdout=subprocess.PIPE,
                        stderr=complaints,
                    )
                with contextlib.suppress(OSError, ValueError):
                    process.stdin.write(json.dumps(self._settings).encode() + b"\n")
                    process.stdin.flush()
                self._listen(process)
                process.wait()
            except OSError as error:
                self._tell_once(f"the MIDI process cannot be started: {error}")
                return
            finally:
                self._ports = []
            with contextlib.suppress(OSError, ValueError):
                process.stdin.close()
            process.stdout.close()
            self._note_death(process.returncode, complaints)

    def _listen(self, process):
        for line in process.stdout:
            try:
                said = json.loads(line)
            except ValueError:  # a line that was cut off by the child's end
                continue
            with self._lock:
                self._news += said.get("news", [])
                self._counts = said.get("counts", self._counts)
                self._settings["choice"] = said.get("choice", self._settings["choice"])
            scheduling = said.get("counts", {}).get("scheduling", "")
            if scheduling.startswith(NO_PRIORITY):
                self._tell_once(f"MIDI runs at {scheduling}")
            if "ports" in said:
                self._ports = said["ports"]
                self._ready.set()

    def _note_death(self, code, complaints):
        with self._lock:
            for name in _SUMMED:
                self._earlier[name] += self._counts.pop(name, 0)
            self._restarts += not self._closing.is_set()
            self._settings["resume"] = code != SERVER_GONE  # which ends what was held before it goes
        if code != SERVER_GONE and not self._closing.is_set():
            complaints.seek(0)
            last = complaints.read().decode(errors="replace").strip().splitlines()[-1:]
            why = f": {last[0].strip()}" if last else ""
            self._tell_once(f"the MIDI process has ended by itself (exit code {code}{why}) and is started again")

    def _tell_once(self, sentence):
        with self._lock:
            if sentence not in self._told:  # what goes wrong again and again is no news
                self._told.add(sentence)
                self._news.append(sentence)
