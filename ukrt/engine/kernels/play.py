"""The guitarist as a C function of its own, which the callback calls for each message.

Enters the host's table of words and a message, leaves the instance that is heard with the gestures that it asks for.
Compiled apart from the callback, by another core: no sample waits for a message's call.
"""

from numba import carray, types

from ukrt.engine import stage_layout as at
from ukrt.engine.kernels.jit import entry_point
from ukrt.engine.kernels.machine import integers_at
from ukrt.engine.kernels.player import player_message
from ukrt.engine.kernels.slots import slot_arrays


@entry_point(types.int32(types.CPointer(types.int64), types.int64, types.int64))
def play(host, now, word):
    """A MIDI message, its three bytes in ``word``, reaches the player at frame ``now``. Always 0."""
    words = carray(host, at.WORDS)
    d, i, _, _ = slot_arrays(words, integers_at(words[at.W_SI], at.SI_SIZE)[at.G_SLOT])
    player_message(d, i, now, (word >> 16) & 0xFF, (word >> 8) & 0xFF, word & 0xFF)
    return 0
