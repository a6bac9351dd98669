"""Vibrato: the left hand sways the tension of what it holds, as far as wheel and pressure say, beside any pitch bend.

Enter the frame, at multiples of CHUNK; leave one straight tension gesture for each slot of time and swaying string.
Depth grows and falls gradually, and a string that is let be comes back to exactly what its bend wants.
"""

import math

from ukrt.engine import player_layout as at
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.player_strings import set_tension, string_ratio
from ukrt.engine.kernels.player_zones import vibrato_asked

SLOTS_TO_DEPTH = 10.0  # slots in which the depth goes all the way: 0.1 s (estimate)


@kernel
def _wanted(d, i, s):
    """Depth [cents] that the string's note is asked for."""
    return vibrato_asked(i, s) * d[at.D_VIBRATO_CENTS] / 127.0


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
        change = d[at.D_VIBRATO_CENTS] / SLOTS_TO_DEPTH
        depth += max(-change, min(change, wanted - depth))
        phase = (d[at.D_PHASE + s] + d[at.D_VIBRATO_STEP]) % (2.0 * math.pi) if depth > 0.0 else 0.0
        d[at.D_DEPTH + s], d[at.D_PHASE + s] = depth, phase
        ratio = string_ratio(d, i, s) * 2.0 ** (depth * math.sin(phase) / 600.0)
        set_tension(d, i, s, now + i[at.I_LEAD], ratio, i[at.I_VIBRATO_SLOT], 1.0)
