"""An open input over a made-up RtMidi: times of arrival, bursts, and what cannot be opened."""

import types

import pytest

from ukrt.drivers.midi import port as midi_port
from ukrt.drivers.midi.port import OpenInput, Port
from ukrt.errors import DeviceError

_MS = 1_000_000


class MidiIn:
    """RtMidi's input: messages come at known times on a clock that the test moves."""

    clock, refuses = None, False

    def __init__(self, *_, **__):
        self.arrivals, self._before = [], None

    def open_port(self, number, name):
        if self.refuses:
            raise OSError("port is busy")

    def ignore_types(self, **ignored):
        assert not any(ignored.values())

    def get_message(self):
        self.clock.ns += self.clock.slow
        if not self.arrivals or self.arrivals[0][0] > self.clock.ns:
            return None
        at, packet = self.arrivals.pop(0)
        since, self._before = 0.0 if self._before is None else (at - self._before) * 1e-9, at
        return packet, since

    def close_port(self):
        self.closed = True

    delete = close_port


@pytest.fixture
def clock(monkeypatch):
    clock = types.SimpleNamespace(ns=10**12, slow=0)
    monkeypatch.setattr(MidiIn, "clock", clock)
    rtmidi = types.SimpleNamespace(MidiIn=MidiIn, RtMidiError=ValueError)
    monkeypatch.setattr(midi_port, "load_rtmidi", lambda: rtmidi)
    monkeypatch.setattr(midi_port, "time", types.SimpleNamespace(monotonic_ns=lambda: clock.ns))
    return clock


def opened():
    one = OpenInput(Port("keys", 2, "ALSA", 0))
    return one, one._midi


def test_a_process_held_up_between_two_instructions_spoils_no_later_times(clock):
    """A message that comes while the poll is held up is not from the future, and later ones are not from the past."""
    one, midi = opened()
    start = clock.ns
    midi.arrivals = [(start + k * 10 * _MS + 300_000, [0x90, k % 128, 1]) for k in range(200)]
    errors = []
    for k in range(200):
        for part in range(20):
            clock.ns = start + k * 10 * _MS + part * _MS // 2
            clock.slow = 3 * _MS if k % 50 == 20 and part == 0 else 0
            errors += [at - (start + k * 10 * _MS + 300_000) for at, _ in one.poll()]
    assert len(errors) == 200
    assert all(-100_000 <= error <= 300_000 for error in errors[1:])


def test_a_burst_is_taken_in_portions_and_none_is_lost(clock):
    one, midi = opened()
    midi.arrivals = [(clock.ns, [0xE0, k & 127, k >> 7]) for k in range(5000)]
    portions = []
    while got := one.poll():
        portions.append(len(got))
    assert sum(portions) == 5000 and max(portions) < 2000


def test_several_messages_in_a_packet_and_split_ones(clock):
    one, midi = opened()
    packets = [[0x90, 60, 1, 61, 1], [0xF0, 1], [2, 0xF7], [0xF8], [0xF0, 0x7F, 0, 4], [4, 0, 66, 0xF7]]
    midi.arrivals = [(clock.ns, packet) for packet in packets]
    coarse = [(0xF0, 0x7F, 0), (0xF4, 4, 4), (0xF4, 0, 66), (0xF7, 0, 0)]  # and of a maker's own what says so
    assert [tuple(message) for _, message in one.poll()] == [(0x90, 60, 1), (0x90, 61, 1), (0xF5, 0, 0), *coarse]


def test_a_port_that_cannot_be_opened_is_named(clock, monkeypatch):
    monkeypatch.setattr(MidiIn, "refuses", True)
    with pytest.raises(DeviceError, match="'keys' cannot be opened: port is busy"):
        opened()
