"""The MIDI process: ``python -m ukrt.drivers.midi.host``. Messages of all inputs go into a lane of the stage.

One line of JSON enters through standard input (see `run`); lines of JSON leave through standard output: ports, news,
counts. It is a process of its own so that nothing the player's interpreter does can hold up a message, ends when its
standard input does, and imports neither NumPy nor Numba, to be there at once.
"""

import contextlib
import faulthandler
import gc
import json
import os
import signal
import sys
import threading
import time

from ukrt.drivers.midi.choice import Choice
from ukrt.drivers.midi.clock import FrameClock
from ukrt.drivers.midi.held import everything_off
from ukrt.drivers.midi.lane import Lane, StageView
from ukrt.drivers.midi.merge import Merger
from ukrt.drivers.midi.port import OpenInput, Port, PortLists
from ukrt.drivers.midi.talk import Talk
from ukrt.engine import stage_layout as at
from ukrt.errors import DeviceError

SERVER_GONE = 3  # exit code: libjack is best left after its server has died, with the whole process
NO_PRIORITY = "ordinary priority"
POLL_SECONDS = 0.0005
MARGIN_SECONDS = 0.00075  # a message is in the lane so long after it arrived: one interval, and a late awakening
_LIST_SECONDS = 0.25  # between two looks at the ports: 0.1 ms of work
_REPORT_SECONDS = 0.5
_HANG_SECONDS = 5.0  # without a report: a library that does not return; the process ends itself, to be started again
_JACK_SECONDS = 2.0  # the most that is waited for a JACK server's first answer
_PRIORITY = 20  # of SCHED_FIFO: above everything ordinary, below audio threads (JACK: 70 and less)
_NICE = -11  # where that is not allowed: what desktops give to audio


class MidiHost:
    """Everything the process does, between two looks at the clock.

    Parameters
    ----------
    settings : dict
        See `run`.
    say : callable
        Takes a dict.
    """

    def __init__(self, settings, say):
        self._say = say
        self._view = StageView(settings["stage"])
        self._lane = Lane(self._view.si, at.LANE_MIDI)
        self._clock = FrameClock(self._view, settings["delay_frames"], MARGIN_SECONDS)
        self._merger = Merger(self._lane, self._clock)
        self._choice = Choice(**settings["choice"])
        self._virtual = settings["virtual"]
        self._lists, self._failed, self._told = PortLists(), set(), set()
        self._next_list = self._next_report = 0
        self._told_ports, self._longest_ns, self._polled_ns = None, 0, 0
        if settings["resume"]:
            for message in everything_off():
                self._lane.push(self._clock.frame(), *message)

    def run(self, ended):
        """Work until the event ``ended`` is set; returns the exit code."""
        _watch_oneself()
        self._scheduling = raise_scheduling()
        self._lists.jack_answered(_JACK_SECONDS)  # a server that hangs is taken for none
        parent = os.getppid()
        while not ended.is_set():
            now = time.monotonic_ns()
            if self._polled_ns:
                self._longest_ns = max(self._longest_ns, now - self._polled_ns)
            self._polled_ns = now
            self._merger.poll(now)
            if now >= self._next_list:
                self._next_list = now + round(_LIST_SECONDS * 1e9)
                self._tend_ports()
                if os.getppid() != parent:  # gone, while somebody else holds our standard input open
                    ended.set()
                if self._lists.jack_died:
                    self._say({"news": ["the JACK server has gone, and its MIDI inputs with it"], "ports": []})
                    return self._leave(SERVER_GONE)
            if now >= self._next_report:
                self._next_report = now + round(_REPORT_SECONDS * 1e9)
                self._report()
            time.sleep(POLL_SECONDS)
        return self._leave(0)

    def _tend_ports(self):
        """Close what has gone, open what has come."""
        listed = self._lists.look()
        there = {port.identity for port in listed}
        wanted = {port.identity: port for port in self._choice.ports(listed)}
        for one in self._merger.inputs:
            if not one.virtual and one.port.identity not in wanted:
                self._merger.remove(one, "makes way" if one.port.identity in there else "has gone")
        self._failed &= set(wanted)
        settled = {one.port.identity for one in self._merger.inputs} | self._failed
        for identity, port in wanted.items():
            if identity not in settled:
                self._open(port)
        if self._virtual is not None and not any(one.virtual for one in self._merger.inputs):
            self._open_virtual()
        news = self._choice.news() + self._merger.news
        self._merger.news = []
        if news or self._told_ports != self._merger.names:
            self._told_ports = self._merger.names
            self._say({"news": news, "ports": self._told_ports, "choice": self._choice.resolved()})

    def _open(self, port):
        try:
            self._merger.add(OpenInput(port))
        except DeviceError as error:
            self._failed.add(port.identity)  # not tried again until it has been away
            self._merger.news.append(str(error))

    def _open_virtual(self):
        for api in self._lists.virtual_apis():
            try:
                self._merger.add(OpenInput(Port(self._virtual, api, "virtual", 0), virtual=True))
                return
            except DeviceError as error:
                reason = str(error)
                if reason not in self._told:
                    self._told.add(reason)
                    self._merger.news.append(reason)

    def _report(self):
        _watch_oneself()
        other, note_on, note_end = self._lane.refused()
        self._say(
            {
                "counts": {
                    "received": self._merger.received,
                    "refused": {"other": other, "note_on": note_on, "note_end": note_end},
                    "sensing_timeouts": self._merger.sensing_timeouts,
                    "clock_restarts": self._clock.restarts,
                    "longest_poll_ms": round(self._longest_ns / 1e6, 3),
                    "scheduling": self._scheduling,
                }
            }
        )
        self._longest_ns = 0

    def _leave(self, code):
        """End what is held and say the last; nothing is closed where a server has died, which might not return."""
        self._merger.end()
        self._report()
        if code != SERVER_GONE:
            for one in self._merger.inputs:
                one.close()
            self._lists.close()
        return code


