"""JACK's process callback without a server: libjack's functions and the engine are replaced by Python ones."""

import ctypes
import pathlib
import pickle

import numpy as np
import pytest

from ukrt.drivers.jack.table import held_messages
from ukrt.engine import jack_layout as at
from ukrt.engine import stage_layout as stage
from ukrt.engine.kernel_cache import cache_folder
from ukrt.engine.kernels import jack, jack_notices
from ukrt.engine.map_layout import DROPPED, PRESSURE_SOURCE, map_entry

POINTER, UINT, ULONG = ctypes.c_void_p, ctypes.c_uint32, ctypes.c_ulong
PROCESS = ctypes.CFUNCTYPE(ctypes.c_int, UINT, POINTER)
ENGINE = ctypes.CFUNCTYPE(ctypes.c_int, POINTER, POINTER, ULONG, POINTER, ULONG, POINTER)
FORBIDDEN = (b"NRT_MemInfo_alloc", b"NRT_Allocate", b"NRT_MemInfo_new", b"\0malloc\0", b"\0calloc\0", b"PyGILState")


class Event(ctypes.Structure):
    """jack_midi_event_t"""

    _fields_ = [("time", UINT), ("size", ctypes.c_size_t), ("buffer", POINTER)]


class FakeServer:
    """Ports are numbers: audio 1.., MIDI 101..; the engine writes its own frame number, negated on channel 1."""

    def __init__(self, channels=2, midi_inputs=1):
        self.channels, self.n_frames, self.time, self.transport = channels, 0, 1000, (1, 0)
        self.audio, self.events, self.calls, self.lost, self.answer = {}, {}, [], 0, 0
        self.si = np.zeros(stage.SI_SIZE, np.int64)
        self.words = np.zeros(stage.WORDS, np.int64)
        self.words[stage.W_MAGIC] = stage.MAGIC
        self.words[stage.W_SI] = self.si.ctypes.data
        self.scratch = np.zeros(at.SCRATCH_FRAMES * channels, np.float32)
        self.table = t = np.zeros(at.TABLE_WORDS, np.int64)
        self.kept = {
            at.T_GET_BUFFER: ctypes.CFUNCTYPE(POINTER, POINTER, UINT)(self.get_buffer),
            at.T_EVENT_COUNT: ctypes.CFUNCTYPE(UINT, POINTER)(lambda port: len(self.events.get(port, []))),
            at.T_EVENT_GET: ctypes.CFUNCTYPE(ctypes.c_int, POINTER, POINTER, UINT)(self.get_event),
            at.T_LOST_COUNT: ctypes.CFUNCTYPE(UINT, POINTER)(lambda _port: self.lost),
            at.T_CYCLE_TIME: ctypes.CFUNCTYPE(UINT, POINTER)(lambda _client: self.time & 0xFFFFFFFF),
            at.T_TRANSPORT: ctypes.CFUNCTYPE(ctypes.c_int, POINTER, POINTER)(self.query),
            at.T_CALLBACK: ENGINE(self.compute),
        }
        for word, function in self.kept.items():
            t[word] = ctypes.cast(function, POINTER).value
        t[at.T_USERDATA], t[at.T_SCRATCH] = self.words.ctypes.data, self.scratch.ctypes.data
        t[at.T_CHANNELS], t[at.T_MIDI_PORTS] = channels, midi_inputs
        t[at.T_AUDIO : at.T_AUDIO + channels] = 1 + np.arange(channels)
        t[at.T_MIDI : at.T_MIDI + midi_inputs] = 101 + np.arange(midi_inputs)
        t[at.T_RATE] = t[at.T_RATE_NOW] = 48000
        t[at.T_MAGIC] = at.J_MAGIC

    def get_buffer(self, port, n_frames):
        assert n_frames == self.n_frames
        return port if port > 100 else self.audio[port].ctypes.data

    def get_event(self, event, port, index):
        time, data = self.events[port][index]
        if data is None:
            return 61  # ENODATA
        self.raw = [*getattr(self, "raw", []), ctypes.create_string_buffer(data, len(data))]
        ctypes.cast(event, ctypes.POINTER(Event))[0] = Event(time, len(data), ctypes.addressof(self.raw[-1]))
        return 0

    def query(self, _client, position):
        ctypes.cast(position + at.POSITION_FRAME, ctypes.POINTER(UINT))[0] = self.transport[1]
        return self.transport[0]

    def compute(self, _input, output, n_frames, _time, flags, userdata):
        assert userdata == self.words.ctypes.data and flags == 0
        self.calls.append(n_frames)
        frame = int(self.si[stage.G_FRAME])
        out = np.ctypeslib.as_array(ctypes.cast(output, ctypes.POINTER(ctypes.c_float)), (n_frames, self.channels))
        out[:] = np.arange(frame, frame + n_frames)[:, None] * np.where(np.arange(self.channels) % 2, -1.0, 1.0)
        self.si[stage.G_FRAME] += n_frames
        return self.answer

    def cycle(self, n_frames, *events):
        """One cycle with events [(time, bytes)] for each MIDI input; returns (channels, n_frames)."""
        self.n_frames = n_frames
        self.events = {101 + k: list(list_) for k, list_ in enumerate(events)}
        self.audio = {1 + c: np.full(n_frames, np.nan, np.float32) for c in range(self.channels)}
        assert PROCESS(jack.process.address)(n_frames, self.table.ctypes.data) == 0
        self.time += n_frames
        return np.array(list(self.audio.values()))

    def queued(self):
        """What has come into JACK's lane since the last call: (frame, word)."""
        lane, step = stage.LANE_JACK, stage.LANE_STEP
        read, write = (self.si[w + step * lane] for w in (stage.LANE_READ, stage.LANE_WRITE))
        slots = [stage.QUEUES + stage.LANE_SIZE * lane + 2 * (k % stage.QUEUE) for k in range(read, write)]
        self.si[stage.LANE_READ + step * lane] = write
        return [(int(self.si[s]), int(self.si[s + 1])) for s in slots]


