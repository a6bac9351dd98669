"""A sound card that cannot take the program with it: an engine in shared memory enters, sound leaves through a child.

PortAudio lives in a process of its own (`audio_host`), which is asked in lines of JSON. When it hangs or dies it is
killed; the engine and everything that plays on it live on here, for the next child to go on with.
"""

import contextlib
import json
import queue
import subprocess
import threading

from ukrt import errors
from ukrt.child_process import python_module
from ukrt.drivers.sound.claims import claim, release
from ukrt.drivers.sound.portaudio import OutputDevice, check_settings

_ANSWER_SECONDS = 10.0  # for opening a device: libraries of a cold disk, servers that start up (choice)
_LEAVE_SECONDS = 3.0  # for taking leave of sound servers, which the child itself does not let last longer
_CLOSE_SECONDS = 0.5  # closing takes 0.05 s as measured; on a dead server it never returns
_GONE_SECONDS = 2.0


class Child:
    """A process with `audio_host` in it."""

    def __init__(self):
        self._process = subprocess.Popen(
            **python_module("ukrt.drivers.sound.host"),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )
        self._answers = queue.SimpleQueue()
        self._stopped = False
        threading.Thread(target=self._read, name="ukrt-audio-answers", daemon=True).start()

    def _read(self):
        with contextlib.suppress(ValueError):  # a line that was cut off by the child's end
            for line in self._process.stdout:
                answer = json.loads(line)
                if "stopped" in answer:
                    self._stopped = True
                else:
                    self._answers.put(answer)
        self._stopped = True
        self._answers.put(None)

    @property
    def pid(self):
        """The child's process number (int)."""
        return self._process.pid

    @property
    def running(self):
        """Whether the child lives and has not said that the sound stopped."""
        return not self._stopped and self._process.poll() is None

    def ask(self, request, seconds=_ANSWER_SECONDS, **arguments):
        """The answer to a request (dict).

        Raises
        ------
        DeviceError, MissingExtraError
            What the child could not do; or it did not answer in time, and is killed.
        """
        try:
            self._process.stdin.write(json.dumps({"do": request, **arguments}) + "\n")
            self._process.stdin.flush()
            answer = self._answers.get(timeout=seconds)
        except queue.Empty:
            self.kill()
            raise errors.DeviceError(
                f"the sound system does not answer: asked to {request}, it has said nothing for {seconds:g} s"
            ) from None
        except (OSError, ValueError):
            answer = None
        if answer is None:
            self.kill()
            raise errors.DeviceError(f"the process that plays the sound has ended by itself when asked to {request}")
        if "error" in answer:
            raise getattr(errors, answer["kind"], errors.DeviceError)(answer["error"])
        return answer

    def end(self):
        """Let the child take leave of its sound servers and end, or kill it if that takes too long."""
        with contextlib.suppress(OSError):
            self._process.stdin.close()
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(_LEAVE_SECONDS)
        self.kill()

    def kill(self):
        """End the child now; returns when it is gone, or cannot run any more before it goes."""
        self._process.kill()
        with contextlib.suppress(subprocess.TimeoutExpired):  # within a driver of the kernel's that waits for its card
            self._process.wait(_GONE_SECONDS)
        with contextlib.suppress(OSError):
            self._process.stdin.close()


def list_outputs(host_api=None):
    """All audio outputs that are there now (list of `OutputDevice`), as `audio.list_outputs` in a fresh process."""
    return [OutputDevice(**o) for o in _ask_once("list", host_api=host_api)["outputs"]]


def probe(wanted=None, host_api=None, sample_rate=None):
    """What `AudioProcess` would open with the same arguments.

    Returns
    -------
    device : OutputDevice or None
        None where there is no sound card at all.
    sample_rate : float or None [Hz]
    """
    if sample_rate is not None:
        check_settings(sample_rate)
    answer = _ask_once("probe", wanted=wanted, host_api=host_api, sample_rate=sample_rate)
    return (OutputDevice(**answer["device"]), answer["sample_rate"]) if answer["device"] else (None, None)


def _ask_once(request, **arguments):
    child = Child()
    try:
        return child.ask(request, **arguments)
    finally:
        child.end()


class AudioProcess:
    """A sound card, opened by PortAudio in a child process, that plays an engine.

    Parameters
    ----------
    engine : Engine
        With ``shared=True``.
    wanted : str or int, optional
        Index or part of the name of the output; by default the default one.
    host_api : str, optional
        Part of a host API's name: only its outputs.
    sample_rate : float [Hz], optional
        By default the engine's where the device can, else the device's own: compare the attribute with the engine's.
    block_size : int, optional
        Frames per callback; 0 lets the host decide, which is JACK's way and the default there, elsewhere 128.
    latency : {"low", "high"} or float [s]
    channels : int, optional
        How many of the card's channels to open: with one it gets the mean of left and right, with more than two left
        and right go to the first two. By default two, or one where the card has no more.

    Raises
    ------
    DeviceError
        The device is not there or refuses, or does not answer.
    """

    def __init__(
        self,
        engine,
        wanted=None,
        *,
        host_api=None,
        sample_rate=None,
        block_size=None,
        latency="low",
        channels=None,
    ):
        check_settings(engine.sample_rate if sample_rate is None else sample_rate, block_size, latency, channels)
        self._engine = engine
        self._notes = []
        self._child = Child()
        try:
            opened = self._child.ask(
                "open",
                manifest=engine.manifest(),
                wanted=wanted,
                host_api=host_api,
                sample_rate=sample_rate,
                block_size=block_size,
                latency=latency,
                channels=channels,
            )
        except BaseException:  # also an interrupt: nobody else knows the child
            self._child.kill()
            raise
        self.device = OutputDevice(**opened["device"])
        self.name, self.latency = opened["name"], opened["latency"]
        self.sample_rate, self.block_size = opened["sample_rate"], opened["block_size"]
        self._underflows = engine.counters()["underflows"]

    @property
    def pid(self):
        """The child's process number (int)."""
        return self._child.pid

    def start(self):
        """Let PortAudio call the engine from now on."""
        claim(self._engine, self)
        self._notes += self._child.ask("start")["notes"]

    @property
    def running(self):
        """Whether the child lives and PortAudio says that it goes on calling."""
        return self._child.running

    def refresh(self):
        """Let the child take over what the engine has loaded; to be done before ``engine.swap``."""
        self._child.ask("refresh", manifest=self._engine.manifest())

    def xruns(self):
        """Gaps in the sound that PortAudio has told of (int)."""
        return self._engine.counters()["underflows"] - self._underflows

    def news(self):
        """What the system did not allow, in sentences (list of str), each once."""
        notes, self._notes = self._notes, []
        return notes

    def close(self):
        """Stop the sound and end the child; False if it had to be killed. Nobody calls the engine any more after this.

        Where it was killed, ``engine.recover()`` tells whether that was in the middle of a block.
        """
        closed = False
        if self._child.running:
            with contextlib.suppress(errors.UkrtError):
                closed = self._child.ask("close", _CLOSE_SECONDS)["closed"]
        if closed:
            self._child.end()
        else:
            self._child.kill()
        release(self._engine, self)
        return closed
