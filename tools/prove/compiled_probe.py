"""The probe's process callback, compiled: a sender that Python holds up would be measured instead of the guitar.

Enter a table of words with addresses and a schedule; leave MIDI events and marks in their cycle's buffers, and in the
schedule where each went.
"""

import ctypes

import numba
import numpy as np
from numba import types

from ukrt.engine.kernels.foreign import c_function
from ukrt.engine.kernels.machine import address_of, integers_at, singles_at

(
    CLIENT, MIDI, MARKER, GET_BUFFER, CLEAR, WRITE, CYCLE_TIME, COUNT, NEXT, FRAMES, BYTES, MARKS, SENT, OFFSETS,
    REFUSED,
) = range(15)  # fmt: skip
WORDS = 16
# COUNT  messages of the schedule, written last; NEXT: the first one that has not gone out
# FRAMES, MARKS, SENT, OFFSETS  addresses of an int64 for each message; BYTES: of four bytes for each
_ENOUGH = 2400  # messages in one cycle; jack2's buffers hold 2730 of three bytes
_FUNCTIONS = {
    GET_BUFFER: "jack_port_get_buffer",
    CLEAR: "jack_midi_clear_buffer",
    WRITE: "jack_midi_event_write",
    CYCLE_TIME: "jack_last_frame_time",
}

_get_buffer = c_function("pointer", "pointer", "int")
_clear = c_function("void", "pointer")
_write = c_function("int", "pointer", "int", "pointer", "long")
_cycle_time = c_function("int", "pointer")


@numba.cfunc(types.int32(types.uint32, types.voidptr), nopython=True, error_model="numpy")
def process(n_frames, table):
    """JackProcessCallback: all messages that are due, at their frames; late ones at the cycle's beginning."""
    t = integers_at(address_of(table), WORDS)
    n = np.int64(n_frames)
    begins = _cycle_time(t[CYCLE_TIME], (t[CLIENT],))
    midi, mark = _get_buffer(t[GET_BUFFER], (t[MIDI], n)), _get_buffer(t[GET_BUFFER], (t[MARKER], n))
    _clear(t[CLEAR], (midi,))
    marker = singles_at(mark, n)
    for k in range(n):
        marker[k] = np.float32(0.0)
    count = t[COUNT]
    frames, marks = integers_at(t[FRAMES], count), integers_at(t[MARKS], count)
    sent, offsets = integers_at(t[SENT], count), integers_at(t[OFFSETS], count)
    for _ in range(_ENOUGH):
        one = t[NEXT]
        if one >= count or frames[one] >= begins + n:
            break
        offset = max(np.int64(0), frames[one] - begins)
        if _write(t[WRITE], (midi, offset, t[BYTES] + 4 * one, np.int64(3))) != 0:
            t[REFUSED] += 1
            break
        if marks[one]:
            marker[offset] = np.float32(1.0)
        sent[one], offsets[one] = begins + offset, offset
        t[NEXT] = one + 1
    return 0


class Sender:
    """The table, and how to hand it to a client that has not been activated yet.

    Parameters
    ----------
    client : jack.Client
    midi, marker : jack ports of this client
    """

    def __init__(self, client, midi, marker):
        import jack

        library = ctypes.CDLL(jack._libname)
        self.table, self._kept = np.zeros(WORDS, np.int64), None
        for word, name in _FUNCTIONS.items():
            self.table[word] = ctypes.cast(getattr(library, name), ctypes.c_void_p).value
        for word, one in ((CLIENT, client), (MIDI, midi), (MARKER, marker)):
            self.table[word] = int(jack._ffi.cast("uintptr_t", one._ptr))
        callback = jack._ffi.cast("JackProcessCallback", process.address)
        jack._lib.jack_set_process_callback(client._ptr, callback, jack._ffi.cast("void *", self.table.ctypes.data))

    def begin(self, frames, messages, marks):
        """Send a schedule (frames of JACK's time, bytes of three each) from now on."""
        self.table[COUNT] = 0  # the callback looks at nothing else then
        self.table[NEXT] = self.table[REFUSED] = 0
        raw = np.frombuffer(b"".join(message.ljust(4, b"\0") for message in messages), np.uint8).copy()
        self._kept = [np.array(frames, np.int64), raw, np.array(marks, np.int64), *np.zeros((2, len(frames)), np.int64)]
        for word, array in zip((FRAMES, BYTES, MARKS, SENT, OFFSETS), self._kept, strict=True):
            self.table[word] = array.ctypes.data
        self.table[COUNT] = len(frames)

    @property
    def over(self):
        """Whether everything has been sent."""
        return bool(self.table[NEXT] >= self.table[COUNT])

    def result(self):
        """JACK's frame of each message, its place in its cycle, and how often a cycle's buffer was full."""
        return self._kept[3].tolist(), self._kept[4].tolist(), int(self.table[REFUSED])
