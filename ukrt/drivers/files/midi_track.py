"""One track of a MIDI file: bytes enter, a `Track` of channel messages at absolute ticks leaves, universal SysEx in
pieces among them.

Rules of Standard MIDI Files 1.0 (MMA RP-001) that a file breaks are handled as the docstring of
`ukrt.drivers.files.midi` says; what was odd is collected in words.
"""

import unicodedata
from array import array
from dataclasses import dataclass, field

from ukrt.drivers.files.midi_events import END_OF_TRACK, EXCLUSIVE, META, BrokenTrackError, track_events
from ukrt.drivers.midi.stream import MidiStream

MAX_EVENTS = 2_000_000  # in one file: three orders of magnitude beyond a long guitar piece; bounds time and memory
MAX_TEXT = 200  # characters kept of a name

COPYRIGHT, TRACK_NAME, MARKER, CUE_POINT = 0x02, 0x03, 0x06, 0x07
SET_TEMPO, TIME_SIGNATURE, KEY_SIGNATURE = 0x51, 0x58, 0x59
MAX_DENOMINATOR_POWER = 6  # 64ths: shorter beats are no music


class UnreadableError(Exception):
    """The file cannot be understood at all; the text says what was found and what is legal."""


@dataclass
class Track:
    """The events of one track: channel messages at absolute ticks, changes of tempo, time and key, markers, names, and
    what was odd."""

    ticks: array = field(default_factory=lambda: array("q"))
    status: array = field(default_factory=lambda: array("B"))
    data1: array = field(default_factory=lambda: array("B"))
    data2: array = field(default_factory=lambda: array("B"))
    tempos: list = field(default_factory=list)  # (tick, microseconds per quarter note)
    signatures: list = field(default_factory=list)  # (tick, numerator, denominator)
    keys: list = field(default_factory=list)  # (tick, fifths)
    markers: list = field(default_factory=list)  # (tick, text) of markers and cue points
    end_tick: int = 0
    n_events: int = 0
    name: str = ""
    copyright: str = ""
    odd: list = field(default_factory=list)
    broken: bool = False
    system_messages: int = 0
    stream: MidiStream = field(default_factory=MidiStream)  # of exclusive messages, which may come in packets


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
    for tick, status, data1, data2, raw, stop in track_events(data, at, end):
        track.n_events += 1
        if track.n_events > max_events:
            raise UnreadableError(f"has more than {MAX_EVENTS} events, the most that is legal here")
        track.end_tick = tick
        if status < 0xF0:
            _append(track, tick, status, data1, data2)
        elif raw is None:
            track.system_messages += 1
        elif status == META:
            if data1 == END_OF_TRACK:
                return stop
            _meta(track, data1, raw, tick)
        else:
            _exclusive(track, status, raw, tick)
    track.odd.append("has no end of track")
    return end


def _append(track, tick, status, data1, data2):
    track.ticks.append(tick)
    track.status.append(status)
    track.data1.append(data1)
    track.data2.append(data2)


def _exclusive(track, status, raw, tick):
    """A SysEx, its first packet, or (F7) one that continues it; of bytes to be sent as they are nothing else is played.
    """
    for message in track.stream.feed(bytes([EXCLUSIVE]) + raw if status == EXCLUSIVE else raw):
        if EXCLUSIVE <= message.status < 0xF8:
            _append(track, tick, *message)


def _meta(track, kind, raw, tick):
    """Act on a meta event."""
    if kind == SET_TEMPO:
        _tempo(track, raw, tick)
    elif kind == TIME_SIGNATURE:
        _signature(track, raw, tick)
    elif kind == KEY_SIGNATURE and len(raw) == 2 and abs(fifths := int.from_bytes(raw[:1], signed=True)) <= 7:
        track.keys.append((tick, fifths))
    elif kind in (MARKER, CUE_POINT) and (name := _text(raw)):
        track.markers.append((tick, name))
    elif kind == TRACK_NAME and not track.name:
        track.name = _text(raw)
    elif kind == COPYRIGHT and not track.copyright:
        track.copyright = _text(raw)


def _tempo(track, raw, tick):
    tempo = int.from_bytes(raw, "big") if len(raw) == 3 else 0
    if tempo > 0:
        track.tempos.append((tick, tempo))
    else:
        found = f"a tempo of {tempo} microseconds in {len(raw)} bytes (legal: above 0, in 3 bytes)"
        _ignored(track, found)


def _signature(track, raw, tick):
    numerator, power = (raw[0], raw[1]) if len(raw) >= 2 else (0, 0)
    if numerator > 0 and power <= MAX_DENOMINATOR_POWER:
        track.signatures.append((tick, numerator, 1 << power))
    else:
        _ignored(track, f"a time signature of {numerator}/2^{power} (legal: above 0, over 1 to 64)")


def _ignored(track, found):
    """Tell once of something that is passed over."""
    odd = f"has {found}, which is ignored"
    if odd not in track.odd:
        track.odd.append(odd)


def _text(raw):
    """Decode a name as UTF-8, else Latin-1; control characters (terminal escapes) become spaces."""
    raw = bytes(raw[: 4 * MAX_TEXT])
    try:
        text = raw.decode("utf-8")
    except UnicodeDecodeError:
        text = raw.decode("latin-1")
    text = "".join(" " if unicodedata.category(letter)[0] in "CZ" else letter for letter in text)
    return " ".join(text.split())[:MAX_TEXT]
