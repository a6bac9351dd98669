"""Cards with another number of channels than the guitar has: a block for one enters, a block for the other leaves.

A card with one channel gets the mean of left and right; on one with more, left and right go to the first two and the
others are silent. It is compiled and hands PortAudio's call through, so that no interpreter stands in between here
either.
"""

import numpy as np
from numba import carray, types

from ukrt.engine.kernels.foreign import c_function
from ukrt.engine.kernels.jit import entry_point, kernel
from ukrt.engine.kernels.machine import singles_at

T_FUNCTION, T_USERDATA, T_CHANNELS, T_CARD_CHANNELS, T_SCRATCH, T_SCRATCH_FRAMES, WORDS = range(7)
_compute = c_function("int", "pointer", "pointer", "long", "pointer", "long", "pointer")
_ULONG = types.uint32 if np.dtype("L").itemsize == 4 else types.uint64


@kernel
def _lay_out(source, channels, out, first, card_channels, n):
    """``n`` frames of ``source`` into ``out`` from frame ``first`` on."""
    for k in range(n):
        left, right = source[k * channels], source[k * channels + channels - 1]
        place = (first + k) * card_channels
        if card_channels == 1:
            out[place] = np.float32(0.5) * (left + right)
            continue
        out[place], out[place + 1] = left, right
        for channel in range(2, card_channels):
            out[place + channel] = np.float32(0.0)


@entry_point(types.int32(types.voidptr, types.voidptr, _ULONG, types.voidptr, _ULONG, types.CPointer(types.int64)))
def spread(_input, output, n_frames, _time, flags, table):
    """PortAudio's stream callback; ``table`` is the words above."""
    t = carray(table, WORDS)
    channels, card_channels, frames = t[T_CHANNELS], t[T_CARD_CHANNELS], np.int64(n_frames)
    source = singles_at(t[T_SCRATCH], t[T_SCRATCH_FRAMES] * channels)
    out = carray(output, frames * card_channels, np.float32)
    done, told = 0, np.int64(flags)
    while done < frames:
        n = min(t[T_SCRATCH_FRAMES], frames - done)
        code = _compute(t[T_FUNCTION], (0, t[T_SCRATCH], n, 0, told, t[T_USERDATA]))
        if code != 0:
            return code
        _lay_out(source, channels, out, done, card_channels, n)
        done, told = done + n, 0  # what went wrong before the block is told once
    return 0
