"""The JACK server seen from the side: its MIDI outputs and whether it still lives; nothing of it runs in audio time.

RtMidi tells neither that the server has died (its list of ports goes on showing what was there) nor, where the server
does not answer, ever returns. A client of libjack that is never activated costs the server nothing and is told.
"""

import ctypes
import threading

_LIBRARIES = ("libjack.so.0", "libjack.0.dylib", "libjack64.dll")
_NO_START_SERVER = 0x01  # jack/types.h
_IS_OUTPUT = 0x2
_MIDI_TYPE = b"8 bit raw midi"
_ON_SHUTDOWN = ctypes.CFUNCTYPE(None, ctypes.c_void_p)


class JackWatch:
    """One look-out for a server; begins to look for it at once, without waiting.

    Attributes
    ----------
    found : bool
        The server has answered.
    dead : bool
        It has gone since.
    answered : threading.Event
        The search is over, whatever came of it; never where the server hangs.
    """

    def __init__(self, library, name="ukrt-midi-watch"):
        self.found = self.dead = False
        self.answered = threading.Event()
        self._library, self._client = library, None
        self._shut_down = _ON_SHUTDOWN(self._on_shutdown)  # kept: libjack calls it
        threading.Thread(target=self._open, args=(name.encode(),), daemon=True).start()

    def _open(self, name):
        self._client = self._library.jack_client_open(name, _NO_START_SERVER, None)
        if self._client:
            self._library.jack_on_shutdown(self._client, self._shut_down, None)
        self.found = bool(self._client)
        self.answered.set()

    def _on_shutdown(self, _):
        self.dead = True

    def outputs(self):
        """Full names of all MIDI outputs, in the order in which RtMidi counts them (list of str)."""
        names = self._library.jack_get_ports(self._client, None, _MIDI_TYPE, _IS_OUTPUT)
        found = []
        if names:
            while (name := names[len(found)]) is not None:
                found.append(name.decode(errors="replace"))
            self._library.jack_free(names)
        return found

    def close(self):
        """Leave the server, if it is still there."""
        if self.found and not self.dead:
            self._library.jack_client_close(self._client)


def load_jack():
    """The library libjack, None where there is none."""
    for name in _LIBRARIES:
        try:
            return _declare(ctypes.CDLL(name))
        except (OSError, AttributeError):
            continue
    return None


def _declare(library):
    pointer, text = ctypes.c_void_p, ctypes.c_char_p
    for name, result, *arguments in (
        ("jack_client_open", pointer, text, ctypes.c_int, pointer),
        ("jack_client_close", ctypes.c_int, pointer),
        ("jack_on_shutdown", None, pointer, _ON_SHUTDOWN, pointer),
        ("jack_get_ports", ctypes.POINTER(text), pointer, text, text, ctypes.c_ulong),
        ("jack_free", None, pointer),
    ):
        function = getattr(library, name)
        function.restype, function.argtypes = result, arguments
    return library
