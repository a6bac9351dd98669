"""The complete callback: from time-stamped MIDI messages to output samples, in compiled code without the interpreter.

Enter an instance and a number of frames; leave samples and counts. Work goes in chunks that end at messages, at
gestures and at absolute multiples of 64 frames; every sample is computed the same way whatever the chunk, so that the
host's block size changes no bit. One C function, with PortAudio's signature, serves live playing (float32, with the
output gain) and offline rendering (doubles, without).
"""

import math

import numpy as np
from numba import carray, types

from ukrt.engine import layout as at
from ukrt.engine.kernels.advance import advance
from ukrt.engine.kernels.convolve import convolve_chunk, convolver_reset
from ukrt.engine.kernels.hands import perform
from ukrt.engine.kernels.jit import entry_point, kernel
from ukrt.engine.kernels.machine import FLUSH, address_of, doubles_at, float_mode, integers_at, set_float_mode, ticks
from ukrt.engine.kernels.player import player_message, player_tick
from ukrt.engine.kernels.ports import sum_string
from ukrt.engine.kernels.timeline import timeline_drop_first, timeline_next


@kernel
def take_messages(d, i, now):
    """Give the player every message that is due; returns the frame of the next one, or a frame far away."""
    read, write = i[at.H_MIDI_READ], i[at.H_MIDI_WRITE]
    while read < write:
        slot = at.MIDI + 2 * (read % at.MIDI_QUEUE)
        frame, word = i[slot], i[slot + 1]
        if frame > now:
            i[at.H_MIDI_READ] = read
            return frame
        if frame < now:
            i[at.H_MIDI_LATE] += 1
        i[at.H_MIDI_COUNT] += 1
        player_message(d, i, now, (word >> 16) & 0xFF, (word >> 8) & 0xFF, word & 0xFF)
        read += 1
    i[at.H_MIDI_READ] = read
    return 1 << 62


@kernel
def perform_due(d, i, now):
    """Begin every gesture that is due."""
    while timeline_next(i, now + 1) <= now:
        kind, s = i[at.GESTURES_I + 1], i[at.GESTURES_I + 2]
        p0, p1 = d[at.GESTURES], d[at.GESTURES + 1]
        p2, p3 = d[at.GESTURES + 2], d[at.GESTURES + 3]
        timeline_drop_first(d, i)
        perform(d, i, kind, s, p0, p1, p2, p3)


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


@kernel
def _is_sane(d, i, n):
    """Whether the chunk is all numbers: what is none never leaves the state again, so its last sample tells."""
    total = d[at.BRIDGE + n - 1] + d[at.BRIDGE + at.CHUNK + n - 1]
    for k in range(at.LANES):
        total += d[at.MU + k] + d[at.LAM_Y + k] + d[at.LAM_Z + k]
    if i[at.H_CONVOLVE]:
        total += d[at.PRESSURE + n - 1] + d[at.PRESSURE + at.CHUNK + n - 1]
    return math.isfinite(total)


@kernel
def _write(d, i, n, out, first):
    """The chunk's samples, interleaved, to ``out`` from frame ``first`` on."""
    channels, signal = i[at.H_CHANNELS], i[at.H_SIGNAL]
    if signal == at.SIGNAL_PRESSURE:
        for k in range(n):
            out[2 * (first + k)], out[2 * (first + k) + 1] = d[at.PRESSURE + k], d[at.PRESSURE + at.CHUNK + k]
    elif signal == at.SIGNAL_FORCE:
        for k in range(n):
            out[first + k] = d[at.BRIDGE + k] + d[at.BRIDGE + at.CHUNK + k]
    else:
        for k in range(n):
            for s in range(channels):
                out[(first + k) * channels + s] = d[at.STRINGS_OUT + k * at.LANES + s]
    peak = d[at.METER + at.M_PEAK]
    for k in range(first * channels, (first + n) * channels):
        if abs(out[k]) > peak:
            peak = abs(out[k])
    d[at.METER + at.M_PEAK] = peak


