"""MIDI inputs through RtMidi: a port enters, the messages that have arrived leave when asked for.

RtMidi's queue is polled and never its Python callback used: on JACK that callback runs in the server's own thread,
where it waits for the interpreter and loses messages.
"""

from dataclasses import dataclass

from ..errors import DeviceError, MissingExtraError
from .audio import choose
from .quiet import quiet_stderr

_QUEUE = 16384  # messages RtMidi keeps until polled; its own default of 1024 loses notes in bursts
_CLIENT = "ukrt"


@dataclass(frozen=True)
class InputPort:
    """One MIDI input of this machine."""

    index: int
    name: str
    api: str
    api_number: int
    port_number: int


def list_inputs():
    """All MIDI inputs of all of RtMidi's APIs (list of `InputPort`); an API that does not answer has none."""
    rtmidi = _rtmidi()
    found = []
    for api in rtmidi.get_compiled_api():
        try:
            with quiet_stderr():
                probe = rtmidi.MidiIn(api, name=f"{_CLIENT}-probe")
                names = probe.get_ports()
                probe.delete()
        except rtmidi.RtMidiError:
            continue
        found += [(name, rtmidi.get_api_display_name(api), api, n) for n, name in enumerate(names)]
    return [InputPort(index, *port) for index, port in enumerate(found)]


def find_input(wanted=None):
    """The input with the index or part of a name ``wanted``, else the first that is a device; None where there is none.

    "Midi Through", ALSA's loop from programs to programs, is no device: it is taken only when asked for.
    """
    inputs = list_inputs()
    if wanted is not None:
        return choose(inputs, wanted, "MIDI input")
    return next((p for p in inputs if "Midi Through" not in p.name), None)


class MidiInput:
    """An open MIDI input that is asked for its messages."""

    def __init__(self, port):
        rtmidi = _rtmidi()
        self.name = f"{port.name} ({port.api})"
        try:
            with quiet_stderr():
                self._midi = rtmidi.MidiIn(port.api_number, name=_CLIENT, queue_size_limit=_QUEUE)
                self._midi.open_port(port.port_number)
        except (rtmidi.RtMidiError, OSError) as error:
            raise DeviceError(f"the MIDI input {port.name!r} cannot be opened: {error}") from error
        self._midi.ignore_types(sysex=True, timing=True, active_sense=True)

    def poll(self):
        """The channel messages that have arrived since the last call, oldest first (list of (status, data1, data2))."""
        messages = []
        while (got := self._midi.get_message()) is not None:
            data = got[0]
            if data and 0x80 <= data[0] < 0xF0:
                messages.append((*data, 0, 0)[:3])
        return messages

    def close(self):
        """Close the port."""
        self._midi.close_port()
        self._midi.delete()


def _rtmidi():
    try:
        import rtmidi
    except ImportError as error:
        raise MissingExtraError("MIDI input needs python-rtmidi, which is missing: pip install 'ukrt[live]'") from error
    return rtmidi
