"""Builds MIDI files byte by byte for the tests, well-formed or not."""


def number(value):
    """Variable-length number."""
    out = [value & 0x7F]
    while value := value >> 7:
        out.insert(0, value & 0x7F | 0x80)
    return bytes(out)


def chunk(kind, body, size=None):
    return kind + (len(body) if size is None else size).to_bytes(4, "big") + body


def header(midi_format=0, tracks=1, division=96):
    return chunk(b"MThd", b"".join(value.to_bytes(2, "big") for value in (midi_format, tracks, division)))


def event(delta, *data):
    return number(delta) + bytes(data)


def tempo(delta, microseconds):
    return event(delta, 0xFF, 0x51, 3, *microseconds.to_bytes(3, "big"))


def end_of_track(delta=0):
    return event(delta, 0xFF, 0x2F, 0)


def note(key=60, velocity=80, ticks=96, delta=0):
    return event(delta, 0x90, key, velocity) + event(ticks, 0x80, key, 64)


def file(*tracks, midi_format=0, division=96, declared=None):
    """A file of these track bodies."""
    count = len(tracks) if declared is None else declared
    return header(midi_format, count, division) + b"".join(chunk(b"MTrk", body) for body in tracks)
