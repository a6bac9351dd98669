"""The compiled MIDI parser against an oracle that looks at the whole stream at once, and against mido's parser."""

import re

import mido
import numpy as np
from engine.sysex import LONGEST, exclusive, pieces
from engine.sysex import messages as messages_of
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import njit

from ukrt.engine.engine import Engine
from ukrt.engine.kernels.midi_bytes import NO_MESSAGE, midi_byte
from ukrt.engine.stage_layout import AT_ONCE, LANE_JACK
from ukrt.model.presets import load_preset


@njit
def _parse(data, state, words):
    count = 0
    for byte in data:
        word = midi_byte(state, 1, np.int64(byte))
        if word >= 0:
            words[count] = word
            count += 1
    return count


def parse(*packets):
    """The messages of a stream that comes in packets (list of words)."""
    state, found = np.zeros(3, np.int64), []
    for data in packets:
        words = np.zeros(len(data) + 1, np.int64)
        count = _parse(np.frombuffer(bytes(data), np.uint8), state, words)
        found += words[:count].tolist()
    assert state[0] == state[2] == 0
    return found


def oracle(stream):
    """What a stream means: real-time bytes are taken out, the rest is cut where statuses stand, and data counted off;
    of SysEx the pieces.

    Messages are ordered by the place of their last byte.
    """
    found = [(place, stream[place] << 16) for place in range(len(stream)) if stream[place] >= 0xFE]
    start = 0
    for part in stream.split(b"\xff"):  # reset forgets the running status
        places = [k for k in range(len(part)) if part[k] < 0xF8]
        for run in re.finditer(rb"([\x80-\xef])([\x00-\x7f]*)", bytes(part[k] for k in places)):
            status, length = run[1][0], 1 if run[1][0] & 0xE0 == 0xC0 else 2
            for k in range(0, len(run[2]) - length + 1, length):
                first, second = (*run[2][k : k + length], 0)[:2]
                last = start + places[run.start(2) + k + length - 1]
                found.append((last, status << 16 | first << 8 | second))
        for run in re.finditer(rb"\xf0([\x00-\x7f]*)(\xf7?)", bytes(part[k] for k in places)):
            for k, piece in pieces(run[1], ended=bool(run[2])):
                found.append((start + places[run.start(1) + k], word(piece)))
        start += len(part) + 1
    return [word for _, word in sorted(found)]


def word(message):
    status, data1, data2 = message
    return status << 16 | data1 << 8 | data2


STATUS = st.integers(0x80, 0xEF)
DATA = st.integers(0, 0x7F)
SAMPLES = [0x90, 0x40, 0xF0, 0xF7, 0xFE, 0xFF, 0xC1, 0xF2, 0x7E, 0x7F, 0x7F, 0xF0, 0xF7, 0xF4]
UNIVERSAL = st.binary(max_size=2 * LONGEST).map(lambda data: b"\xf0\x7f" + bytes(b & 0x7F for b in data) + b"\xf7\x90")
ANY = st.one_of(st.binary(max_size=400), st.lists(st.sampled_from(SAMPLES)), UNIVERSAL)


@settings(max_examples=500, deadline=None)
@given(ANY.map(bytes))
def test_any_bytes(stream):
    assert parse(stream) == oracle(stream)


@settings(max_examples=200, deadline=None)
@given(st.binary(max_size=200), st.lists(st.integers(0, 200)))
def test_packets_do_not_matter(stream, cuts):
    cuts = [0, *sorted(min(cut, len(stream)) for cut in cuts), len(stream)]
    assert parse(*(stream[a:b] for a, b in zip(cuts, cuts[1:], strict=False))) == parse(stream)


@st.composite
def disturbed(draw):
    """Messages as a cable brings them: (expected words, bytes), with running status, SysEx and real-time bytes."""
    words, stream, running = [], bytearray(), None
    for _ in range(draw(st.integers(0, 30))):
        what = draw(st.integers(0, 5))
        if what == 0:
            body, ended = bytes(draw(st.lists(DATA | st.integers(0x7E, 0x7F), max_size=20))), draw(st.booleans())
            stream += b"\xf0" + body + (b"\xf7" if ended else b"")
            words += [word(piece) for _, piece in pieces(body, ended)]
            running = None
        elif what == 1:
            stream += draw(st.sampled_from([b"\xf1\x10", b"\xf2\x10\x20", b"\xf3\x07", b"\xf6", b"\xf2\x10", b"\xf5"]))
            running = None
        else:
            status = running if running and draw(st.booleans()) else draw(STATUS)
            data = [draw(DATA) for _ in range(1 if status & 0xE0 == 0xC0 else 2)]
            stream += bytes([status] * (status != running or draw(st.booleans())) + data)
            words.append(status << 16 | data[0] << 8 | (*data, 0)[1])
            running = status
        if draw(st.booleans()):  # a clock somewhere, within a message too
            stream.insert(draw(st.integers(0, len(stream))), draw(st.integers(0xF8, 0xFD)))
    return words, bytes(stream)


