"""The instances that a host's table of words points at, as arrays."""

from ukrt.engine import stage_layout as at
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.machine import doubles_at, integers_at


@kernel
def slot_arrays(words, slot):
    """The arrays d, i, v, vi of the instance in ``slot``."""
    base = at.W_SLOTS + slot * at.SLOT_WORDS
    return (
        doubles_at(words[base], words[base + 1]),
        integers_at(words[base + 2], words[base + 3]),
        doubles_at(words[base + 4], words[base + 5]),
        integers_at(words[base + 6], words[base + 7]),
    )


@kernel
def slot_filled(words, slot):
    """Whether there is an instance in ``slot``."""
    return words[at.W_SLOTS + slot * at.SLOT_WORDS] != 0
