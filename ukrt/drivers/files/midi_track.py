"""Scans the events of one track of a MIDI file: bytes enter, a `Track` of channel messages at absolute ticks leaves.

Every number is bounded (variable-length numbers to four bytes, lengths to the bytes that are there), so the time is
proportional to the bytes. Rules of Standard MIDI Files 1.0 (MMA RP-001) that a file breaks are handled as the docstring
of `ukrt.drivers.files.midi` says; what was odd is collected in words.
"""

import unicodedata
from array import array
from dataclasses import dataclass, field

from mido.messages.specs import SPEC_BY_STATUS

MAX_EVENTS = 2_000_000  # in one file: three orders of magnitude beyond a long guitar piece; bounds time and memory
MAX_TEXT = 200  # characters kept of a name

META, END_OF_TRACK, SET_TEMPO, COPYRIGHT, TRACK_NAME = 0xFF, 0x2F, 0x51, 0x02, 0x03
EXCLUSIVE, CONTINUED = 0xF0, 0xF7
# Data bytes after each status byte, from mido's table; it leaves out the undefined messages, which have none.
DATA_BYTES = [
    int(SPEC_BY_STATUS[status]["length"]) - 1 if status in SPEC_BY_STATUS and status != EXCLUSIVE else 0
    for status in range(256)
]


class UnreadableError(Exception):
    """The file cannot be understood at all; the text says what was found and what is legal."""


class BrokenTrackError(Exception):
    """The track cannot be understood beyond this event; the text says what was found and what is legal."""


@dataclass
class Track:
    """The events of one track: channel messages at absolute ticks, tempo changes, names, and what was odd."""

    ticks: array = field(default_factory=lambda: array("q"))
    status: array = field(default_factory=lambda: array("B"))
    data1: array = field(default_factory=lambda: array("B"))
    data2: array = field(default_factory=lambda: array("B"))
    tempos: list = field(default_factory=list)  # (tick, microseconds per quarter note)
    end_tick: int = 0
    n_events: int = 0
    name: str = ""
    copyright: str = ""
    odd: list = field(default_factory=list)
    broken: bool = False
    system_messages: int = 0


def scan_track(data, start, end, max_events=MAX_EVENTS):
    """Scan events up to the end of track, or to ``end`` where there is none.

    Parameters
    ----------
    data : bytes
        The whole file.
    start, end : int
        Where the track's events begin, and the byte they may not pass.
    max_events : int

    Returns
    -------
    track : Track
    stop : int
        Position after the end of track; ``end`` where the track broke off.
    """
    track = Track()
    try:
        stop = _scan_events(track, data, start, end, max_events)
    except BrokenTrackError as broken:
        track.broken, stop = True, end
        track.odd.append(f"breaks off at {track.end_tick} ticks ({broken}) and is played up to there")
    if track.system_messages:
        track.odd.append(f"has {track.system_messages} system message(s), which no file may hold; they are skipped")
    return track, stop


def _scan_events(track, data, at, end, max_events):
    tick, running = 0, 0
    while at < end:
        delta, at = _number(data, at, end)
        tick += delta
        track.n_events += 1
        if track.n_events > max_events:
            raise UnreadableError(f"has more than {MAX_EVENTS} events, the most that is legal here")
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
            at = _channel_message(track, data, at, end, status, tick)
        elif status == META:
            kind, at = (data[at], at + 1) if at < end else (None, at)
            size, at = _number(data, at, end)
            if kind == END_OF_TRACK:
                track.end_tick = tick
                return min(at + size, end)
            at = _meta(track, data, kind, at, _checked(size, end - at), tick)
        elif status in (EXCLUSIVE, CONTINUED):
            size, at = _number(data, at, end)
            at += _checked(size, end - at)
        else:
            track.system_messages += 1
            at += DATA_BYTES[status]
        track.end_tick = tick
    track.odd.append("has no end of track")
    return end


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


def _checked(size, left):
    if size > left:
        raise BrokenTrackError(f"an event of {size} bytes where {left} are left")
    return size


def _channel_message(track, data, at, end, status, tick):
    """Append the channel message whose data bytes stand at ``at``; returns the position after it."""
    stop = at + DATA_BYTES[status]
    if stop > end:
        raise BrokenTrackError("the data end within a message")
    data1 = data[at]
    data2 = data[at + 1] if stop - at == 2 else 0
    if (data1 | data2) >= 0x80:
        found = data1 if data1 >= 0x80 else data2
        raise BrokenTrackError(f"byte 0x{found:02X} as data of message 0x{status:02X}, 0x00 to 0x7F are legal")
    track.ticks.append(tick)
    track.status.append(status)
    track.data1.append(data1)
    track.data2.append(data2)
    return stop


def _meta(track, data, kind, at, size, tick):
    """Act on the meta event whose ``size`` bytes stand at ``at``; returns the position after it."""
    raw = data[at : at + size]
    if kind == SET_TEMPO:
        tempo = int.from_bytes(raw, "big") if size == 3 else 0
        if tempo > 0:
            track.tempos.append((tick, tempo))
        else:
            odd = f"has a tempo of {tempo} microseconds in {size} bytes (legal: above 0, in 3 bytes), which is ignored"
            if odd not in track.odd:
                track.odd.append(odd)
    elif kind == TRACK_NAME and not track.name:
        track.name = _text(raw)
    elif kind == COPYRIGHT and not track.copyright:
        track.copyright = _text(raw)
    return at + size


def _text(raw):
    """Decode a name as UTF-8, else Latin-1; control characters (terminal escapes) become spaces."""
    raw = bytes(raw[: 4 * MAX_TEXT])
    try:
        text = raw.decode("utf-8")
    except UnicodeDecodeError:
        text = raw.decode("latin-1")
    text = "".join(" " if unicodedata.category(letter)[0] in "CZ" else letter for letter in text)
    return " ".join(text.split())[:MAX_TEXT]
