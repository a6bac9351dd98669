"""The piece player without a clock: an engine whose frames the test counts, and what it is sent."""

import numpy as np
import pytest
from fake_engine import FakeEngine

from ukrt.drivers.files.midi import Score
from ukrt.drivers.live.piece import PiecePlayer, loose_ends

NOTE = (0x90, 60, 99)
OFF = (0x80, 60, 0)


def make_score(*events, duration_s):
    times, *columns = zip(*events, strict=True)
    return Score(np.array(times), *(np.array(c, np.uint8) for c in columns), duration_s=duration_s, n_notes=1)


class Stage(FakeEngine):
    """A `FakeEngine` whose frames pass when told, with the journal of a keyboard and a queue that is read."""

    def __init__(self, capacity=100_000):
        super().__init__(capacity=capacity)
        self.played = []

    def journal(self, since):
        rows = np.array(self.played[since:], dtype=np.int64).reshape(-1, 2)
        return len(self.played), rows, 0

    def run(self, player, seconds, step=480):
        end = self.frame + round(seconds * self.sample_rate)
        while self.frame < end:
            self.frame += step
            player.turn()


@pytest.fixture
def started():
    """Gives a player on a stage; its thread is started last, with the piece, and ended before anything is looked at."""

    def start(engine, score, **options):
        player = PiecePlayer(engine, score, **options)
        player._thread.start = lambda: None  # the test turns
        player.start()
        player.turn()
        return player

    return start


def test_frames_are_those_of_a_rendered_file_and_sent_a_second_ahead(started):
    times = [0.0, 0.1, 0.30001, 2.5]
    engine = Stage()
    player = started(engine, make_score(*((t, *NOTE) for t in times), duration_s=3.0))
    start = engine.sent[0][0]
    assert start > 0 and len(engine.sent) == 3  # the last one is more than a second away
    engine.run(player, 2.0)
    assert [e[0] - start for e in engine.sent] == np.rint(np.array(times) * 48000).astype(int).tolist()
    assert not player.over and 1.7 < player.position_s < 1.9
    engine.run(player, 1.3)
    assert player.over and player.position_s == 3.0 and player.sent == 4 and player.slips == 0


def test_a_loop_has_no_seam_and_lets_go_of_what_the_piece_holds(started):
    engine = Stage()
    score = make_score((0.0, *NOTE), (0.25, 0xE0, 0, 80), (0.5, 0x91, 64, 80), duration_s=0.75)
    player = started(engine, score, loop=True)
    engine.run(player, 2.0)
    start = engine.sent[0][0]
    assert [e[0] - start for e in engine.sent if e[1:] == NOTE] == [k * 36000 for k in range(4)]
    seam = [e[1:] for e in engine.sent if e[0] - start == 36000]
    assert seam == [OFF, (0x81, 64, 0), (0xB0, 121, 0), NOTE]
    assert not player.over
    assert engine.sent[-1][0] <= engine.frame + 48000, "the queue of a loop is bounded"


def test_more_messages_than_there_is_room_for_are_sent_later_and_none_is_lost(started):
    engine = Stage()
    score = make_score(*((k * 1e-5, 0xB0, 7, k % 128) for k in range(30_000)), duration_s=0.4)
    player = started(engine, score)
    assert len(engine.sent) == 8192
    engine.run(player, 1.0)
    assert [e[3] for e in engine.sent] == [k % 128 for k in range(30_000)] and player.over


def test_what_a_full_queue_refuses_is_sent_again(started):
    engine = Stage(capacity=2)
    player = started(engine, make_score(*((0.1 * k, 0x90, 60 + k, 99) for k in range(5)), duration_s=1.0))
    assert len(engine.sent) == 2
    engine.capacity = 100
    player.turn()
    assert [e[2] for e in engine.sent] == [60, 61, 62, 63, 64]


def test_a_player_that_was_kept_from_its_work_goes_on_later_at_the_same_pace(started):
    engine = Stage()
    player = started(engine, make_score(*((0.5 * k, 0x90, 60 + k, 99) for k in range(9)), duration_s=5.0))
    sent = len(engine.sent)
    engine.frame += 3 * 48000
    player.turn()
    engine.run(player, 4.0)
    frames = [e[0] for e in engine.sent]
    assert player.slips == 1 and len(frames) == 9
    assert frames[sent] > 3 * 48000
    assert np.diff(frames[sent:]).tolist() == [24000] * (9 - sent - 1)


