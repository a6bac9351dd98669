"""A second listener beside the guitar, which does nothing but note MIDI messages: what it loses, the server loses.

A compiled JACK client with one MIDI input; leaves the messages that arrived.
"""

import ctypes

import numba
import numpy as np
from numba import types

from ukrt.engine.kernels.foreign import bytes_at, c_function
from ukrt.engine.kernels.machine import address_of, integers_at

CLIENT = "witness"
PORT, GET_BUFFER, EVENT_COUNT, EVENT_GET, ROOM, COUNT, MESSAGES, EVENT = range(8)
WORDS = 16  # the last ones are room for a jack_midi_event_t: uint32 and padding, size_t, pointer
_FUNCTIONS = {
    GET_BUFFER: "jack_port_get_buffer",
    EVENT_COUNT: "jack_midi_get_event_count",
    EVENT_GET: "jack_midi_event_get",
}

_get_buffer = c_function("pointer", "pointer", "int")
_event_count = c_function("int", "pointer")
_event_get = c_function("int", "pointer", "pointer", "int")


@numba.cfunc(types.int32(types.uint32, types.voidptr), nopython=True, error_model="numpy")
def process(n_frames, table):
    """JackProcessCallback: each message of three bytes becomes one more word in the list."""
    address = address_of(table)
    t = integers_at(address, WORDS)
    messages = integers_at(t[MESSAGES], t[ROOM])
    buffer = _get_buffer(t[GET_BUFFER], (t[PORT], np.int64(n_frames)))
    for k in range(_event_count(t[EVENT_COUNT], (buffer,))):
        if _event_get(t[EVENT_GET], (address + 8 * EVENT, buffer, k)) == 0 and t[EVENT + 1] == 3 and t[COUNT] < t[ROOM]:
            data = bytes_at(t[EVENT + 2], 3)
            messages[t[COUNT]] = np.int64(data[0]) << 16 | np.int64(data[1]) << 8 | np.int64(data[2])
            t[COUNT] += 1
    return 0


class Witness:
    """A client that listens to ``source``, the name of a MIDI output."""

    def __init__(self, source, room=1 << 18):
        import jack

        self._client = jack.Client(CLIENT, no_start_server=True)
        port = self._client.midi_inports.register("in")
        library = ctypes.CDLL(jack._libname)
        self._table, self._messages = np.zeros(WORDS, np.int64), np.zeros(room, np.int64)
        self._table[MESSAGES], self._table[ROOM] = self._messages.ctypes.data, room
        for word, name in _FUNCTIONS.items():
            self._table[word] = ctypes.cast(getattr(library, name), ctypes.c_void_p).value
        self._table[PORT] = int(jack._ffi.cast("uintptr_t", port._ptr))
        callback = jack._ffi.cast("JackProcessCallback", process.address)
        data = jack._ffi.cast("void *", self._table.ctypes.data)
        jack._lib.jack_set_process_callback(self._client._ptr, callback, data)
        self._client.activate()
        self._client.connect(source, port)

    def heard(self):
        """The messages so far as words (list of int), and begin anew."""
        count = int(self._table[COUNT])
        words = self._messages[:count].tolist()
        self._table[COUNT] = 0
        return words

    def close(self):
        """Leave the server."""
        self._client.deactivate()
        self._client.close()