@pytest.mark.parametrize("channels", [1, 2, 6])
def test_sound_reaches_the_ports_whatever_the_period(channels):
    server, frame = FakeServer(channels), 0
    for n in (64, 1, 17, 2027, 0, at.SCRATCH_FRAMES, at.SCRATCH_FRAMES + 1, 3 * at.SCRATCH_FRAMES + 5, 128):
        expected = np.arange(frame, frame + n)[None] * np.where(np.arange(channels) % 2, -1.0, 1.0)[:, None]
        assert np.array_equal(server.cycle(n), expected.astype(np.float32))
        frame += n
    assert server.table[at.T_FRAMES] == frame == server.si[stage.G_FRAME]
    assert max(server.calls) <= at.SCRATCH_FRAMES and len(server.calls) == 1 * 6 + 2 + 4
    assert server.table[at.T_MISSED] == 0


def test_events_are_queued_at_their_frames():
    server = FakeServer()
    server.cycle(128)
    server.cycle(128, [(0, b"\x90\x40\x50"), (5, b"\xf8"), (100, b"\x80\x40"), (101, b"\x00\xc0\x01"), (9999, b"\xfe")])
    assert server.queued() == [(128, 0x904050), (229, 0x804000), (229, 0xC00100), (255, 0xFE0000)]
    assert server.table[at.T_EVENTS] == 5 and server.table[at.T_MESSAGES] == 4
    server.cycle(64, [(3, b"\x02")])  # running status goes on
    assert server.queued() == [(259, 0xC00200)]


def test_several_inputs_are_merged_in_order_each_with_its_own_stream():
    server = FakeServer(midi_inputs=3)
    one = [(1, b"\x90\x40"), (7, None), (9, b"\x41")]
    two = [(0, b"\x91\x30\x31"), (9, b"\x32\x33")]
    server.cycle(32, one, two, [(4, b"\xf0\x01\x02"), (4, b"\x03")])
    assert server.queued() == [(0, 0x913031), (4, 0xF50000), (9, 0x904041), (9, 0x913233)]


def test_universal_sysex_comes_in_pieces_over_cycles_and_its_end_acts():
    server = FakeServer(midi_inputs=2)
    server.cycle(32, [(1, b"\xf0\x7f\x7f\x04")], [(2, b"\x90\x40\x50")])
    server.cycle(32, [(3, b"\x01\x05\xf8\x06"), (7, b"\xf7\xc0\x01")], [(5, b"\x41\x50")])
    first, second = [(1, 0xF07F7F), (2, 0x904050)], [(35, 0xF40401), (35, 0xF40506), (37, 0x904150)]
    assert server.queued() == [*first, *second, (39, 0xF70000), (39, 0xC00100)]


