"""A callback that plays nothing: the measure of the machine and its audio server without the instrument.

Enter PortAudio's arguments and sixteen words; leave silence, and in the words how often and for how many frames it was
called, with which flags, and how far apart. Compared with the instrument's callback on the same server.
"""

import numpy as np
from numba import carray, types

from ukrt.engine.kernels.jit import entry_point
from ukrt.engine.kernels.machine import ticks

WORDS = 16
CHANNELS, BLOCKS, FRAMES, FLAGS, LAST, LONGEST_GAP = 0, 1, 2, 3, 8, 9
# CHANNELS is set by the host. FLAGS: blocks with each of PortAudio's five kinds of flags, in the order of their bits.
# LAST, LONGEST_GAP: ticks of the newest call, and the most between two calls; the host may write 0 to begin anew.
KINDS = 5

_ULONG = types.uint32 if np.dtype("L").itemsize == 4 else types.uint64


@entry_point(types.int32(types.voidptr, types.voidptr, _ULONG, types.voidptr, _ULONG, types.CPointer(types.int64)))
def count_blocks(_input, output, n_frames, _time, flags, words):
    """PortAudio's stream callback that only counts. Returns paContinue."""
    seen = carray(words, WORDS)
    now, frames, channels = ticks(), np.int64(n_frames), min(max(seen[CHANNELS], 0), 64)
    out = carray(output, frames * channels, np.float32)
    for k in range(frames * channels):
        out[k] = np.float32(0.0)
    for kind in range(KINDS):
        seen[FLAGS + kind] += (np.int64(flags) >> kind) & 1
    if seen[LAST] > 0 and now - seen[LAST] > seen[LONGEST_GAP]:
        seen[LONGEST_GAP] = now - seen[LAST]
    seen[LAST] = now
    seen[BLOCKS] += 1
    seen[FRAMES] += frames
    return 0
