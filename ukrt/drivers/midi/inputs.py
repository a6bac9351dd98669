"""The MIDI inputs there are, for people to choose from: a wish enters, one of them leaves."""

from collections import namedtuple

from ukrt.drivers.midi.port import PortLists, devices
from ukrt.drivers.quiet import quiet_stderr
from ukrt.drivers.sound.portaudio import choose

_JACK_SECONDS = 2.0  # the most that is waited for a JACK server's answer

InputPort = namedtuple("InputPort", "index name api port")


def list_inputs():
    """All MIDI inputs that there are now (list of `InputPort`); an API that does not answer has none."""
    with quiet_stderr():
        lists = PortLists()
        lists.jack_answered(_JACK_SECONDS)
        found = lists.look()
        lists.close()
    return [InputPort(index, port.name, port.api_name, port) for index, port in enumerate(found)]


def find_input(wanted=None):
    """The input with the index or part of a name ``wanted``, else the first that is a device; None where there is none.

    "Midi Through", ALSA's loop from programs to programs, is no device: it is taken only when asked for.
    """
    inputs = list_inputs()
    if wanted is not None:
        return choose(inputs, wanted, "MIDI input")
    first = devices([one.port for one in inputs])[:1]
    return next((one for one in inputs if one.port in first), None)