@settings(max_examples=500, deadline=None)
@given(disturbed())
def test_messages_come_through_whatever_is_between_them(case):
    words, stream = case
    assert parse(stream) == words


MESSAGE = st.one_of(
    st.builds(
        lambda s, a, b: mido.Message.from_bytes([s, a, b]),
        st.integers(0x80, 0xBF) | st.integers(0xE0, 0xEF),
        DATA,
        DATA,
    ),
    st.builds(lambda s, a: mido.Message.from_bytes([s, a]), st.integers(0xC0, 0xDF), DATA),
    st.builds(lambda data: mido.Message("sysex", data=data), st.lists(DATA | st.integers(0x7E, 0x7F), max_size=10)),
    st.sampled_from(
        [mido.Message(n) for n in ("clock", "start", "active_sensing", "tune_request", "songpos", "reset")]
    ),
)


@settings(max_examples=200, deadline=None)
@given(st.lists(MESSAGE, max_size=30))
def test_as_mido_reads_it(messages):
    stream = b"".join(bytes(message.bytes()) for message in messages)
    expected = []
    for message in mido.parse_all(stream):
        status, *data = message.bytes()
        if status == 0xF0:
            expected += [word(piece) for piece in messages_of(bytes(message.bytes()))]
        elif status < 0xF0 or status >= 0xFE:
            expected.append(status << 16 | (*data, 0, 0)[0] << 8 | (*data, 0, 0)[1])
    assert parse(stream) == expected


def test_known_streams():
    assert parse(b"\x90\x40\x7f\x40\x00") == [0x90407F, 0x904000]  # running status
    assert parse(b"\x90\xf8\x40\xf8\x7f") == [0x90407F]
    assert parse(b"\x90\xfe\x40\x7f") == [0xFE0000, 0x90407F]
    assert parse(b"\xf0\x01\xf8\x02", b"\x03", b"\xf7\x40\x7f") == [0xF50000]  # split; then data that mean nothing
    assert parse(b"\xf0\x01\x02\x90\x40\x7f") == [0xF50000, 0x90407F]  # aborted
    assert parse(b"\xf0\x7f\x10\x04\x01\x90\x40\x7f") == [0xF07F10, 0xF40401, 0x90407F]  # no end: nothing acts
    assert parse(b"\xf0\x7e\x7f\xf8\x09", b"\x01\xf7") == [0xF07E7F, 0xF40901, 0xF70000]
    assert parse(b"\xf0\x7f\x01\x02\xf7", b"\xf7\x05") == [0xF07F01, 0xF70201]
    assert parse(exclusive(0x7F, *[5] * LONGEST))[-1] == 0xF70501  # one byte more than fits: the player refuses it
    assert parse(exclusive(0x7F, *[5] * (LONGEST + 1)) + b"\xc0\x01")[-2:] == [0xF50100, 0xC00100]
    assert parse(b"\x90\x40\x80\x40\x00") == [0x804000]  # half a message is given up
    assert parse(b"\x90\xf2\x01\x02\x40\x7f") == []  # song position ends running status
    assert parse(b"\xc0\x05\x06") == [0xC00500, 0xC00600]
    assert parse(b"\x90\x40\x7f\xff\x40\x7f") == [0x90407F, 0xFF0000]
    assert midi_byte(np.zeros(2, np.int64), 0, 0x40) == NO_MESSAGE


def test_a_million_random_bytes_change_only_the_state():
    stream = np.random.default_rng(1).integers(0, 256, 1_000_000).astype(np.uint8).tobytes()
    words = parse(stream)
    assert words == oracle(stream) and len(words) > 100_000
    statuses = [*range(0x80, 0xF0), 0xF0, 0xF4, 0xF5, 0xF7, 0xFE, 0xFF]
    assert {word >> 16 for word in words} <= set(statuses)
    assert all(word & 0x8080 == 0 for word in words)


def test_a_million_random_bytes_leave_no_note_behind():
    """Played through JACK's lane; after pedals up and all notes off on all channels every note has ended."""
    engine = Engine(load_preset("classical"), 48000.0)
    engine.message_cap = 0
    stream, refused = np.random.default_rng(2).integers(0, 256, 1_000_000).astype(np.uint8).tobytes(), 0
    words = parse(stream)
    for k in range(0, len(words), 1000):
        for word in words[k : k + 1000]:
            refused += not engine.send(AT_ONCE, word >> 16, word >> 8, word, LANE_JACK)
        out = engine.process_card(64)
        assert np.isfinite(out).all() and np.abs(out).max() <= 1.0
    assert refused == 0 and engine.counters()["notes_on"] > 10_000
    for channel in range(16):
        for data in ((64, 0), (66, 0), (123, 0)):
            engine.send(AT_ONCE, 0xB0 | channel, *data, LANE_JACK)
    engine.process_card(4800)
    rung = [note for note in engine.note_log() if note["string"] is not None]
    assert len(rung) > 100 and [note for note in rung if note["end_s"] is None] == []
    engine.close()
