"""The last step to a sound card: doubles enter; float32 that never exceed full scale leave, and go into the ring.

The limiter needs no look-ahead. An envelope (the larger channel's peak, instantly up, slowly down) is bent above the
knee so that it approaches full scale and never reaches it; both channels get the same gain, bent over unbent envelope.
"""

import math

import numpy as np

from ukrt.engine import stage_layout as at
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.machine import store_release

KNEE = 10.0 ** (-3.0 / 20.0)  # -3 dBFS: below it nothing is touched (choice)
RELEASE_SECONDS = 0.1  # the envelope falls to 1/e in this time (choice: slower than the lowest string's period, 12 ms)


@kernel
def _frame_peak(buffer, first, channels):
    peak = 0.0
    for channel in range(channels):
        peak = max(peak, abs(buffer[first + channel]))
    return peak


@kernel
def limiter_gain(envelope):
    """The gain that keeps a signal of this envelope below full scale: 1 up to the knee, slope continuous there."""
    if envelope <= KNEE:
        return 1.0
    above = (envelope - KNEE) / (1.0 - KNEE)
    return (KNEE + (1.0 - KNEE) * above / (1.0 + above)) / envelope


@kernel
def to_card(si, sd, buffer, out, first, ring, n):
    """``n`` frames of ``buffer`` to ``out`` from frame ``first`` on, limited; what still exceeds full scale is counted
    and held there."""
    channels, limiting = si[at.G_CHANNELS], si[at.G_LIMITER]
    release = math.exp(-1.0 / (RELEASE_SECONDS * sd[at.M_RATE]))
    envelope, loudest = sd[at.M_ENVELOPE], 0.0
    for k in range(n):
        peak = _frame_peak(buffer, k * channels, channels)
        envelope = max(peak, envelope * release)
        gain = 1.0
        if limiting and envelope > KNEE:
            gain = limiter_gain(envelope)
            si[at.N_LIMITED] += 1
        loudest = max(loudest, peak)
        for channel in range(channels):
            value = gain * buffer[k * channels + channel]
            if abs(value) > 1.0:
                si[at.N_CLIPPED] += 1
                value = math.copysign(1.0, value)
            out[(first + k) * channels + channel] = np.float32(value)
    sd[at.M_ENVELOPE] = envelope
    sd[at.M_PEAK] = max(sd[at.M_PEAK], loudest)
    sd[at.M_PEAK_RECENT] = max(sd[at.M_PEAK_RECENT], loudest)
    if si[at.G_RECORD]:
        _record(si, out, first, ring, n)


@kernel
def _record(si, out, first, ring, n):
    """Keep what the card gets; the oldest is overwritten, which the reader notices by the count."""
    channels, frames = si[at.G_CHANNELS], si[at.G_RING_FRAMES]
    count = si[at.N_RECORDED]
    for k in range(n):
        place = ((count + k) % frames) * channels
        for channel in range(channels):
            ring[place + channel] = out[(first + k) * channels + channel]
    store_release(si, at.N_RECORDED, count + n)
