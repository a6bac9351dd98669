"""Two instances on the bench and the swap from one to the other, without a host: player, hands, strings, body.

Enter guitars, messages and a frame to swap at; leave the force on the bridge, as the old instance, the new one and a
crossfade of both give it.
"""

from types import SimpleNamespace

import numba
import numpy as np

from ukrt.engine import layout as at
from ukrt.engine.discretize import aligned, fill_instance, make_arrays
from ukrt.engine.kernels.advance import advance
from ukrt.engine.kernels.convolve import convolve_chunk, convolver_prepare, convolver_size
from ukrt.engine.kernels.hands import perform
from ukrt.engine.kernels.player import player_message, player_reset, player_tick
from ukrt.engine.kernels.timeline import timeline_drop_first, timeline_next
from ukrt.engine.kernels.transfer import transfer_state
from ukrt.engine.note_log import read_counters, read_note_log
from ukrt.engine.player_tables import make_player_tables
from ukrt.model.intonation import make_intonation

RATE = 48000.0
FADE = 2048  # frames, as the stage fades


def quiet_response(n_taps=3000, seed=1):
    """A decaying random response (n_taps, 2, 2): enough for partitions of two sizes."""
    noise = np.random.default_rng(seed).standard_normal((n_taps, 2, 2))
    return noise * np.exp(-np.arange(n_taps) / 600.0)[:, None, None]


def instance(guitar, rate=RATE, response=None, intonation=None):
    """An instance at rest: its four arrays, guitar and sample rate."""
    d, i = make_arrays()
    intonation = intonation or make_intonation(guitar)
    fill_instance(d, i, guitar, intonation, rate)
    response = np.zeros((1, 2, 2)) if response is None else response
    n_v, n_vi = convolver_size(len(response))
    v, vi = aligned(n_v, np.float64), aligned(n_vi, np.int64)
    convolver_prepare(response, v, vi)
    i[at.H_CONVOLVE] = 1
    player_reset(d, i)
    make_player_tables(guitar, intonation, rate, d, i)
    return SimpleNamespace(d=d, i=i, v=v, vi=vi, guitar=guitar, rate=rate)


@numba.njit(error_model="numpy")
def _perform_due(d, i, now):
    while timeline_next(i, now + 1) <= now:
        kind, s = i[at.GESTURES_I + 1], i[at.GESTURES_I + 2]
        p = (d[at.GESTURES], d[at.GESTURES + 1], d[at.GESTURES + 2], d[at.GESTURES + 3])
        timeline_drop_first(d, i)
        perform(d, i, kind, s, p[0], p[1], p[2], p[3])


@numba.njit(error_model="numpy")
def _play(d, i, v, vi, now, n_frames, messages, out):
    read, end = 0, now + n_frames
    first = now
    while now < end:
        while read < len(messages) and messages[read, 0] <= now:
            if messages[read, 0] == now:
                player_message(d, i, now, messages[read, 1], messages[read, 2], messages[read, 3])
            read += 1
        if now % at.CHUNK == 0:
            player_tick(d, i, now)
        _perform_due(d, i, now)
        stop = min(end, (now // at.CHUNK + 1) * at.CHUNK)
        if read < len(messages):
            stop = min(stop, messages[read, 0])
        stop = timeline_next(i, stop)
        n = stop - now
        advance(d, i, n)
        convolve_chunk(v, vi, now, n, d, at.BRIDGE, d, at.PRESSURE)
        for k in range(n):
            out[now - first + k, 0] = d[at.BRIDGE + k] + d[at.BRIDGE + at.CHUNK + k]
            out[now - first + k, 1] = d[at.PRESSURE + k]
        now = stop


def play(one, now, n_frames, messages=()):
    """Frames ``now`` to ``now + n_frames`` of an instance; of the messages those that fall there.

    Returns
    -------
    ndarray (n_frames, 2)
        Force on the bridge [N], and the left channel of the convolver's output.
    """
    out = np.empty((n_frames, 2))
    table = np.array(sorted(messages, key=lambda message: message[0]), np.int64).reshape(-1, 4)
    _play(one.d, one.i, one.v, one.vi, now, n_frames, table, out)
    return out


def swap(old, new, now):
    """The new instance takes over what the old one does."""
    transfer_state(old.d, old.i, old.v, old.vi, new.d, new.i, new.v, new.vi, now)


def counters(one):
    return read_counters(one.i)


def note_log(one):
    return read_note_log(one.d, one.i, one.rate)


def crossfade(old, new):
    """From one signal to the other over FADE frames, by a raised cosine; then the other alone."""
    weight = np.ones((len(new), 1))
    weight[:FADE, 0] = 0.5 - 0.5 * np.cos(np.pi * (np.arange(FADE) + 0.5) / FADE)
    mixed = new * weight
    mixed[: len(old)] += old * (1.0 - weight[: len(old)])
    return mixed


def energy_above(signal, hz, rate=RATE):
    """Energy of a signal above a frequency, windowed so that its ends do not count."""
    spectrum = np.fft.rfft(signal * np.hanning(len(signal)))
    return float(np.sum(np.abs(spectrum[np.fft.rfftfreq(len(signal), 1.0 / rate) > hz]) ** 2))