def test_frames_in_the_lane_never_go_back():
    server = FakeServer()
    server.cycle(32, [(20, b"\x90\x40\x50"), (3, b"\x90\x41\x50")])
    assert [frame for frame, _ in server.queued()] == [20, 20]


def test_what_is_held_is_let_go_once_when_that_is_wished():
    server = FakeServer()
    held = [b"\x90\x40\x50", b"\x9f\x00\x01", b"\x9f\x7f\x01", b"\xb3\x40\x7f", b"\xb3\x45\x40"]
    over = [b"\x90\x41\x50\x41\x00", b"\x91\x20\x50", b"\x81\x20\x00", b"\xb0\x40\x40\x40\x3f", b"\xb0\x46\x7f"]
    server.cycle(64, [(0, data) for data in held + over])
    server.queued()
    ends = {0x804000, 0x8F0000, 0x8F7F00, 0xB34000, 0xB34500}
    assert {s << 16 | a << 8 | b for s, a, b in held_messages(server.table)} == ends
    server.table[at.T_END_HELD] += 1
    server.cycle(64, [(0, b"\x90\x42\x50")])
    queued = server.queued()
    assert {word for _, word in queued[:-1]} == ends and len(queued) == 6
    assert queued[-1] == (64, 0x904250) and {frame for frame, _ in queued} == {64}
    server.cycle(64)
    assert server.queued() == []
    server.table[at.T_END_HELD] += 2
    server.cycle(64)
    assert server.queued() == [(192, 0x804200)]


def test_controllers_mean_what_the_map_says_and_are_held_as_that():
    server = FakeServer()
    server.si[stage.G_MAP] = 2
    table = server.si[stage.MAPS + stage.MAP_SIZE :][: stage.MAP_SIZE].reshape(16, stage.MAP_SOURCES)
    table[3, 30], table[:, 7], table[3, PRESSURE_SOURCE] = map_entry(64, 0, 127), DROPPED, map_entry(1, 20, 0, 9)
    server.cycle(64, [(0, b"\xb3\x1e\x7f\x07\x10"), (1, b"\xb2\x1e\x7f"), (2, b"\xd3\x7f\x00"), (3, b"\x93\x40\x01")])
    assert [word for _, word in server.queued()] == [0xB3407F, 0xB21E7F, 0xB90100, 0xB90114, 0x934001]
    assert held_messages(server.table) == [(0xB3, 64, 0), (0x83, 64, 0)]
    assert server.si[stage.LANE_REFUSED + stage.LANE_STEP * stage.LANE_JACK + stage.LANE_UNMAPPED] == 1


def test_a_full_lane_refuses_and_counts():
    server = FakeServer()
    for _ in range(200):
        server.cycle(64, [(0, b"\xb0\x01\x02" * 100)])
    refused = server.si[stage.LANE_REFUSED + stage.LANE_STEP * stage.LANE_JACK + stage.CLASS_OTHER]
    assert server.table[at.T_MESSAGES] == stage.ROOM[stage.CLASS_OTHER] == len(server.queued())
    assert refused == 20000 - stage.ROOM[stage.CLASS_OTHER]


def test_silence_without_an_engine_at_another_rate_or_when_it_refuses():
    server = FakeServer()
    callback, server.table[at.T_CALLBACK] = server.table[at.T_CALLBACK], 0
    assert not server.cycle(64, [(0, b"\x90\x40\x50")]).any() and server.queued() == []
    server.table[at.T_CALLBACK], server.table[at.T_RATE_NOW] = callback, 44100
    assert not server.cycle(64).any() and server.calls == []
    server.table[at.T_RATE_NOW], server.answer = 48000, 2
    assert not server.cycle(64).any() and server.table[at.T_FAILED] == 1
    server.answer, server.words[stage.W_MAGIC] = 0, 0  # the engine has been closed, its memory may be gone
    calls = len(server.calls)
    assert not server.cycle(64).any() and server.table[at.T_FAILED] == 2 and len(server.calls) == calls
    server.table[at.T_MAGIC] = 0
    assert np.isnan(server.cycle(64)).all()  # nothing is touched any more


