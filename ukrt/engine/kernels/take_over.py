"""A change of guitar as a C function of its own, which the callback calls when it is time.

Enters the host's table of words, leaves the instance that comes with what rings and is held on the one that goes.
Compiled apart from the callback, by another core.
"""

from numba import carray, types

from ukrt.engine import stage_layout as at
from ukrt.engine.kernels.jit import entry_point
from ukrt.engine.kernels.slots import slot_arrays
from ukrt.engine.kernels.transfer import transfer_state


@entry_point(types.int32(types.CPointer(types.int64), types.int64, types.int64))
def take_over(host, old, now):
    """The instance in the slot beside ``old`` takes over from that one at frame ``now``. Always 0."""
    words = carray(host, at.WORDS)
    d0, i0, v0, vi0 = slot_arrays(words, old)
    d1, i1, v1, vi1 = slot_arrays(words, 1 - old)
    transfer_state(d0, i0, v0, vi0, d1, i1, v1, vi1, now)
    return 0
