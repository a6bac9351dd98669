"""The lane's writer in plain Python: what it refuses, what it keeps, and that compiled code does the same."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from midi_rig import RATE, Stage

from ukrt.drivers.midi.lane import Lane, StageView, message_class
from ukrt.engine import stage_layout as at

_WRITE, _READ = (start + at.LANE_STEP * at.LANE_MIDI for start in (at.LANE_WRITE, at.LANE_READ))
_QUEUE = at.QUEUES + at.LANE_SIZE * at.LANE_MIDI
_CONTROLLER, _NOTE, _END = (0xB0, 1, 64), (0x90, 60, 100), (0x90, 60, 0)


@pytest.fixture
def si():
    return np.zeros(at.SI_SIZE, np.int64)


@pytest.mark.parametrize(
    ("kind", "messages"),
    [
        (at.CLASS_NOTE_ON, [(0x90, 60, 1), (0x9F, 0, 127)]),
        (at.CLASS_OFF, [(0x80, 60, 64), (0x95, 60, 0), (0xB0, 64, 63), (0xB3, 66, 0), (0xFF, 0, 0)]),
        (at.CLASS_OFF, [(0xB0, 120, 0), (0xB0, 121, 0), (0xB9, 123, 0), (0xB0, 127, 0)]),
        (at.CLASS_OTHER, [(0xB0, 64, 64), (0xB0, 1, 0), (0xE0, 0, 64), (0xC0, 64, 0), (0xD0, 123, 0), (0xA0, 60, 0)]),
    ],
)
def test_classes(kind, messages):
    assert [message_class(*message) for message in messages] == [kind] * len(messages)


def test_a_filling_lane_refuses_controllers_then_notes_then_ends(si):
    lane = Lane(si, at.LANE_MIDI)
    for message, room in zip((_CONTROLLER, _NOTE, _END), at.ROOM, strict=True):
        while lane.push(0, *message):
            pass
        assert si[_WRITE] == room
    assert [lane.push(0, *m) for m in (_CONTROLLER, _NOTE, _NOTE, _END)] == [False] * 4
    assert lane.refused() == [2, 3, 2]
    si[_READ] += 1  # one was taken: room for the end of a note, for nothing else
    assert [lane.push(0, *m) for m in (_CONTROLLER, _NOTE, _END)] == [False, False, True]


def test_frames_never_decrease_and_words_come_in_order(si):
    lane = Lane(si, at.LANE_MIDI)
    for frame in (5, 3, 9, 0):
        assert lane.push(frame, 0x90, frame, 1)
    entries = si[_QUEUE : _QUEUE + 8].reshape(-1, 2).tolist()
    assert entries == [[5, 0x900501], [5, 0x900301], [9, 0x900901], [9, 0x900001]]
    si[_READ] = si[_WRITE]  # all taken: another count of frames may begin
    lane.push(1, *_NOTE)
    assert si[_QUEUE + 8] == 1


def test_round_and_round_without_a_loss(si):
    lane, got = Lane(si, at.LANE_MIDI), 0
    for k in range(3 * at.QUEUE):
        assert lane.push(k, 0xE0, k & 127, (k >> 7) & 127)
        if k % 1000 == 999:
            while si[_READ] < si[_WRITE]:
                slot = _QUEUE + 2 * (int(si[_READ]) % at.QUEUE)
                assert si[slot] == got and si[slot + 1] == 0xE00000 | (got & 127) << 8 | (got >> 7) & 127
                si[_READ] += 1
                got += 1
    assert lane.refused() == [0, 0, 0]


_message = st.tuples(st.integers(0x80, 0xFF), st.integers(0, 127), st.integers(0, 127))


@settings(deadline=None)  # the first example compiles
@given(st.lists(_message, min_size=1, max_size=20), st.sampled_from([0, *(room - 3 for room in at.ROOM)]))
def test_the_compiled_writer_does_the_same(messages, waiting):
    from ukrt.engine.kernels.queue import lane_push

    ours, theirs = np.zeros(at.SI_SIZE, np.int64), np.zeros(at.SI_SIZE, np.int64)
    ours[_WRITE] = theirs[_WRITE] = waiting
    lane = Lane(ours, at.LANE_MIDI)
    for status, data1, data2 in messages:
        word = status << 16 | data1 << 8 | data2
        assert lane.push(7, status, data1, data2) == lane_push(theirs, at.LANE_MIDI, 7, word)
    assert np.array_equal(ours, theirs)


def test_another_process_view_of_a_stage():
    stage = Stage()
    view = StageView(stage.manifest()["stage"])
    try:
        assert view.stamp() == (0, 0, 0)
        stage.stamp(640, 123, 64)
        stage.si[at.G_FRAME] = 704
        assert (view.frame, view.sample_rate, view.stamp()) == (704, RATE, (640, 123, 64))
        stage.si[at.G_STAMP_SEQ] += 1  # a writer that died in the middle
        assert view.stamp()[1] == 0
        Lane(view.si, at.LANE_MIDI).push(3, *_NOTE)
        assert stage.take() == [(3, _NOTE)]
    finally:
        view.close()
        stage.close()


def test_a_block_of_another_layout_is_refused():
    stage = Stage()
    manifest = stage.manifest()["stage"]
    manifest["arrays"]["si"] = ["int64", 0, 100]
    with pytest.raises(ValueError, match=f"{at.SI_SIZE} integers"):
        StageView(manifest)
    stage.close()
