"""The stage's loop: messages and frames enter, samples of the instance that plays leave.

Work goes in chunks that end at messages, gestures, swaps and absolute multiples of 64 frames. While one instance gives
way to another both are computed and crossfaded.
"""

import math

from ukrt.engine import layout as instance_at
from ukrt.engine import stage_layout as at
from ukrt.engine.kernels.events import mend, mono_word, rest, shed, swap, take_messages, tend_sensing
from ukrt.engine.kernels.jit import inlined, kernel
from ukrt.engine.kernels.process import begin_chunk, compute_chunk, sample_of
from ukrt.engine.kernels.queue import journal
from ukrt.engine.kernels.slots import slot_arrays
from ukrt.engine.kernels.timeline import timeline_next


@inlined
def _chunk_end(si, now, last):
    """Where the chunk from ``now`` ends at the latest, for the stage's own sake."""
    end = min(last, (now // instance_at.CHUNK + 1) * instance_at.CHUNK)
    if si[at.G_MUTE_END] > now:
        end = min(end, si[at.G_MUTE_END])
    if si[at.G_SWAP] and si[at.G_SWAP_FRAME] > now:
        end = min(end, si[at.G_SWAP_FRAME])
    if si[at.G_FADE] > 0:
        end = min(end, now + si[at.G_FADE])
    if si[at.G_FADE_IN] > 0:
        end = min(end, now + si[at.G_FADE_IN])
    return end


@kernel
def _weight(left):
    """Share of the instance that comes, ``left`` frames before the end of a fade (raised cosine)."""
    return 0.5 + 0.5 * math.cos(math.pi * (left - 0.5) / at.FADE)


@inlined
def _write(words, si, sd, d, i, n, out, first, raw):
    """The chunk's samples, interleaved, to ``out`` from frame ``first`` on, in the middle of a fade where there is one.
    """
    channels = si[at.G_CHANNELS]
    gain = d[instance_at.METER + instance_at.M_GAIN] if not raw else 1.0
    for k in range(n):
        for channel in range(channels):
            out[(first + k) * channels + channel] = gain * sample_of(d, i, k, channel)
    if si[at.G_FADE_IN] > 0:
        for k in range(n):
            for channel in range(channels):
                out[(first + k) * channels + channel] *= _weight(si[at.G_FADE_IN] - k)
        si[at.G_FADE_IN] -= n
    if si[at.G_FADE] > 0:
        d0, i0, _, _ = slot_arrays(words, 1 - si[at.G_SLOT])
        old_gain = d0[instance_at.METER + instance_at.M_GAIN] if not raw else 1.0
        for k in range(n):
            weight = _weight(si[at.G_FADE] - k)
            for channel in range(channels):
                place = (first + k) * channels + channel
                out[place] = weight * out[place] + (1.0 - weight) * old_gain * sample_of(d0, i0, k, channel)
        si[at.G_FADE] -= n


@inlined
def _compute(words, si, d, i, v, vi, now, n):
    """Compute the chunk in the instances that sound; what is muted or no number comes to rest."""
    sane = compute_chunk(d, i, v, vi, now, n)
    if si[at.G_FADE] > 0:
        d0, i0, v0, vi0 = slot_arrays(words, 1 - si[at.G_SLOT])
        sane = compute_chunk(d0, i0, v0, vi0, now, n) and sane
    muted = si[at.G_MUTE_END] > now
    if muted or not sane:
        if not muted:
            si[at.N_NONFINITE] += 1
            journal(si, now, mono_word(at.KIND_RESET, n))
        rest(words, si)


@kernel
def process_frames(words, si, sd, out, n_frames, raw):
    """Compute ``n_frames`` frames into ``out``, a flat array of interleaved doubles; with the gain unless ``raw``."""
    done = 0
    while done < n_frames:
        now = si[at.G_FRAME]
        if si[at.G_TORN]:
            mend(words, si, sd, now)
        if si[at.G_SWAP] and 0 <= si[at.G_SWAP_FRAME] <= now:
            swap(words, si, sd, now)
        if si[at.G_SHED_WANTED] != si[at.G_SHED]:
            shed(words, si, now, si[at.G_SHED_WANTED])
        d, i, v, vi = slot_arrays(words, si[at.G_SLOT])
        if now % instance_at.CHUNK == 0:
            tend_sensing(words, si, sd, now)
        coming = take_messages(words, si, now)
        begin_chunk(d, i, now)
        end = timeline_next(i, min(coming, _chunk_end(si, now, now + n_frames - done)))
        if si[at.G_FADE] > 0:
            d0, i0, _, _ = slot_arrays(words, 1 - si[at.G_SLOT])
            begin_chunk(d0, i0, now)
            end = timeline_next(i0, end)
        n = end - now
        _compute(words, si, d, i, v, vi, now, n)
        _write(words, si, sd, d, i, n, out, done, raw)
        si[at.G_FRAME] = end
        done += n
