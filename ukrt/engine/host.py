"""What a process needs to call the engine's C function: views of a stage and its instances enter, two addresses leave.

The arrays may be shared with other processes; the table of addresses is this process's own.
"""

import ctypes
import sys
import time

import numpy as np

from ukrt.engine import compiled
from ukrt.engine import stage_layout as at

_MONOTONIC = {"linux": 1, "darwin": 8}  # the clock that time.monotonic_ns reads: CLOCK_MONOTONIC, CLOCK_UPTIME_RAW


class Host:
    """The table of words with which this process calls `callback` on a stage.

    Parameters
    ----------
    stage : dict of str to ndarray
        ``si``, ``sd`` and ``ring``.
    """

    def __init__(self, stage):
        self._words = np.zeros(at.WORDS, np.int64)
        self._kept = [stage, None, None]  # whatever the words point at
        words = self._words
        words[at.W_MAGIC], words[at.W_VERSION] = at.MAGIC, at.VERSION
        words[at.W_SI], words[at.W_SD] = stage["si"].ctypes.data, stage["sd"].ctypes.data
        words[at.W_RING] = stage["ring"].ctypes.data
        words[at.W_CLOCK], words[at.W_CLOCK_ID] = _library_function("clock_gettime"), _MONOTONIC.get(sys.platform, 0)
        words[at.W_TIME_AT] = words.ctypes.data + 8 * (at.W_TIME_AT + 1)
        words[at.W_THREAD_ID] = _library_function("gettid") if sys.platform == "linux" else 0
        words[at.W_TABLE] = words.ctypes.data
        words[at.W_PLAY], words[at.W_TAKE_OVER] = compiled.address("play"), compiled.address("take_over")
        stage["sd"][at.M_TICKS_PER_SECOND] = tick_rate()

    @property
    def callback_address(self):
        """Address of the C function with PortAudio's callback signature (int)."""
        return compiled.address("callback")

    @property
    def userdata_address(self):
        """Address of the table of words, the callback's user data (int); valid while this object lives."""
        return self._words.ctypes.data

    def point(self, slot, arrays):
        """Let ``slot`` (0, 1) be the instance of these arrays (dict of d, i, v, vi; None: empty).

        Not while the callback may look at that slot.
        """
        base = at.W_SLOTS + slot * at.SLOT_WORDS
        self._kept[1 + slot] = arrays
        for k, name in enumerate(("d", "i", "v", "vi")):
            address, size = (arrays[name].ctypes.data, arrays[name].size) if arrays else (0, 0)
            self._words[base + 2 * k], self._words[base + 2 * k + 1] = address, size

    def close(self):
        """The callback refuses from now on."""
        self._words[at.W_MAGIC] = 0
        self._kept = []


def _library_function(name):
    """The address of a function of the C library, 0 where there is none."""
    if sys.platform not in _MONOTONIC:
        return 0
    try:
        return ctypes.cast(getattr(ctypes.CDLL(None), name), ctypes.c_void_p).value or 0
    except (AttributeError, OSError):
        return 0


_tick_rate = None


def tick_rate(seconds=0.02):
    """Ticks per second of the counter that measures the callback's load [1/s]; 0 where there is none. Measured once."""
    global _tick_rate
    if _tick_rate is None:
        began, first = time.perf_counter(), compiled.ticks_now()
        time.sleep(seconds)
        _tick_rate = (compiled.ticks_now() - first) / (time.perf_counter() - began)
    return _tick_rate
