"""PortAudio in a process of its own: requests enter as lines of JSON, answers leave as lines of JSON.

``python -m ukrt.drivers.sound.host`` attaches the engine's shared memory and lets PortAudio call the compiled function
on it. On an audio server that died PortAudio hangs for ever, and its list of devices is never brought up to date; this
process can be killed at any moment and started anew, since all that the engine knows is in the shared memory. It ends
by itself when its standard input closes, which happens at the latest when its parent ends, however that ends.
"""

import dataclasses
import json
import os
import queue
import signal
import sys
import threading
import time

from ukrt.drivers.sound import portaudio as audio
from ukrt.drivers.sound import scheduling
from ukrt.errors import DeviceError, UkrtError

_WATCH_SECONDS = 0.05  # between two looks whether PortAudio goes on
_LEAVE_SECONDS = 2.0  # for PortAudio to take leave of its servers; measured: 0.02 s with JACK
_THREAD_SECONDS = 1.0  # for the first block to tell which thread calls


class AudioHost:
    """Carries out requests; each method is one, its arguments the request's other fields, its result the answer."""

    def __init__(self):
        self.output = None
        self.started = False
        self._attached = None
        self._notes = []

    def list(self, host_api=None):
        """All audio outputs."""
        return {"outputs": [dataclasses.asdict(o) for o in audio.list_outputs(host_api)]}

    def probe(self, wanted=None, host_api=None, sample_rate=None, preferred=48000.0, channels=2):
        """The device that is meant (None where there is none) and the rate that it would run at."""
        device = audio.find_output(wanted, host_api)
        if device is None:
            return {"device": None, "sample_rate": None}
        rate = audio.choose_rate(device, sample_rate, channels, preferred)
        return {"device": dataclasses.asdict(device), "sample_rate": rate}

    def open(self, manifest, wanted=None, host_api=None, sample_rate=None, channels=None, **settings):
        """Open a stream for the engine that ``manifest`` describes; ``settings`` are ``block_size`` and ``latency``."""
        device = audio.find_output(wanted, host_api)
        if device is None:
            raise DeviceError("no sound card found")
        rate = audio.choose_rate(device, sample_rate, channels or manifest["channels"], manifest["sample_rate"])
        from ukrt.engine.attached import Attached  # here, so that a listing need not wait for the compiler's library

        self._notes.append(scheduling.lock_memory())  # so that what is attached now is there before it is used
        self._attached = Attached(manifest)
        self.output = audio.AudioOutput(self._attached, device, sample_rate=rate, channels=channels, **settings)
        return {
            "device": dataclasses.asdict(device),
            "name": self.output.name,
            "sample_rate": self.output.sample_rate,
            "block_size": self.output.block_size,
            "latency": self.output.latency,
        }

    def start(self):
        """Let PortAudio call the engine; tells what the system did not allow."""
        self.output.start()
        self.started = True
        ends = time.monotonic() + _THREAD_SECONDS
        while (thread := self._attached.thread_id) == 0 and time.monotonic() < ends:
            time.sleep(0.002)
        if thread:
            self._notes.append(scheduling.raise_thread(thread))
        return {"notes": [note for note in self._notes if note]}

    def refresh(self, manifest):
        """Take over instances that the engine has loaded since."""
        self._attached.reload(manifest)
        return {}

    def close(self):
        """Stop the stream; whoever asked for it waits no longer than it likes."""
        return {"closed": self.output is None or self.output.close()}


def _answer(host, request):
    """The answer to one request (dict); what went wrong is an answer too."""
    try:
        arguments = json.loads(request)
        return getattr(host, arguments.pop("do"))(**arguments)
    except UkrtError as error:
        return {"error": str(error), "kind": type(error).__name__}
    except Exception as error:  # PortAudio's own, or a fault of ours: told over there, in one line
        return {"error": f"{type(error).__name__}: {' '.join(str(error).split())}", "kind": "DeviceError"}


def _read_requests(stream, requests):
    """Pass lines on, then None; soon after it the process ends, whatever its other threads wait for."""
    for line in stream:
        requests.put(line)
    requests.put(None)
    time.sleep(_LEAVE_SECONDS)
    os._exit(0)


def main():
    """Serve until standard input closes, a request to close has been answered, or the sound stops."""
    for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGTSTP"):  # the parent decides when this ends
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_IGN)
    answers = os.fdopen(os.dup(1), "w", buffering=1)
    os.dup2(2, 1)  # C libraries print what they like; it must not come between the answers
    requests = queue.SimpleQueue()
    threading.Thread(target=_read_requests, args=(sys.stdin, requests), daemon=True).start()
    host = AudioHost()
    while True:
        try:
            request = requests.get(timeout=_WATCH_SECONDS)
        except queue.Empty:
            if host.started and not host.output.running:
                print(json.dumps({"stopped": True}), file=answers)
                os._exit(1)
            continue
        answer = {} if request is None else _answer(host, request)
        if request is not None:
            print(json.dumps(answer), file=answers)
        if request is None or "closed" in answer:
            if answer.get("closed", True):  # else PortAudio hangs already
                audio.leave()
            os._exit(0)


if __name__ == "__main__":
    main()
