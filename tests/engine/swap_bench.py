"""Instances on the bench and the swap from one to the other, without a stage: player, hands, strings, body, radiation.

Enter guitars, messages and a frame to swap at; leave the force on the bridge and the pressure, as the old instance, the
new one and a crossfade of both give them.
"""

from types import SimpleNamespace

import numpy as np

from ukrt.engine import controller_layout as cc
from ukrt.engine import layout as at
from ukrt.engine import player_layout as player_at
from ukrt.engine.instance import Instance
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.player import player_message
from ukrt.engine.kernels.process import begin_chunk, compute_chunk
from ukrt.engine.kernels.timeline import timeline_next
from ukrt.engine.kernels.transfer import transfer_state
from ukrt.engine.note_log import read_counters, read_note_log

RATE = 48000.0
FADE = 2048  # frames, as the stage fades


def instance(guitar, rate=RATE, n_taps=3000, seed=1):
    """An instance at rest, with a decaying random response: enough for partitions of two sizes."""
    noise = np.random.default_rng(seed).standard_normal((n_taps, 2, 2))
    response = SimpleNamespace(samples=noise * np.exp(-np.arange(n_taps) / 600.0)[:, None, None])
    return Instance(guitar, rate, impulse_response=response)


@kernel
def _play(d, i, v, vi, now, n_frames, messages, out):
    read, first, last = 0, now, now + n_frames
    while now < last:
        end = min(last, (now // at.CHUNK + 1) * at.CHUNK)
        while read < len(messages) and messages[read, 0] <= now:
            if messages[read, 0] == now:
                player_message(d, i, now, messages[read, 1], messages[read, 2], messages[read, 3])
            read += 1
        if read < len(messages):
            end = min(end, messages[read, 0])
        begin_chunk(d, i, now)
        end = timeline_next(i, end)
        if not compute_chunk(d, i, v, vi, now, end - now):
            return False
        for k in range(end - now):
            out[now - first + k, 0] = d[at.BRIDGE + k] + d[at.BRIDGE + at.CHUNK + k]
            out[now - first + k, 1] = d[at.PRESSURE + k]
        now = end
    return True


def play(one, now, n_frames, messages=()):
    """Frames ``now`` to ``now + n_frames`` of an instance; of the messages those that fall there.

    Returns
    -------
    ndarray (n_frames, 2)
        Force on the bridge [N], and pressure on the left [Pa].
    """
    out = np.empty((n_frames, 2))
    table = np.array(sorted(messages, key=lambda message: message[0]), np.int64).reshape(-1, 4)
    assert _play(one.d, one.i, one.v, one.vi, now, n_frames, table, out), "something was no number"
    return out


def check_blocks(guitar, messages):
    """Blocks of any size give the same bits."""
    whole = play(instance(guitar), 0, 30000, messages)
    one, parts, now = instance(guitar), [], 0
    for n in (1, 37, 64, 500, 8407, 130, 5000, 8000, 7861):
        parts.append(play(one, now, n, messages))
        now += n
    assert np.array_equal(np.concatenate(parts), whole)


def swap(old, new, now):
    """The new instance takes over what the old one does."""
    transfer_state(old.d, old.i, old.v, old.vi, new.d, new.i, new.v, new.vi, now)


def counters(one):
    return read_counters(one.i)


def note_log(one):
    return read_note_log(one.d, one.i, one.sample_rate)


def crossfade(old, new):
    """From one signal (n, channels) to the other over FADE frames, by a raised cosine; then the other alone."""
    weight = np.ones((len(new), 1))
    weight[:FADE, 0] = 0.5 - 0.5 * np.cos(np.pi * (np.arange(FADE) + 0.5) / FADE)
    mixed = new * weight
    mixed[: len(old)] += old * (1.0 - weight[: len(old)])
    return mixed


def energy_above(signal, hz, rate=RATE):
    """Energy of a signal above a frequency, windowed so that its ends do not count."""
    spectrum = np.fft.rfft(signal * np.hanning(len(signal)))
    return float(np.sum(np.abs(spectrum[np.fft.rfftfreq(len(signal), 1.0 / rate) > hz]) ** 2))


def sound_through_a_swap(one, other, messages, channels):
    """Play ``messages`` with a swap from ``one`` to ``other`` in their midst, let go, and listen: then there is
    silence, and no note is left. Returns the sound (n,)."""
    end = messages[-1][0] + 1000
    for channel in range(channels):
        messages = [*messages, (end, 0xB0 | channel, cc.PEDAL, 0), (end, 0xB0 | channel, cc.NOTES_OFF, 0)]
    half = end // 2
    first = play(one, 0, half, messages)
    swap(one, other, half)
    sound = np.concatenate([first, play(other, half, end + 240000 - half, messages)])[:, 0]
    assert np.abs(sound).max() < 400.0
    assert counters(other)["gestures_refused"] == 0 and not other.i[player_at.S_STATE : player_at.S_STATE + 6].any()
    assert np.mean(sound[-4800:] ** 2) < 1e-6 * np.mean(sound[:end] ** 2)
    return sound
