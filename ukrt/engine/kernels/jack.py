"""JACK's process callback: one cycle's MIDI events enter, the same cycle's sound leaves, without the interpreter.

An event at frame t of the cycle is played at the stage's frame + t, and the sound of just these frames goes back in the
same cycle: nothing adds delay or jitter. The engine is called through its C function's address, so that this file
compiles in a moment and whatever hosts the engine has the same machine code compute the sound.
"""

import numpy as np
from numba import types

from ukrt.engine import jack_layout as at
from ukrt.engine import stage_layout as stage
from ukrt.engine.kernels.foreign import bytes_at, c_function, words_at
from ukrt.engine.kernels.jit import entry_point, kernel
from ukrt.engine.kernels.machine import address_of, integers_at, load_acquire, singles_at, store_release
from ukrt.engine.kernels.midi_bytes import midi_byte
from ukrt.engine.kernels.queue import lane_push
from ukrt.engine.map_layout import DROPPED, mapped

_port_get_buffer = c_function("pointer", "pointer", "int")
_midi_count = c_function("int", "pointer")  # jack_midi_get_event_count, jack_midi_get_lost_event_count
_midi_event_get = c_function("int", "pointer", "pointer", "int")
_last_frame_time = c_function("int", "pointer")
_transport_query = c_function("int", "pointer", "pointer")
_compute = c_function("int", "pointer", "pointer", "long", "pointer", "long", "pointer")
_UINT32 = 0xFFFFFFFF
_mapped = kernel(mapped)
_UNMAPPED = stage.LANE_REFUSED + stage.LANE_STEP * stage.LANE_JACK + stage.LANE_UNMAPPED


@kernel
def _load_event(t, address, p):
    """Fetch the next event of MIDI input ``p``; an input without any is done with."""
    event = address + 8 * (at.T_EVENT + at.EVENT_WORDS * p)
    while t[at.T_NEXT + p] < t[at.T_COUNT + p]:
        if _midi_event_get(t[at.T_EVENT_GET], (event, t[at.T_BUFFER + p], t[at.T_NEXT + p])) == 0:
            return
        t[at.T_NEXT + p] += 1


@kernel
def _open_inputs(t, address, n_frames):
    """Look at every MIDI input's buffer of this cycle."""
    for p in range(t[at.T_MIDI_PORTS]):
        buffer = _port_get_buffer(t[at.T_GET_BUFFER], (t[at.T_MIDI + p], n_frames))
        t[at.T_BUFFER + p], t[at.T_NEXT + p], t[at.T_COUNT + p] = buffer, 0, 0
        if buffer != 0:
            t[at.T_COUNT + p] = _midi_count(t[at.T_EVENT_COUNT], (buffer,))
            t[at.T_LOST] += _midi_count(t[at.T_LOST_COUNT], (buffer,))
        _load_event(t, address, p)


@kernel
def _earliest(t):
    """The MIDI input whose next event comes first, the lower number at equal times; -1 when all are read."""
    found, first = -1, 0
    for p in range(t[at.T_MIDI_PORTS]):
        if t[at.T_NEXT + p] < t[at.T_COUNT + p]:
            time = t[at.T_EVENT + at.EVENT_WORDS * p + at.EVENT_TIME] & _UINT32
            if found < 0 or time < first:
                found, first = p, time
    return found


@kernel
def _note_held(t, word):
    """Keep in mind which keys and pedals are down, whoever holds them."""
    kind, first, second = (word >> 16) & 0xF0, (word >> 8) & 0x7F, word & 0x7F
    held = at.T_HELD + at.HELD_WORDS * ((word >> 16) & 0x0F)
    if kind == 0x80 or kind == 0x90:
        bit = np.int64(1) << (first & 63)
        if kind == 0x90 and second > 0:
            t[held + (first >> 6)] |= bit
        else:
            t[held + (first >> 6)] &= ~bit
    elif kind == 0xB0 and at.FIRST_PEDAL <= first < at.FIRST_PEDAL + at.PEDALS:
        bit = np.int64(1) << (first - at.FIRST_PEDAL)
        if second >= 64:
            t[held + at.HELD_PEDALS] |= bit
        else:
            t[held + at.HELD_PEDALS] &= ~bit


@kernel
def _end_held(t, si):
    """Let go of all keys and pedals that are down: whoever held them has gone."""
    frame = si[stage.G_FRAME]
    for channel in range(16):
        held = at.T_HELD + at.HELD_WORDS * channel
        for k in range(at.PEDALS):
            if (t[held + at.HELD_PEDALS] >> k) & 1:
                lane_push(si, stage.LANE_JACK, frame, (0xB0 | channel) << 16 | (at.FIRST_PEDAL + k) << 8)
        for key in range(128):
            if (t[held + (key >> 6)] >> (key & 63)) & 1:
                lane_push(si, stage.LANE_JACK, frame, (0x80 | channel) << 16 | key << 8)
        t[held] = t[held + 1] = t[held + at.HELD_PEDALS] = 0


