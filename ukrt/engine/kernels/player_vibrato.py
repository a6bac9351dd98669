"""Vibrato: the left hand sways the tension of what it holds, as far as wheel and pressure say, beside any pitch bend.

Enter the frame, at multiples of CHUNK; leave one straight tension gesture for each slot of time and swaying string.
Depth grows and falls gradually, and a string that is let be comes back to exactly what its bend wants.
"""

import math

from ukrt.engine import player_layout as at
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.player_rpn import vibrato_depth
from ukrt.engine.kernels.player_strings import set_tension, string_ratio
from ukrt.engine.kernels.player_zones import vibrato_asked

SLOTS_TO_DEPTH = 10.0  # slots in which the depth goes all the way: 0.1 s (estimate)
NARROW = 10.0  # cents: a depth that is no longer allowed goes at least as fast as one of this would (choice)
MOST = 2.0 ** ((at.MAX_BEND_CENTS + 100) / 600.0)  # a bent string sways no further: its modes stay below 22 kHz


@kernel
def _wanted(d, i, s):
    """Depth [cents] that the string's note is asked for."""
    return vibrato_asked(i, s) * vibrato_depth(d, i, i[at.S_CHANNEL + s]) / 127.0


@kernel
def _step(d, i, s, depth):
    """How far the depth may go in one slot."""
    full = vibrato_depth(d, i, i[at.S_CHANNEL + s])
    return (full if depth <= full else max(depth, NARROW)) / SLOTS_TO_DEPTH


@kernel
def follow_vibrato(d, i, now):
    """At absolute multiples of I_VIBRATO_SLOT: the next piece of every string's vibrato, LEAD frames late as all is."""
    if now % i[at.I_VIBRATO_SLOT] != 0:
        return
    for s in range(i[at.I_STRINGS]):
        sounds = i[at.S_STATE + s] == at.HELD or i[at.S_STATE + s] == at.PEDALLED
        if not sounds:
            d[at.D_DEPTH + s] = d[at.D_PHASE + s] = 0.0
            continue
        wanted, depth = _wanted(d, i, s), d[at.D_DEPTH + s]
        if wanted == 0.0 and depth == 0.0:
            continue
        change = _step(d, i, s, depth)
        depth += max(-change, min(change, wanted - depth))
        phase = (d[at.D_PHASE + s] + d[at.D_VIBRATO_STEP]) % (2.0 * math.pi) if depth > 0.0 else 0.0
        d[at.D_DEPTH + s], d[at.D_PHASE + s] = depth, phase
        ratio = string_ratio(d, i, s) * 2.0 ** (depth * math.sin(phase) / 600.0)
        ratio = max(1.0 / MOST, min(MOST, ratio))
        set_tension(d, i, s, now + i[at.I_LEAD], ratio, i[at.I_VIBRATO_SLOT], 1.0)
