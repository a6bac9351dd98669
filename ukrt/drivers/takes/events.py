"""Scans the bytes of a take's track: bytes enter, its events at their frames leave, up to wherever they make sense."""

from ukrt.drivers.files.midi_track import DATA_BYTES
from ukrt.drivers.takes.take import END


class CutError(Exception):
    """The take cannot be understood beyond this event; the text says what was found."""


def events(data, at):
    """Yield (tick, status, data1, data2, None) of channel messages and (tick, kind, 0, 0, bytes) of meta events, up to
    and with the end of the track."""
    tick = running = 0
    try:
        while True:
            delta, at = _number(data, at)
            tick += delta
            status = data[at]
            if status >= 0x80:
                at += 1
            elif running:
                status = running
            else:
                raise CutError(f"byte 0x{status:02X} where a status byte must stand")
            if status < 0xF0:
                running, stop = status, at + DATA_BYTES[status]
                data1, data2 = data[at], data[stop - 1] if stop - at == 2 else 0
                if (data1 | data2) >= 0x80:
                    raise CutError(f"byte 0x{max(data1, data2):02X} as data of a message")
                yield tick, status, data1, data2, None
                at = stop
            elif status in (0xF0, 0xF7, 0xFF):
                kind = data[at] if status == 0xFF else status
                size, at = _number(data, at + (status == 0xFF))
                if at + size > len(data):
                    raise CutError("the file ends in the middle of an event")
                yield tick, kind, 0, 0, data[at : at + size]
                if status == 0xFF and kind == END:
                    return
                at += size
            else:
                raise CutError(f"byte 0x{status:02X}, which no MIDI file may hold")
    except IndexError:
        raise CutError("the file ends before the track does") from None


def _number(data, at):
    """A variable-length number of at most four bytes; returns (number, position after it)."""
    value = 0
    for k in range(at, at + 4):
        byte = data[k]
        value = value << 7 | byte & 0x7F
        if byte < 0x80:
            return value, k + 1
    raise CutError("a variable-length number of more than four bytes")


def shown(raw, limit=40):
    """A few characters of what was found, printable."""
    words = raw if isinstance(raw, str) else raw.decode("latin-1")
    words = "".join(letter if letter.isprintable() else "?" for letter in words)
    return words if len(words) <= limit else words[: limit - 3] + "..."