@kernel
def take_events(t, address, si, n_frames):
    """Queue the messages of all events of the cycle, each at its frame, those of several inputs in order."""
    _open_inputs(t, address, n_frames)
    wishes = load_acquire(t, at.T_END_HELD)
    if wishes != t[at.T_ENDED]:
        _end_held(t, si)
        t[at.T_ENDED] = wishes
    offset, p = 0, _earliest(t)
    while p >= 0:
        event = at.T_EVENT + at.EVENT_WORDS * p
        offset = max(offset, min(t[event + at.EVENT_TIME] & _UINT32, n_frames - 1))
        size = t[event + at.EVENT_SIZE]
        data = bytes_at(t[event + at.EVENT_BYTES], size)
        for k in range(size):
            word = midi_byte(t, at.T_PARSER + p, np.int64(data[k]))
            if word < 0:
                continue
            meant = _mapped(si, word)
            if meant == DROPPED:
                si[_UNMAPPED] += 1
            elif lane_push(si, stage.LANE_JACK, si[stage.G_FRAME] + offset, meant):
                t[at.T_MESSAGES] += 1
                _note_held(t, meant)
        t[at.T_EVENTS] += 1
        t[at.T_NEXT + p] += 1
        _load_event(t, address, p)
        p = _earliest(t)


@kernel
def _publish_transport(t, address, frame):
    """Note where the transport and the stage stood at the start of this cycle."""
    position = address + 8 * at.T_POSITION
    state = _transport_query(t[at.T_TRANSPORT], (t[at.T_CLIENT], position))
    sequence = t[at.T_POSITION_SEQ]
    store_release(t, at.T_POSITION_SEQ, sequence + 1)
    store_release(t, at.T_POSITION_STATE, state)
    store_release(t, at.T_POSITION_AT, np.int64(words_at(position + at.POSITION_FRAME, 1)[0]))
    store_release(t, at.T_POSITION_ENGINE, frame)
    store_release(t, at.T_POSITION_SEQ, sequence + 2)


@kernel
def _watch_time(t, n_frames):
    """Count the frames that the server went on without this callback."""
    now = _last_frame_time(t[at.T_CYCLE_TIME], (t[at.T_CLIENT],))
    ahead = (now - t[at.T_NEXT_TIME]) & _UINT32
    if t[at.T_PERIOD] == n_frames and ahead < 1 << 31:  # with a new period, or if it goes back, time begins anew
        t[at.T_MISSED] += ahead
    t[at.T_NEXT_TIME], t[at.T_PERIOD] = (now + n_frames) & _UINT32, n_frames


@kernel
def _give(t, scratch, done, n, n_frames):
    """Interleaved samples to the ports' buffers from frame ``done`` on; without ``scratch`` silence."""
    channels = t[at.T_CHANNELS]
    for c in range(channels):
        buffer = _port_get_buffer(t[at.T_GET_BUFFER], (t[at.T_AUDIO + c], n_frames))
        if buffer == 0:
            continue
        out = singles_at(buffer + 4 * done, n)
        if scratch == 0:
            for k in range(n):
                out[k] = np.float32(0.0)
        else:
            samples = singles_at(scratch, n * channels)
            for k in range(n):
                out[k] = samples[k * channels + c]


@kernel
def _play(t, n_frames):
    """Let the engine compute the cycle, in as few calls as its scratch allows."""
    done = 0
    while done < n_frames:
        n = min(at.SCRATCH_FRAMES, n_frames - done)
        if _compute(t[at.T_CALLBACK], (0, t[at.T_SCRATCH], n, 0, 0, t[at.T_USERDATA])) != 0:
            t[at.T_FAILED] += 1
            _give(t, 0, done, n_frames - done, n_frames)
            return
        _give(t, t[at.T_SCRATCH], done, n, n_frames)
        done += n


@entry_point(types.int32(types.uint32, types.voidptr))
def process(n_frames, table):
    """JackProcessCallback; ``table`` is that of jack_layout.py. Always 0: anything else would end the client."""
    address, frames = address_of(table), np.int64(n_frames)
    t = integers_at(address, at.TABLE_WORDS)
    if t[at.T_MAGIC] != at.J_MAGIC or frames == 0:
        return 0
    _watch_time(t, frames)
    host = integers_at(t[at.T_USERDATA], stage.WORDS)
    if t[at.T_CALLBACK] == 0 or t[at.T_RATE] != t[at.T_RATE_NOW]:
        _give(t, 0, 0, frames, frames)
    elif host[stage.W_MAGIC] != stage.MAGIC:
        t[at.T_FAILED] += 1
        _give(t, 0, 0, frames, frames)
    else:
        si = integers_at(host[stage.W_SI], stage.SI_SIZE)
        _publish_transport(t, address, si[stage.G_FRAME])
        take_events(t, address, si, frames)
        _play(t, frames)
    t[at.T_FRAMES] += frames
    store_release(t, at.T_CYCLES, t[at.T_CYCLES] + 1)
    return 0
