"""Inputs become a lane: choice of ports, what is held down, active sensing; with made-up ports."""

import numpy as np
import pytest
from engine import sysex
from hypothesis import given
from hypothesis import strategies as st

from ukrt.drivers.midi.choice import Choice
from ukrt.drivers.midi.held import Held, everything_off
from ukrt.drivers.midi.lane import Lane
from ukrt.drivers.midi.merge import Merger
from ukrt.drivers.midi.port import Port, devices, distinct, shown_name, stable_name
from ukrt.drivers.midi.stream import Message
from ukrt.engine import stage_layout as at

_MS = 1_000_000


def alsa(name, client=20):
    return Port(f"{name} {client}:0", 2, "ALSA", 0)


def jack(name):
    return Port(name, 3, "Jack", 0)


class Input:
    """An input whose messages the test puts in."""

    virtual = False

    def __init__(self, name, clock):
        self.port, self.waiting, self.closed, self._clock = alsa(name), [], False, clock

    def poll(self):
        got, self.waiting = self.waiting, []
        return [(self._clock.ns, Message(*message)) for message in got]

    def close(self):
        self.closed = True


class Clock:
    """Frame = time [ms]."""

    def __init__(self):
        self.ns = 0

    def look(self):
        pass

    def acts_at(self, ns):
        return ns // _MS

    def frame(self):
        return self.ns // _MS


class World:
    """A merger, its clock and its lane."""

    def __init__(self):
        self.si, self.clock = np.zeros(at.SI_SIZE, np.int64), Clock()
        self.merger = Merger(Lane(self.si, at.LANE_MIDI), self.clock)

    def add(self, name):
        one = Input(name, self.clock)
        self.merger.add(one)
        return one

    def poll(self, ms):
        self.clock.ns = ms * _MS
        self.merger.poll(self.clock.ns)

    def written(self):
        """All that is in the lane: (frame, status, data1, data2)."""
        count = int(self.si[at.LANE_WRITE + at.LANE_STEP * at.LANE_MIDI])
        base = at.QUEUES + at.LANE_SIZE * at.LANE_MIDI
        entries = self.si[base : base + 2 * count].reshape(-1, 2).tolist()
        return [(frame, word >> 16, word >> 8 & 0xFF, word & 0xFF) for frame, word in entries]


@pytest.fixture
def world():
    return World()


def test_inputs_are_merged_with_the_frame_of_each_arrival(world):
    a, b = world.add("a"), world.add("b")
    a.waiting, b.waiting = [(0x90, 60, 1), (0x90, 61, 2)], [(0x91, 60, 3)]
    world.poll(5)
    b.waiting = [(0xE1, 1, 2)]
    world.poll(7)
    assert world.written() == [(5, 0x90, 60, 1), (5, 0x90, 61, 2), (5, 0x91, 60, 3), (7, 0xE1, 1, 2)]
    assert world.merger.received == 4
    assert world.merger.names == ["a (ALSA)", "b (ALSA)"]


def test_sysex_of_two_inputs_goes_one_after_the_other(world):
    a, b = world.add("a"), world.add("b")
    a.waiting, b.waiting = (sysex.messages(whole) for whole in (sysex.master_fine(5), sysex.master_volume(6)))
    expected = [(5, *message) for message in [*a.waiting, *b.waiting]]
    world.poll(5)
    assert world.written() == expected


def test_what_a_port_held_ends_when_it_goes_unless_another_holds_it_too(world):
    a, b = world.add("a"), world.add("b")
    a.waiting = [(0x90, 60, 1), (0x90, 62, 1), (0x90, 64, 1), (0x80, 64, 0), (0xB0, 64, 127), (0xE3, 0, 80)]
    b.waiting = [(0x90, 62, 1)]
    world.poll(1)
    before = len(world.written())
    world.clock.ns = 9 * _MS
    world.merger.news = []
    world.merger.remove(a, "has gone")
    assert world.written()[before:] == [(9, 0x80, 60, 0), (9, 0xB0, 64, 0), (9, 0xE3, 0, 64)]
    assert world.merger.news == ["a (ALSA) has gone; the 2 notes it held end"]
    assert a.closed and world.merger.inputs == [b]


def test_active_sensing_is_watched_for_each_input_by_itself(world):
    a, b = world.add("a"), world.add("b")
    a.waiting, b.waiting = [(0xFE, 0, 0), (0x90, 60, 1)], [(0x90, 70, 1)]
    for ms in range(0, 330, 10):
        world.poll(ms)
    assert world.merger.sensing_timeouts == 0
    a.waiting = [(0xFE, 0, 0)]  # in time
    for ms in range(330, 660, 10):
        world.poll(ms)
    assert len(world.written()) == 2
    for ms in range(660, 2000, 10):
        b.waiting = [(0xB0, 1, 1)] if ms == 700 else []
        world.poll(ms)
    assert [message[1:] for message in world.written()[2:]] == [(0x80, 60, 0), (0xB0, 1, 1)]
    assert world.merger.sensing_timeouts == 1
    assert any("a (ALSA) has fallen silent" in sentence for sentence in world.merger.news)


