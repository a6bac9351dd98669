"""The complete callback: from time-stamped MIDI messages to output samples, in compiled code without the interpreter.

One C function, with PortAudio's signature, serves live playing (float32: gain, limiter, record ring) and offline
rendering (doubles, raw). It allocates nothing, waits for nothing and cannot fail; what goes wrong is counted.
"""

import math

import numpy as np
from numba import carray, types

from ukrt.engine import stage_layout as at
from ukrt.engine.kernels.card import to_card
from ukrt.engine.kernels.jit import entry_point, inlined
from ukrt.engine.kernels.machine import (
    FLUSH,
    address_of,
    doubles_at,
    float_mode,
    integers_at,
    nanoseconds,
    set_float_mode,
    singles_at,
    store_release,
    thread_id,
    ticks,
)
from ukrt.engine.kernels.overload import watch_load
from ukrt.engine.kernels.slots import slot_filled
from ukrt.engine.kernels.stage import process_frames


@inlined
def _stamp(words, si, n_frames):
    """Publish when this block begins, so that messages can be given their frame."""
    if si[at.G_THREAD] == 0:
        si[at.G_THREAD] = thread_id(words[at.W_THREAD_ID])
    now = nanoseconds(words[at.W_CLOCK], words[at.W_CLOCK_ID], words[at.W_TIME_AT])
    sequence = si[at.G_STAMP_SEQ]
    store_release(si, at.G_STAMP_SEQ, sequence + 1)
    store_release(si, at.G_STAMP_FRAME, si[at.G_FRAME])
    store_release(si, at.G_STAMP_NS, now)
    store_release(si, at.G_STAMP_BLOCK, n_frames)
    store_release(si, at.G_STAMP_SEQ, sequence + 2)


@inlined
def _count_flags(si, flags):
    """What the host says went wrong before this block."""
    si[at.N_INPUT_UNDERFLOWS] += flags & 1
    si[at.N_INPUT_OVERFLOWS] += (flags >> 1) & 1
    si[at.N_UNDERFLOWS] += (flags >> 2) & 1
    si[at.N_OVERFLOWS] += (flags >> 3) & 1
    si[at.N_PRIMING] += (flags >> 4) & 1


@inlined
def _count_load(si, sd, spent, n_frames):
    """One more block that took ``spent`` ticks, into the histogram of loads; returns its load [1]."""
    full = sd[at.M_TICKS_PER_SECOND] * n_frames / sd[at.M_RATE]
    if full <= 0.0 or spent <= 0:
        return 0.0
    load = spent / full
    place = at.LOAD_FULL + int(math.floor(at.LOAD_PER_OCTAVE * math.log2(load)))
    si[at.LOAD + min(max(place, 0), at.LOAD_BINS - 1)] += 1
    si[at.N_LATE_BLOCKS] += 1 if load > 1.0 else 0
    return load


@inlined
def _compute(words, si, sd, out, raw, n_frames):
    """Compute a block: doubles to the address ``out``; or, for a card, pieces of bounded size to float32 there."""
    channels, done = si[at.G_CHANNELS], 0
    while done < n_frames:
        n, place = n_frames, out
        if not raw:
            n, place = min(at.MAX_PIECE, n_frames - done), words[at.W_SD] + 8 * at.OUT
        buffer = doubles_at(place, n * channels)
        process_frames(words, si, sd, buffer, n, raw)
        if not raw:
            ring = singles_at(words[at.W_RING], si[at.G_RING_FRAMES] * channels)
            to_card(si, sd, buffer, singles_at(out, n_frames * channels), done, ring, n)
        done += n


_ULONG = types.uint32 if np.dtype("L").itemsize == 4 else types.uint64


@entry_point(types.int32(types.voidptr, types.voidptr, _ULONG, types.voidptr, _ULONG, types.CPointer(types.int64)))
def callback(_input, output, n_frames, _time, flags, host):
    """PortAudio's stream callback; ``host`` is the table of words of stage_layout.py. Returns paContinue."""
    words = carray(host, at.WORDS)
    if words[at.W_MAGIC] != at.MAGIC or words[at.W_VERSION] != at.VERSION:
        return 2  # paAbort
    begun = ticks()
    mode = float_mode()
    set_float_mode(mode | FLUSH)
    si, sd = integers_at(words[at.W_SI], at.SI_SIZE), doubles_at(words[at.W_SD], at.SD_SIZE)
    frames, raw = np.int64(n_frames), int(flags) & at.DOUBLE_OUTPUT != 0
    si[at.G_BUSY] = 1
    _stamp(words, si, frames)
    if si[at.G_SWAP] and si[at.G_SWAP_FRAME] < 0 and slot_filled(words, 1 - si[at.G_SLOT]):
        si[at.G_SWAP_FRAME] = si[at.G_FRAME]
    _compute(words, si, sd, address_of(output), raw, frames)
    if not raw:
        _count_flags(si, int(flags))
    si[at.N_BLOCKS] += 1
    set_float_mode(mode)
    load = _count_load(si, sd, ticks() - begun, frames)
    if sd[at.M_SHED_BUDGET] > 0.0:
        watch_load(si, sd, load)
    store_release(si, at.G_BUSY, 0)
    return 0