def raise_scheduling():
    """Let this process go before ordinary ones, as far as the system allows; returns what came of it in words.

    Threads that are started later inherit it, which those of RtMidi's ALSA part need as much.
    """
    if hasattr(os, "sched_setscheduler"):
        for priority in (_PRIORITY, _allowed_priority()):
            with contextlib.suppress(OSError):
                os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
                return f"real time, priority {priority}"
    with contextlib.suppress(OSError, AttributeError):
        os.setpriority(os.PRIO_PROCESS, 0, _NICE)
        return f"nice {_NICE}"
    return f"{NO_PRIORITY}: the system allows no higher one, so that other programs may delay it"


def _allowed_priority():
    """The highest real-time priority up to ours that the limits allow once raised (int, 0: none)."""
    import resource

    _, hard = resource.getrlimit(resource.RLIMIT_RTPRIO)
    resource.setrlimit(resource.RLIMIT_RTPRIO, (hard, hard))
    return min(_PRIORITY, hard) if hard >= 0 else _PRIORITY


def run():
    """Read the settings, work until standard input ends.

    The one line of settings: ``stage`` (manifest of the stage's shared memory, as `StageView` takes it), ``choice``
    (arguments of `Choice`), ``virtual`` (name of a virtual port or null), ``delay_frames`` (or null: one block) and
    ``resume`` (true where a process before this one died, so that nobody knows what it held down).
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the parent's to hear
    ended = threading.Event()
    signal.signal(signal.SIGTERM, lambda *_: ended.set())
    line = sys.stdin.buffer.readline()
    if not line:
        return 0
    threading.Thread(target=_watch_parent, args=(ended,), daemon=True).start()
    silence_libraries()
    gc.disable()  # nothing here makes cycles
    talk = Talk(sys.stdout.fileno())
    code = MidiHost(json.loads(line), talk.say).run(ended)
    talk.flush()
    return code


def _watch_oneself():
    """End this process, unless called again in time; what watches is a thread that needs no interpreter."""
    faulthandler.dump_traceback_later(_HANG_SECONDS, exit=True)


def _watch_parent(ended):
    """Set ``ended`` when standard input ends, as it does with the parent."""
    while sys.stdin.buffer.readline():
        pass
    ended.set()


def silence_libraries():
    """Let C libraries print into nowhere, and Python where it did before: they complain about whatever is absent."""
    sys.stderr = os.fdopen(os.dup(2), "w", buffering=1)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 2)
    os.close(nowhere)


if __name__ == "__main__":
    os._exit(run())  # libraries of dead servers may hang in what they do at the end
