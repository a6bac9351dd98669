"""Universal SysEx as the MIDI specification's tables have it, byte by byte, and the pieces it travels in.

Written from The Complete MIDI 1.0 Detailed Specification (device control, MIDI tuning) and RP-020, not from our code.
"""


def exclusive(*data):
    """A whole SysEx message around its data bytes."""
    assert all(0 <= byte < 0x80 for byte in data)
    return bytes((0xF0, *data, 0xF7))


def fourteen(value):
    """Least significant seven bits first, as device control has it."""
    return value & 0x7F, value >> 7


def master_volume(value, device=0x7F):
    return exclusive(0x7F, device, 0x04, 0x01, *fourteen(value))


def master_fine(value, device=0x7F):
    return exclusive(0x7F, device, 0x04, 0x03, *fourteen(value))


def master_coarse(value, device=0x7F):
    return exclusive(0x7F, device, 0x04, 0x04, 0x00, value)


def general_midi(what):
    """1 GM system on, 2 off, 3 GM2 on."""
    return exclusive(0x7E, 0x7F, 0x09, what)


def frequency(semitones):
    """Three bytes of a frequency in semitones above note 0 (float)."""
    parts = round(semitones * 16384)
    return parts >> 14, parts >> 7 & 0x7F, parts & 0x7F


def note_tuning(changes, *, program=0, bank=None, real_time=True):
    """Single notes: {key: semitones above note 0, or None for no change}."""
    data = []
    for key, semitones in changes.items():
        data += [key, *((0x7F, 0x7F, 0x7F) if semitones is None else frequency(semitones))]
    kind = 0x7F if real_time else 0x7E
    head = (0x02,) if bank is None else (0x07, bank)
    return exclusive(kind, 0x7F, 0x08, *head, program, len(changes), *data)


def _bitmap(channels):
    """Three bytes: channels 15 and 16, 8 to 14, 1 to 7 (here counted from 0)."""
    bits = [sum(1 << (c - low) for c in channels if low <= c < high) for low, high in ((14, 16), (7, 14), (0, 7))]
    return tuple(bits)


def scale_tuning(cents, channels=range(16), *, real_time=True):
    """Twelve whole cents from C on, -64 to 63, one byte each."""
    return exclusive(0x7F if real_time else 0x7E, 0x7F, 0x08, 0x08, *_bitmap(channels), *(c + 64 for c in cents))


def fine_scale_tuning(steps, channels=range(16), *, real_time=True):
    """Twelve values of 14 bits from C on, 8192 in the middle, 100 cents either way; the most significant byte first."""
    data = [byte for step in steps for byte in (step >> 7, step & 0x7F)]
    return exclusive(0x7F if real_time else 0x7E, 0x7F, 0x08, 0x09, *_bitmap(channels), *data)


LONGEST = 516  # data bytes
SKIPPED, REFUSED = (0xF5, 0, 0), (0xF5, 1, 0)


def pieces(data, ended=True):
    """What leaves a parser for the data bytes of a SysEx: list of (data byte that completes it, message); the end
    belongs to the byte after the last."""
    if not data:
        return []
    if data[0] < 0x7E:
        return [(0, SKIPPED)]
    if len(data) == 1:
        return [(1, REFUSED)] if ended else []
    found = [(k + 1, (0xF4 if k else 0xF0, data[k], data[k + 1])) for k in range(0, min(len(data), LONGEST) - 1, 2)]
    if len(data) // 2 * 2 > LONGEST:
        return [*found, (LONGEST + 1, REFUSED)]
    if ended:
        found.append((len(data), (0xF7, data[-1], 1) if len(data) % 2 else (0xF7, 0, 0)))
    return found


def messages(whole):
    """The pieces of a whole SysEx (list of (status, data1, data2))."""
    assert whole[0] == 0xF0 and whole[-1] == 0xF7
    return [message for _, message in pieces(whole[1:-1])]
