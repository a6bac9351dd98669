"""Bytes of a MIDI 1.0 stream enter one by one, messages leave: a compiled parser that any bytes may be given to.

A message leaves as status << 16 | data1 << 8 | data2. It knows running status, real-time bytes anywhere (between the
bytes of a message and inside SysEx too), SysEx of any length over any number of packets, and SysEx that is never ended.
What leaves are channel messages, active sensing (0xFE), reset (0xFF), and universal SysEx in pieces as
`stage_layout.py` describes them: at most one for each byte, the last at its end, so one that is aborted means nothing.
Of other SysEx only the piece that says so leaves; clocks and positions are passed over.

The state is one word for each stream: data bytes of a SysEx << 16 | status << 8 | (first data byte + 1, or 0). Status 0
means that data bytes mean nothing; SYSEX_BEGIN that a SysEx has begun, SYSEX_MORE that it is universal.
"""

from ukrt.engine.kernels.jit import kernel
from ukrt.engine.stage_layout import (
    SYSEX_BEGIN,
    SYSEX_BYTES,
    SYSEX_END,
    SYSEX_MORE,
    SYSEX_SKIPPED,
    UNIVERSAL,
)

NO_MESSAGE = -1
ACTIVE_SENSING, RESET = 0xFE, 0xFF
_SKIPPED, _REFUSED = SYSEX_SKIPPED << 16, SYSEX_SKIPPED << 16 | 1 << 8


@kernel
def midi_byte(state, at, byte):
    """Take one byte (0..255) of the stream whose state is ``state[at]``.

    Parameters
    ----------
    state : ndarray int64
        Zero at the beginning.
    at : int
    byte : int

    Returns
    -------
    int
        The message that the byte completes, or `NO_MESSAGE`.
    """
    if byte >= 0xF8:  # real time: may come anywhere and changes nothing, but for reset
        if byte == RESET:
            state[at] = 0
        return byte << 16 if byte >= ACTIVE_SENSING else NO_MESSAGE
    if byte >= 0x80:
        return _status(state, at, byte)
    status, first = (state[at] >> 8) & 0xFF, (state[at] & 0xFF) - 1
    if status == 0:
        return NO_MESSAGE
    if status >= 0xF0:
        return _sysex_data(state, at, status, first, byte)
    if status >= 0xC0 and status < 0xE0:  # program change and channel pressure: one data byte
        return status << 16 | byte << 8
    if first < 0:
        state[at] = status << 8 | (byte + 1)
        return NO_MESSAGE
    state[at] = status << 8
    return status << 16 | first << 8 | byte


@kernel
def _status(state, at, byte):
    """A status byte: it ends a SysEx, properly or not, and begins what comes."""
    status, first = (state[at] >> 8) & 0xFF, (state[at] & 0xFF) - 1
    state[at] = byte << 8 if byte <= SYSEX_BEGIN else 0
    if byte != SYSEX_END:
        return NO_MESSAGE
    if status == SYSEX_MORE:
        return SYSEX_END << 16 | (first << 8 | 1 if first >= 0 else 0)
    return _REFUSED if status == SYSEX_BEGIN and first >= 0 else NO_MESSAGE


@kernel
def _sysex_data(state, at, status, first, byte):
    """A data byte of a SysEx."""
    if first < 0:
        if status == SYSEX_BEGIN and byte < UNIVERSAL:
            state[at] = 0
            return _SKIPPED
        state[at] |= byte + 1
        return NO_MESSAGE
    size = (state[at] >> 16) + 2
    if size > SYSEX_BYTES:
        state[at] = 0
        return _REFUSED
    state[at] = size << 16 | SYSEX_MORE << 8
    return status << 16 | first << 8 | byte
