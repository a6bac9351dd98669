"""What a JACK server tells its clients from threads of its own, noted in words: no interpreter waits there for a lock.

Enter the server's calls; leave numbers in the table of jack_layout.py, looked at by whoever wants to know. A callback
in Python would stop the whole server while some other Python thread computes.
"""

import numpy as np
from numba import types

from ukrt.engine import jack_layout as at
from ukrt.engine.kernels.foreign import bytes_at, c_function, words_at
from ukrt.engine.kernels.jit import entry_point, kernel
from ukrt.engine.kernels.machine import address_of, integers_at, store_release

_latency_range = c_function("void", "pointer", "int", "pointer")  # jack_port_get_ and jack_port_set_latency_range


@entry_point(types.int32(types.voidptr))
def count_up(word):
    """JackXRunCallback: one more in ``word``."""
    count = integers_at(address_of(word), 1)
    count[0] += 1
    return 0


@entry_point(types.int32(types.uint32, types.voidptr))
def note_value(value, word):
    """JackBufferSizeCallback and JackSampleRateCallback: the value into ``word``."""
    integers_at(address_of(word), 1)[0] = np.int64(value)
    return 0


@entry_point(types.void(types.uint32, types.int32, types.voidptr))
def count_port(_port, _registered, word):
    """JackPortRegistrationCallback: one more in ``word``."""
    count = integers_at(address_of(word), 1)
    count[0] += 1


@entry_point(types.void(types.uint32, types.uint32, types.int32, types.voidptr))
def count_connection(_one, _other, _connected, word):
    """JackPortConnectCallback: one more in ``word``."""
    count = integers_at(address_of(word), 1)
    count[0] += 1


@entry_point(types.void(types.int32, types.voidptr, types.voidptr))
def note_shutdown(code, reason, table):
    """JackInfoShutdownCallback: the server is gone, or has thrown us out."""
    base = address_of(table)
    t = integers_at(base, at.TABLE_WORDS)
    t[at.T_SHUTDOWN_CODE] = np.int64(code)
    source = address_of(reason)
    words = bytes_at(base + 8 * at.T_REASON, at.REASON_BYTES)
    given = bytes_at(source, at.REASON_BYTES)
    for k in range(at.REASON_BYTES - 1 if source != 0 else 0):
        if given[k] == 0:
            break
        words[k] = given[k]
    store_release(t, at.T_SHUTDOWN, 1)


@kernel
def _follow(t, base, mode, sources, n_sources, targets, n_targets):
    """Give all targets the latency range that spans those of all sources: nothing is added on the way through us."""
    address = base + 8 * at.T_RANGE
    least_most = words_at(address, 2)
    least, most = np.uint32(0), np.uint32(0)
    for k in range(n_sources):
        _latency_range(t[at.T_GET_RANGE], (t[sources + k], mode, address))
        least = least_most[0] if k == 0 else min(least, least_most[0])
        most = max(most, least_most[1])
    for k in range(n_targets):
        least_most[0], least_most[1] = least, most
        _latency_range(t[at.T_SET_RANGE], (t[targets + k], mode, address))


@entry_point(types.void(types.int32, types.voidptr))
def tell_latency(mode, table):
    """JackLatencyCallback: outputs are as old as the MIDI inputs, MIDI inputs are heard when the outputs are."""
    base = address_of(table)
    t = integers_at(base, at.TABLE_WORDS)
    if mode == at.CAPTURE:
        _follow(t, base, at.CAPTURE, at.T_MIDI, t[at.T_MIDI_PORTS], at.T_AUDIO, t[at.T_CHANNELS])
    else:
        _follow(t, base, at.PLAYBACK, at.T_AUDIO, t[at.T_CHANNELS], at.T_MIDI, t[at.T_MIDI_PORTS])


@entry_point(types.void(types.voidptr))
def say_nothing(_words):
    """JACK's error and information function: what matters arrives as a code."""