@kernel
def process_frames(d, i, v, vi, out, n_frames):
    """Compute ``n_frames`` frames into ``out``, a flat array of interleaved doubles."""
    done = 0
    while done < n_frames:
        now = i[at.H_FRAME]
        coming = take_messages(d, i, now)
        if now % at.CHUNK == 0:
            player_tick(d, i, now)
        perform_due(d, i, now)
        end = min(now + n_frames - done, (now // at.CHUNK + 1) * at.CHUNK)
        end = timeline_next(i, min(end, coming))
        n = end - now
        advance(d, i, n)
        if i[at.H_CONVOLVE]:
            convolve_chunk(v, vi, now, n, d, at.BRIDGE, d, at.PRESSURE)
        if not _is_sane(d, i, n):
            i[at.H_NONFINITE] += 1
            come_to_rest(d, i, v, vi)
            for k in range(2 * at.CHUNK):
                d[at.BRIDGE + k] = d[at.PRESSURE + k] = 0.0
            for k in range(at.CHUNK * at.LANES):
                d[at.STRINGS_OUT + k] = 0.0
        _write(d, i, n, out, done)
        i[at.H_FRAME] = end
        done += n


@kernel
def _count_load(d, i, spent, n_frames):
    """One more block that took ``spent`` ticks, into the histogram of loads."""
    full = d[at.METER + at.M_TICKS_PER_FRAME] * n_frames
    if full > 0.0 and spent > 0:
        place = at.LOAD_FULL + int(math.floor(at.LOAD_PER_OCTAVE * math.log2(spent / full)))
        i[at.LOAD + min(max(place, 0), at.LOAD_BINS - 1)] += 1


@kernel
def _to_card(d, i, buffer, out, first, n):
    """Doubles to the sound card's float32, with the output gain; what exceeds full scale is counted and held there."""
    gain = d[at.METER + at.M_GAIN]
    for k in range(n):
        value = gain * buffer[k]
        if abs(value) > 1.0:
            i[at.H_CLIPPED] += 1
            value = math.copysign(1.0, value)
        out[first + k] = np.float32(value)


_ULONG = types.uint32 if np.dtype("L").itemsize == 4 else types.uint64


@entry_point(types.int32(types.voidptr, types.voidptr, _ULONG, types.voidptr, _ULONG, types.CPointer(types.int64)))
def callback(_input, output, n_frames, _time, flags, instance):
    """PortAudio's stream callback; ``instance`` is the table of words that layout.py describes. Returns paContinue."""
    words = carray(instance, at.INSTANCE_WORDS)
    if words[at.W_MAGIC] != at.MAGIC or words[at.W_VERSION] != at.VERSION:
        return 2  # paAbort
    begun = ticks()
    mode = float_mode()
    set_float_mode(mode | FLUSH)
    d, i = doubles_at(words[at.W_D], words[at.W_D_SIZE]), integers_at(words[at.W_I], words[at.W_I_SIZE])
    v, vi = doubles_at(words[at.W_V], words[at.W_V_SIZE]), integers_at(words[at.W_VI], words[at.W_VI_SIZE])
    frames, channels = np.int64(n_frames), i[at.H_CHANNELS]
    if int(flags) & at.DOUBLE_OUTPUT:
        process_frames(d, i, v, vi, doubles_at(address_of(output), frames * channels), frames)
    else:
        out = carray(output, frames * channels, np.float32)
        buffer = doubles_at(words[at.W_OUT], words[at.W_OUT_SIZE])
        most, done = words[at.W_OUT_SIZE] // channels, 0
        while done < frames:
            n = min(most, frames - done)
            process_frames(d, i, v, vi, buffer, n)
            _to_card(d, i, buffer, out, done * channels, n * channels)
            done += n
        i[at.H_UNDERFLOWS] += (int(flags) // at.UNDERFLOW_FLAG) & 1
        i[at.H_OVERFLOWS] += (int(flags) // at.OVERFLOW_FLAG) & 1
    i[at.H_BLOCKS] += 1
    set_float_mode(mode)
    _count_load(d, i, ticks() - begun, frames)
    return 0
