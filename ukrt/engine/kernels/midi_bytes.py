"""Bytes of a MIDI 1.0 stream enter one by one, messages leave: a compiled parser that any bytes may be given to.

A message leaves as status << 16 | data1 << 8 | data2. It knows running status, real-time bytes anywhere (between the
bytes of a message and inside SysEx too), SysEx of any length over any number of packets, and SysEx that is never ended.
What leaves are channel messages, active sensing (0xFE) and reset (0xFF); clocks, positions and SysEx are passed over.

The state is one word for each stream: status << 8 | (first data byte + 1, or 0); 0 means that data bytes mean nothing.
SysEx needs no state of its own: like every system message it cancels running status, and so its data mean nothing.
"""

from ukrt.engine.kernels.jit import kernel

NO_MESSAGE = -1
ACTIVE_SENSING, RESET = 0xFE, 0xFF


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
        state[at] = byte << 8 if byte < 0xF0 else 0
        return NO_MESSAGE
    status, first = (state[at] >> 8) & 0xFF, (state[at] & 0xFF) - 1
    if status == 0:
        return NO_MESSAGE
    if status >= 0xC0 and status < 0xE0:  # program change and channel pressure: one data byte
        return status << 16 | byte << 8
    if first < 0:
        state[at] = status << 8 | (byte + 1)
        return NO_MESSAGE
    state[at] = status << 8
    return status << 16 | first << 8 | byte