def test_missed_cycles_lost_events_and_the_transport_are_noted():
    server = FakeServer()
    server.time = 2**32 - 100
    server.cycle(64)
    server.transport, server.lost = (0, 777), 3
    server.time += 192
    server.cycle(64)
    t = server.table
    assert (t[at.T_MISSED], t[at.T_LOST]) == (192, 3)
    assert [t[k] for k in (at.T_POSITION_STATE, at.T_POSITION_AT, at.T_POSITION_ENGINE)] == [0, 777, 64]
    assert t[at.T_POSITION_SEQ] == 4
    server.time = 5  # the server has set its clock anew
    server.cycle(64)
    assert t[at.T_MISSED] == 192


def test_notices():
    table = np.zeros(at.TABLE_WORDS, np.int64)

    def word(number):
        return table.ctypes.data + 8 * number

    PROCESS(jack_notices.note_value.address)(256, word(at.T_BLOCK))
    ctypes.CFUNCTYPE(ctypes.c_int, POINTER)(jack_notices.count_up.address)(word(at.T_XRUNS))
    ctypes.CFUNCTYPE(None, UINT, ctypes.c_int, POINTER)(jack_notices.count_port.address)(7, 1, word(at.T_PORTS_SEEN))
    shutdown = ctypes.CFUNCTYPE(None, ctypes.c_int, ctypes.c_char_p, POINTER)(jack_notices.note_shutdown.address)
    joined = ctypes.CFUNCTYPE(None, UINT, UINT, ctypes.c_int, POINTER)(jack_notices.count_connection.address)
    joined(7, 8, 0, word(at.T_CYCLES))
    assert table[at.T_CYCLES] == 1
    assert [table[k] for k in (at.T_BLOCK, at.T_XRUNS, at.T_PORTS_SEEN, at.T_SHUTDOWN)] == [256, 1, 1, 0]
    for reason in (None, b"gone", b"x" * 1000):
        table[at.T_REASON : at.T_REASON + at.REASON_BYTES // 8] = 0
        shutdown(32, reason, table.ctypes.data)
        kept = table[at.T_REASON : at.T_REASON + at.REASON_BYTES // 8].tobytes().rstrip(b"\0")
        assert kept == (reason or b"")[: at.REASON_BYTES - 1]
        assert table[at.T_SHUTDOWN] == 1 and table[at.T_SHUTDOWN_CODE] == 32
    assert not table[at.T_PARSER :].any()


def test_latency_ranges_span_those_of_the_other_side():
    kind = ctypes.CFUNCTYPE(None, POINTER, ctypes.c_int, ctypes.POINTER(UINT))
    given = {(1, 1): (64, 128), (2, 1): (32, 96), (101, 0): (256, 300)}
    told = {}

    def read(port, mode, pair):
        pair[0], pair[1] = given[port, mode]

    def write(port, mode, pair):
        told[port, mode] = (pair[0], pair[1])

    kept = kind(read), kind(write)
    server = FakeServer()
    for word, function in zip((at.T_GET_RANGE, at.T_SET_RANGE), kept, strict=True):
        server.table[word] = ctypes.cast(function, POINTER).value
    tell = ctypes.CFUNCTYPE(None, ctypes.c_int, POINTER)(jack_notices.tell_latency.address)
    for mode in (at.CAPTURE, at.PLAYBACK):
        tell(mode, server.table.ctypes.data)
    assert told == {(1, 0): (256, 300), (2, 0): (256, 300), (101, 1): (32, 128)}
    server.table[at.T_MIDI_PORTS] = 0
    tell(at.CAPTURE, server.table.ctypes.data)
    assert told[1, 0] == (0, 0)


@pytest.mark.parametrize("name", ["jack.process", "jack_notices.*"])
def test_nothing_allocates_or_calls_python(name):
    kept = sorted(pathlib.Path(cache_folder()).glob(f"*/{name}-*.nbc"))
    if not kept:
        pytest.skip("compiled code is not kept here, so its symbols cannot be read")
    for path in kept:
        (_, kind, (machine_code, _)), *_ = pickle.loads(path.read_bytes())
        assert kind == "object" and b".text" in machine_code
        assert [word for word in FORBIDDEN if word in machine_code] == []
