"""The events of one track of a MIDI file: bytes enter, events at absolute ticks leave, up to wherever they make sense.

Every number is bounded (variable-length numbers to four bytes, lengths to the bytes that are there), so the time is
proportional to the bytes.
"""

import os

from mido.messages.specs import SPEC_BY_STATUS

META, END_OF_TRACK = 0xFF, 0x2F
EXCLUSIVE, CONTINUED = 0xF0, 0xF7
# Data bytes after each status byte, from mido's table; it leaves out the undefined messages, which have none.
DATA_BYTES = [
    int(SPEC_BY_STATUS[status]["length"]) - 1 if status in SPEC_BY_STATUS and status != EXCLUSIVE else 0
    for status in range(256)
]


class BrokenTrackError(Exception):
    """The track cannot be understood beyond this event; the text says what was found and what is legal."""


def read_at_most(path, most):
    """The bytes of a file, or one byte more than ``most`` of a larger one.

    There is room for what the file has and not for the most, which a process that locks its memory waits 0.1 s for.
    """
    with path.open("rb") as file:
        return file.read(min(os.fstat(file.fileno()).st_size, most) + 1)


def track_events(data, at, end):
    """The events up to and with the end of track, or to byte ``end`` where there is none.

    Parameters
    ----------
    data : bytes
        The whole file.
    at, end : int
        Where the track's events begin, and the byte they may not pass.

    Yields
    ------
    tick, status, data1, data2 : int
        Of a meta event ``data1`` is its kind.
    raw : bytes or None
        Of meta events and exclusive messages; None for channel messages and, from 0xF1 on, for those that no file may
        hold.
    stop : int
        Position after the event.

    Raises
    ------
    BrokenTrackError
    """
    tick = running = 0
    while at < end:
        delta, at = _number(data, at, end)
        tick += delta
        if at >= end:
            raise BrokenTrackError("an event's first byte is missing")
        status = data[at]
        if status >= 0x80:
            at += 1
        elif running:
            status = running
        else:
            raise BrokenTrackError(f"byte 0x{status:02X} where a status byte, 0x80 to 0xFF, must stand")
        if status < 0xF0:
            running = status
            data1, data2, at = _data_bytes(data, at, end, status)
            yield tick, status, data1, data2, None, at
        elif status in (EXCLUSIVE, CONTINUED, META):
            kind, at = (data[at], at + 1) if status == META and at < end else (0, at)
            size, at = _number(data, at, end)
            if status == META and kind == END_OF_TRACK:
                yield tick, status, kind, 0, b"", min(at + size, end)
                return
            if size > end - at:
                raise BrokenTrackError(f"an event of {size} bytes where {end - at} are left")
            at += size
            yield tick, status, kind, 0, data[at - size : at], at
        else:
            at += DATA_BYTES[status]
            yield tick, status, 0, 0, None, at


def _number(data, at, end):
    """A variable-length number of at most four bytes at ``at``; returns (number, position after it)."""
    value = 0
    for k in range(at, min(at + 4, end)):
        byte = data[k]
        value = value << 7 | byte & 0x7F
        if byte < 0x80:
            return value, k + 1
    if at + 4 <= end:
        raise BrokenTrackError("a variable-length number of more than the legal 4 bytes")
    raise BrokenTrackError("the data end within an event")


def _data_bytes(data, at, end, status):
    """The data bytes of a channel message, 0 for a second one that it has not; and the position after them."""
    stop = at + DATA_BYTES[status]
    if stop > end:
        raise BrokenTrackError("the data end within a message")
    data1 = data[at]
    data2 = data[at + 1] if stop - at == 2 else 0
    if (data1 | data2) >= 0x80:
        found = data1 if data1 >= 0x80 else data2
        raise BrokenTrackError(f"byte 0x{found:02X} as data of message 0x{status:02X}, 0x00 to 0x7F are legal")
    return data1, data2, stop
