"""One instance, one chunk: strings, body and radiation advance by up to 64 frames, and samples leave.

A chunk never reaches across a gesture or an absolute multiple of 64 frames; every sample is computed the same way
whatever the chunk, so that nobody's block size changes a bit.
"""

import math

from ukrt.engine import layout as at
from ukrt.engine.kernels.advance import advance
from ukrt.engine.kernels.convolve import convolve_chunk, convolver_reset
from ukrt.engine.kernels.hands import perform
from ukrt.engine.kernels.jit import inlined, kernel
from ukrt.engine.kernels.player import player_tick
from ukrt.engine.kernels.player_level import apply_level
from ukrt.engine.kernels.player_vibrato import follow_vibrato
from ukrt.engine.kernels.ports import sum_string
from ukrt.engine.kernels.shed import tend_shed
from ukrt.engine.kernels.timeline import timeline_drop_first, timeline_next


@inlined
def begin_chunk(d, i, now):
    """What is due at ``now``, after the messages: housekeeping at its times, then gestures."""
    if now % at.CHUNK == 0:
        player_tick(d, i, now)
        follow_vibrato(d, i, now)
        tend_shed(d, i, now)
    perform_due(d, i, now)


@inlined
def perform_due(d, i, now):
    """Begin every gesture that is due."""
    while timeline_next(i, now + 1) <= now:
        kind, s = i[at.GESTURES_I + 1], i[at.GESTURES_I + 2]
        p0, p1 = d[at.GESTURES], d[at.GESTURES + 1]
        p2, p3 = d[at.GESTURES + 2], d[at.GESTURES + 3]
        timeline_drop_first(d, i)
        perform(d, i, kind, s, p0, p1, p2, p3)


@inlined
def compute_chunk(d, i, v, vi, now, n):
    """Compute ``n`` frames into the instance's own buffers; False if something is no number any more."""
    advance(d, i, n)
    if i[at.H_CONVOLVE]:
        convolve_chunk(v, vi, now, n, d, at.BRIDGE, d, at.PRESSURE)
        apply_level(d, i, n)
    return _is_sane(d, i, n)


@inlined
def _is_sane(d, i, n):
    """Whether the chunk is all numbers: what is none never leaves the state again, so its last sample tells."""
    total = d[at.BRIDGE + n - 1] + d[at.BRIDGE + at.CHUNK + n - 1]
    for k in range(at.LANES):
        total += d[at.MU + k] + d[at.LAM_Y + k] + d[at.LAM_Z + k]
    if i[at.H_CONVOLVE]:
        total += d[at.PRESSURE + n - 1] + d[at.PRESSURE + at.CHUNK + n - 1]
    return math.isfinite(total)


@kernel
def come_to_rest(d, i, v, vi):
    """Clear everything that moves, after something that is not a number; fingers stay where they are."""
    for k in range(at.MAX_TILES * at.STATE_TILE):
        d[at.STATE + k] = 0.0
    for k in range(at.PORTS * at.LANES):
        d[at.FIN_Y + k] = d[at.FIN_Z + k] = d[at.FIN_Y1 + k] = d[at.FIN_Z1 + k] = 0.0
        d[at.LAND_Y + k] = d[at.LAND_Z + k] = 0.0
    for k in range(at.LANES):
        d[at.PSI + k] = d[at.MU + k] = 0.0
    for k in range(at.MAX_BODY_MODES):
        d[at.BODY_X + k] = d[at.BODY_XS + k] = 0.0
    d[at.BODY_W + 3] = d[at.BODY_W + 4] = 0.0
    for s in range(i[at.H_STRINGS]):
        i[at.STRING_I + s * at.STRING_I_SIZE + at.SI_LAND_LENGTH] = 0
        sum_string(d, i, s)
    if i[at.H_CONVOLVE]:
        convolver_reset(v, vi)
    for k in range(2 * at.CHUNK):
        d[at.BRIDGE + k] = d[at.PRESSURE + k] = 0.0
    for k in range(at.CHUNK * at.LANES):
        d[at.STRINGS_OUT + k] = 0.0


@inlined
def sample_of(d, i, k, channel):
    """Sample ``k`` of the chunk just computed, of one channel of the instance's signal [Pa] or [N]."""
    if i[at.H_SIGNAL] == at.SIGNAL_PRESSURE:
        return d[at.PRESSURE + channel * at.CHUNK + k]
    if i[at.H_SIGNAL] == at.SIGNAL_FORCE:
        return d[at.BRIDGE + k] + d[at.BRIDGE + at.CHUNK + k]
    return d[at.STRINGS_OUT + k * at.LANES + channel]
