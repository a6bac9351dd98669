"""The MIDI inputs of this machine through RtMidi: lists of ports enter, open inputs that are polled leave.

RtMidi's queue is polled and never its Python callback used: on JACK that callback runs in the server's own thread,
where it waits for the interpreter and loses messages. Nothing here needs NumPy: the MIDI process must start fast.
"""

import re
import time
from collections import namedtuple

from ukrt.drivers.jack.watch import JackWatch, load_jack
from ukrt.drivers.midi.arrival import Arrivals
from ukrt.drivers.midi.stream import MidiStream
from ukrt.errors import DeviceError, MissingExtraError

CLIENT = "ukrt"
_QUEUE = 16384  # messages RtMidi keeps until polled; its own default of 1024 loses notes in bursts
_AT_ONCE = 1024  # messages taken from one input before the others have their turn
_AGAIN_SECONDS = 2.0  # between two looks for an API that does not answer
_NUMBERS = {  # what names end with changes when a port is plugged in again
    "ALSA": re.compile(r" \d+:\d+$"),  # client:port
    "Windows MultiMedia": re.compile(r" \d+$"),  # the place in the list
}

_LOOP = "Midi Through"  # ALSA's loop from programs to programs is no device
_BRIDGES = ("system:", "a2j:", "Midi-Bridge:")  # JACK's and PipeWire's views of what ALSA lists as well


class Port(namedtuple("Port", "name api api_name number")):
    """A MIDI input in a list: its full name, RtMidi's number and name of the API, the place in the API's list."""

    @property
    def identity(self):
        """What stays while the port is there, wherever it stands in the list."""
        return self.api, self.name


def stable_name(port):
    """The name of a port without what changes when it is plugged in again (str)."""
    number = _NUMBERS.get(port.api_name)
    return number.sub("", port.name) if number else port.name


def shown_name(port):
    """The name of a port for people (str)."""
    return f"{stable_name(port)} ({port.api_name})"


def devices(ports):
    """Those of ``ports`` that are played on, each once: no loops, no second view of the same through a bridge."""
    real = [port for port in ports if _LOOP not in port.name]
    direct = [port for port in real if not port.name.startswith(_BRIDGES)]
    return direct if any(port.api_name != "Jack" for port in direct) else real


def distinct(names):
    """The names with a number behind those that have come before (list of str): two keyboards of one kind on macOS."""
    seen = []
    for name in names:
        earlier = names[: len(seen)].count(name)
        seen.append(f"{name} #{earlier + 1}" if earlier else name)
    return seen


class PortLists:
    """The inputs of all of RtMidi's APIs, looked at as often as wanted without disturbing a JACK server."""

    def __init__(self):
        self._rtmidi = load_rtmidi()
        self._apis = self._rtmidi.get_compiled_api()
        self._jack_api = self._rtmidi.API_UNIX_JACK
        self._libjack = load_jack() if self._jack_api in self._apis else None
        self._lookers = {}  # API -> MidiIn or JackWatch
        self._tried = {}  # API -> time of the last attempt [s]

    @property
    def jack_died(self):
        """Whether the JACK server that was there has gone (bool)."""
        watch = self._lookers.get(self._jack_api)
        return isinstance(watch, JackWatch) and watch.dead

    def jack_answered(self, seconds):
        """Wait until it is known whether there is a JACK server; False if that takes longer than ``seconds``."""
        watch = self._looker(self._jack_api) if self._libjack else None
        return watch is None or watch.answered.wait(seconds)

    def look(self):
        """All inputs that there are now (list of `Port`); an API that does not answer has none."""
        return [
            Port(name, api, self._rtmidi.get_api_display_name(api), number)
            for api in self._apis
            for number, name in enumerate(distinct(self._names(api)))
        ]

    def virtual_apis(self):
        """The APIs that answer and know virtual ports (list of int)."""
        none = {self._rtmidi.API_WINDOWS_MM, self._rtmidi.API_RTMIDI_DUMMY}
        return [api for api in self._apis if api not in none and self._answers(self._looker(api))]

    def close(self):
        """Let go of everything."""
        for looker in self._lookers.values():
            if isinstance(looker, JackWatch):
                looker.close()
            elif looker is not None:
                looker.delete()
        self._lookers = {}

    def _names(self, api):
        looker = self._looker(api)
        if not self._answers(looker):
            return []
        return looker.outputs() if isinstance(looker, JackWatch) else looker.get_ports()

    @staticmethod
    def _answers(looker):
        return looker is not None and getattr(looker, "found", True)

    def _looker(self, api):
        """What lists the ports of an API; None, or a watch that has found nothing, while it does not answer."""
        looker, now = self._lookers.get(api), time.monotonic()
        waiting = isinstance(looker, JackWatch) and not looker.answered.is_set()
        if self._answers(looker) or waiting or now - self._tried.get(api, -_AGAIN_SECONDS) < _AGAIN_SECONDS:
            return looker
        self._tried[api] = now
        if api == self._jack_api and self._libjack is not None:
            looker = JackWatch(self._libjack)
        else:
            try:
                looker = self._rtmidi.MidiIn(api, name=f"{CLIENT}-list")
            except self._rtmidi.RtMidiError:
                looker = None
        self._lookers[api] = looker
        return looker


class OpenInput:
    """An open MIDI input, or a virtual port that others connect to.

    Parameters
    ----------
    port : Port
        As just listed; for a virtual port a name of ours and its API.
    virtual : bool
    """

    def __init__(self, port, virtual=False):
        rtmidi = load_rtmidi()
        self.port, self.virtual = port, virtual
        try:
            self._midi = rtmidi.MidiIn(port.api, name=CLIENT, queue_size_limit=_QUEUE)
            if virtual:
                self._midi.open_virtual_port(port.name)
            else:
                self._midi.open_port(port.number, name="in")
        except (rtmidi.RtMidiError, OSError, NotImplementedError) as error:
            raise DeviceError(f"the MIDI input {port.name!r} cannot be opened: {error}") from error
        # Nothing is left out in RtMidi, which would lose the times of what it leaves out.
        self._midi.ignore_types(sysex=False, timing=False, active_sense=False)
        self._stream, self._arrivals = MidiStream(), Arrivals()

    def poll(self):
        """What has arrived: list of (time of arrival [ns of ``time.monotonic_ns``], `Message`), oldest first."""
        found, get = [], self._midi.get_message
        for _ in range(_AT_ONCE):
            got = get()
            if got is None:
                break
            polled = time.monotonic_ns()  # afterwards: a message never comes later than its poll
            packet, since_last = got
            arrived = self._arrivals.at(since_last, polled)
            found += [(arrived, message) for message in self._stream.feed(packet)]
        return found

    def close(self):
        """Close the port."""
        self._midi.close_port()
        self._midi.delete()


def load_rtmidi():
    """The module rtmidi, or a sentence about what is missing."""
    try:
        import rtmidi
    except ImportError as error:
        raise MissingExtraError("MIDI input needs python-rtmidi, which is missing: pip install 'ukrt[live]'") from error
    return rtmidi