def test_a_changed_sample_rate_counts_from_where_it_came(started):
    engine = Stage()
    player = started(engine, make_score(*((0.5 * k, 0x90, 60 + k, 99) for k in range(12)), duration_s=6.0))
    engine.run(player, 1.0)
    sent = len(engine.sent)
    engine.sample_rate = 96000.0
    engine.run(player, 5.0)
    steps = np.diff([e[0] for e in engine.sent])
    assert set(steps[: sent - 1]) == {24000} and set(steps[sent:]) == {48000}
    assert 24000 <= steps[sent - 1] <= 48000 and len(engine.sent) == 12


def test_a_piece_waits_for_the_first_note_of_a_keyboard(started):
    engine = Stage()
    player = started(engine, make_score((0.0, *NOTE), duration_s=1.0), wait=True)
    engine.played += [(10, 0xB0 << 16 | 64 << 8 | 127), (20, 0x90 << 16 | 60 << 8), (30, 2 << 32 | 0x906060)]
    engine.run(player, 1.0)
    assert engine.sent == [] and not player.begun and not player.over
    engine.played += [(engine.frame, 0x93 << 16 | 60 << 8 | 1)]
    player.turn()
    assert len(engine.sent) == 1 and 0 < engine.sent[0][0] - engine.frame < 0.05 * 48000 and player.begun


class TestTransport:
    def follow(self, started):
        self.state = (False, 0.0, 0)
        engine = Stage()
        score = make_score(*((0.1 * k, 0x90, 40 + k, 99) for k in range(60)), duration_s=6.0)
        return engine, started(engine, score, transport=lambda: self.state)

    def roll(self, engine, player, second, seconds, step=480):
        for k in range(round(seconds * 48000 / step)):
            self.state = (True, second + k * step / 48000, engine.frame)
            player.turn()
            engine.frame += step

    def test_stands_rolls_and_jumps(self, started):
        engine, player = self.follow(started)
        engine.run(player, 1.0)
        assert engine.sent == []
        start = engine.frame
        self.roll(engine, player, 2.0, 1.0)
        on = [e for e in engine.sent if e[1] == 0x90]
        assert on[0][2] == 40 + 21, "the note that falls on the very moment comes too late to be played in time"
        assert all(e[0] == start + round((0.1 * (e[2] - 40) - 2.0) * 48000) for e in on)
        assert on[-1][0] <= engine.frame + 0.1 * 48000
        del engine.sent[:]
        start = engine.frame
        self.roll(engine, player, 0.05, 0.5)
        assert {e[2] for e in engine.sent if e[1] == 0x80} >= {40 + 25}, "what sounded is ended"
        assert [e[2] for e in engine.sent if e[1] == 0x90][:3] == [41, 42, 43]
        assert np.all(np.diff([e[0] for e in engine.sent]) >= 0)
        self.state = (False, 0.55, engine.frame)
        del engine.sent[:]
        engine.run(player, 0.5)
        assert engine.sent and all(e[1] == 0x80 for e in engine.sent) and not player.begun

    def test_a_small_wobble_is_no_jump(self, started):
        engine, player = self.follow(started)
        for k in range(100):
            self.state = (True, k * 0.01 + 0.004 * (-1) ** k, engine.frame)
            player.turn()
            engine.frame += 480
        assert {e[1] for e in engine.sent} == {0x90}
        assert set(np.diff([e[0] for e in engine.sent])) == {4800}


def test_a_failure_of_the_thread_is_kept():
    engine = Stage()

    def fail(*_):
        raise OSError("no such queue")

    engine.send = fail
    player = PiecePlayer(engine, make_score((0.0, *NOTE), duration_s=1.0))
    player.start()
    player._thread.join(5)
    player.close()
    assert "no such queue" in str(player.failure)


def test_loose_ends_are_what_is_held_and_moved():
    events = [(0, *NOTE), (0, 0x92, 62, 80), (0, *OFF), (0, 0x90, 61, 1), (0, 0x90, 61, 0), (0, 0xB3, 64, 127)]
    assert loose_ends(events) == [(0x82, 62, 0), (0xB3, 121, 0)]
    assert loose_ends([]) == []