_voice = st.tuples(
    st.sampled_from([0x80, 0x90, 0xB0, 0xE0]) | st.just(0x95), st.integers(58, 66) | st.integers(119, 125),
    st.sampled_from([0, 63, 64, 127]),
)  # fmt: skip


@given(st.lists(_voice, max_size=30))
def test_after_a_release_nothing_is_held(messages):
    held, judge = Held(), Held()
    for message in messages:
        held.take(*message)
        judge.take(*message)
    released = held.release()
    assert held.release() == []
    for message in released:
        judge.take(*message)
    assert judge.release() == [] and judge.keys == set()
    down = {(m[0] & 15, m[1]) for k, m in enumerate(messages) if _sounds(m, messages[k + 1 :])}
    assert {(m[0] & 15, m[1]) for m in released if m[0] & 0xF0 == 0x80} == down


def _sounds(message, later):
    """Whether a note-on still sounds after all that came later."""
    if message[0] & 0xF0 != 0x90 or not message[2]:
        return False
    channel = message[0] & 15
    return not any(m[0] & 15 == channel and _ends(m, message[1]) for m in later)


def _ends(message, key):
    kind, data1, data2 = message[0] & 0xF0, *message[1:]
    if kind == 0xB0:
        return data1 in (120, *range(123, 128))
    return data1 == key and (kind == 0x80 or (kind == 0x90 and data2 == 0))


def test_everything_off_lets_go_on_every_channel():
    held = Held()
    for channel in range(16):
        held.take(0x90 | channel, 60, 1)
        held.take(0xB0 | channel, 64, 127)
    for message in everything_off():
        held.take(*message)
    assert held.release() == []


class TestChoice:
    loop, keys, pads = alsa("Midi Through:Port-0", 14), alsa("Keys:Keys MIDI 1", 20), alsa("Pads:Pads", 24)
    again = alsa("Keys:Keys MIDI 1", 28)  # plugged in again
    bridge, program = jack("a2j:Keys MIDI 1"), jack("sequencer:out")

    def test_one_device_and_the_same_again(self):
        choice = Choice(None)
        assert choice.ports([self.loop]) == []
        assert choice.ports([self.loop, self.keys, self.pads]) == [self.keys]
        assert choice.ports([self.loop, self.pads]) == [self.pads]
        assert choice.ports([self.loop, self.pads, self.again]) == [self.again]
        successor = Choice(**choice.resolved())
        assert successor.ports([self.pads, self.keys]) == [self.keys]

    def test_all_devices_each_once(self):
        choice = Choice("all")
        assert choice.ports([self.loop, self.keys, self.pads, self.bridge]) == [self.keys, self.pads]
        assert choice.ports([self.keys, self.bridge, self.program]) == [self.keys, self.program]
        assert choice.ports([jack("system:midi_capture_1")]) == [jack("system:midi_capture_1")]

    def test_names_parts_and_indices(self):
        listed = [self.loop, self.keys, self.pads, self.program]
        assert Choice(["pads", "SEQ"]).ports(listed) == [self.pads, self.program]
        assert Choice([]).ports(listed) == []
        assert Choice(["Keys:Keys MIDI 1", "keys"]).ports(listed) == [self.keys]
        assert Choice(["through"]).ports(listed) == [self.loop]

    def test_an_index_means_the_port_that_had_it_first(self):
        choice = Choice(["1"])
        assert choice.ports([self.loop, self.keys]) == [self.keys]
        assert choice.ports([self.loop, self.pads, self.again]) == [self.again]
        assert Choice(**choice.resolved()).ports([self.again, self.pads]) == [self.again]

    def test_what_is_not_there_yet_is_told_once_and_opened_later(self):
        choice = Choice(["keys"])
        assert choice.ports([self.pads]) == [] == choice.ports([])
        (sentence,) = choice.news()
        assert "'keys'" in sentence and "Pads:Pads (ALSA)" in sentence
        assert choice.ports([self.pads, self.keys]) == [self.keys] and choice.news() == []

    def test_a_part_that_fits_several_says_which_is_taken(self):
        choice = Choice(["keys"])
        assert choice.ports([self.keys, alsa("Keys:Keys MIDI 2")]) == [self.keys]
        assert "Keys:Keys MIDI 2 (ALSA)" in choice.news()[0]

    def test_names_without_the_numbers_of_alsa(self):
        assert stable_name(self.keys) == stable_name(self.again) == "Keys:Keys MIDI 1"
        assert shown_name(self.program) == "sequencer:out (Jack)"
        assert devices([]) == []
        assert distinct(["Keys", "Pads", "Keys", "Keys"]) == ["Keys", "Pads", "Keys #2", "Keys #3"]
        assert stable_name(Port("Keys 2", 4, "Windows MultiMedia", 2)) == "Keys"
