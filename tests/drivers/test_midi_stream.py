"""The parser of MIDI bytes against an oracle of another kind, and the cases that real cables bring."""

import re

import mido
import numpy as np
import pytest
from engine.sysex import LONGEST, SKIPPED, pieces
from hypothesis import given, settings
from hypothesis import strategies as st

from ukrt.drivers.midi.stream import MidiStream

# What may stand in a stream without real-time bytes: a status with its data or something that cancels it.
_CHANNEL = re.compile(rb"([\x80-\xef])([\x00-\x7f]*)")
_EXCLUSIVE = re.compile(rb"\xf0([\x00-\x7f]*)(\xf7?)")
_COMMON = [0x90, 0xC3, 0xF0, 0xF7, 0xF8, 0xFE, 0xFF, 0x40, 0x7F, 0x7E, 0xF4]
_any_bytes = st.lists(st.integers(0, 255) | st.sampled_from(_COMMON))


def oracle(data):
    """Messages of a whole stream by regular expressions, in order of the byte that completes them."""
    found = [(at, (byte, 0, 0)) for at, byte in enumerate(data) if byte >= 0xFE]
    for start, part in _parts(data):
        places = [start + k for k, byte in enumerate(part) if byte < 0xF8]
        plain = bytes(byte for byte in part if byte < 0xF8)
        for match in _CHANNEL.finditer(plain):
            status, first = match.group(1)[0], match.start(2)
            width = 1 if status & 0xE0 == 0xC0 else 2
            for k in range(first, match.end(2) - width + 1, width):
                message = (status, *plain[k : k + width], 0)[:3]
                found.append((places[k + width - 1], message))
        for match in _EXCLUSIVE.finditer(plain):
            for k, message in pieces(match[1], ended=bool(match[2])):
                found.append((places[match.start(1) + k], message))
    return [message for _, message in sorted(found)]


def _parts(data):
    """The stretches between resets, after which nothing of before counts."""
    start = 0
    for part in re.split(b"\xff", bytes(data)):
        yield start, part
        start += len(part) + 1


def parse(*packets):
    stream = MidiStream()
    return [tuple(message) for packet in packets for message in stream.feed(packet)]


@given(_any_bytes, st.lists(st.integers(1, 5), min_size=1))
def test_any_bytes_in_any_packets(data, sizes):
    packets, rest = [], data
    while rest:
        size = sizes[len(packets) % len(sizes)]
        packets.append(rest[:size])
        rest = rest[size:]
    assert parse(*packets) == oracle(data) == parse(data) == parse(*([byte] for byte in data))


def _universal(data):
    return b"\xf0\x7e" + bytes(byte & 0x7F for byte in data) + b"\xf7\x90\x40\x40"


@settings(deadline=None)  # the first example compiles
@given(st.one_of(st.binary(max_size=400), st.binary(min_size=LONGEST - 9, max_size=LONGEST + 9).map(_universal)))
def test_the_compiled_parser_finds_the_same(data):
    from ukrt.engine.kernels.midi_bytes import NO_MESSAGE, midi_byte

    state = np.zeros(1, np.int64)
    words = [word for word in (midi_byte(state, 0, byte) for byte in data) if word != NO_MESSAGE]
    assert [(word >> 16, word >> 8 & 0xFF, word & 0xFF) for word in words] == parse(data)


@given(st.binary(max_size=400))
def test_agrees_with_mido_where_mido_needs_no_running_status(data):
    messages = [m for m in mido.parse_all(data) if m.type not in ("sysex", "clock", "start", "stop", "continue")]
    expected = [(*m.bytes(), 0, 0)[:3] for m in messages if 0x80 <= m.bytes()[0] < 0xF0]
    whole = [byte for message in expected for byte in message[: 2 if message[0] & 0xE0 == 0xC0 else 3]]
    assert parse(whole) == expected


@pytest.mark.parametrize(
    ("packets", "expected"),
    [
        ([[0x90, 60, 100, 62, 101, 60, 0]], [(0x90, 60, 100), (0x90, 62, 101), (0x90, 60, 0)]),
        ([[0x90, 0xF8, 60, 0xFE, 100]], [(0xFE, 0, 0), (0x90, 60, 100)]),
        ([[0xF0, 1, 2], [3, 0xF8, 4], [5, 0xF7, 0x80, 60, 0]], [SKIPPED, (0x80, 60, 0)]),
        ([[0xF0, 0x7F, 2], [3, 0xF8, 4], [5, 0xF7]], [(0xF0, 0x7F, 2), (0xF4, 3, 4), (0xF7, 5, 1)]),
        ([[0xF0, 1, 2, 0x90, 60, 100]], [SKIPPED, (0x90, 60, 100)]),
        ([[0x90, 60], [0xB0, 64, 127]], [(0xB0, 64, 127)]),
        ([[0x90, 60, 100, 0xF1, 5, 60, 100]], [(0x90, 60, 100)]),
        ([[0x90, 60, 100, 0xFF, 60, 100]], [(0x90, 60, 100), (0xFF, 0, 0)]),
        ([[0xC2, 5, 6], [0xD2, 7]], [(0xC2, 5, 0), (0xC2, 6, 0), (0xD2, 7, 0)]),
        ([[], [1, 2, 3], [0xF7]], []),
    ],
    ids=["running", "real-time", "sysex", "universal", "aborted-sysex", "cut", "common", "reset", "one-byte", "stray"],
)
def test_what_cables_bring(packets, expected):
    assert parse(*packets) == expected


def test_a_long_sysex_leaves_the_stream_ready():
    assert parse([0xF0, *[1] * 100_000], [2] * 100_000, [0xF7, 0x90, 60, 1]) == [SKIPPED, (0x90, 60, 1)]
    found = parse([0xF0, *[127] * 100_000], [2] * 100_000, [0xF7, 0x90, 60, 1])
    assert len(found) == LONGEST // 2 + 2 and found[-2:] == [(0xF5, 1, 0), (0x90, 60, 1)]
