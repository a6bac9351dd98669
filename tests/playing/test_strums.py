"""Strums: which string the hand comes to when, who joins a stroke, how its notes end, and that none of them is lost."""

import itertools
import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from player_bench import RATE, Bench, check_plucks

from ukrt.engine import controller_layout as cc
from ukrt.engine import gestures as do
from ukrt.playing.rules import HOLD_TIME, JOIN_TIME, strum_times

CHORD = (40, 47, 52, 56, 59, 64)  # E major on six strings
SWEEP = round(strum_times()[100] * RATE)
HOLD, JOIN = round(HOLD_TIME * RATE), round(JOIN_TIME * RATE)


def strummer(value=100, direction=0, **settings):
    bench = Bench(settings or None)
    bench.cc(0, cc.STRUM, value)
    bench.cc(0, cc.DIRECTION, direction)
    return bench


def come(bench):
    """(frame, string) of every pluck."""
    return [(frame, s) for frame, s, _ in bench.plucks()]


@pytest.mark.parametrize("direction, way", [(0, 1), (63, 1), (64, -1), (126, -1), (127, 1)])
def test_the_hand_comes_to_the_strings_at_an_even_speed(direction, way):
    bench = strummer(direction=direction)
    for key in CHORD:
        bench.on(1000, key)
    bench.finish()
    assert come(bench) == [(1000 + SWEEP * k // 5, s) for k, s in enumerate(range(6)[::way])]
    assert {(note["release_frame"], note["string"]) for note in bench.log} == {
        (frame + bench.lead, s) for frame, s in come(bench)
    }
    assert all(note["finger"] is None for note in bench.log)
    check_plucks(bench)


def test_strings_that_are_left_out_take_time_too():
    bench = strummer()
    for key in (40, 64):
        bench.on(1000, key)
    bench.finish()
    assert come(bench) == [(1000, 0), (1000 + SWEEP, 5)]


def test_the_preset_may_strum():
    bench = Bench({"articulation.strum_time": 0.1, "articulation.strum_direction": "up"})
    for key in CHORD:
        bench.on(1000, key)
    bench.cc(20000, cc.STRUM, 0)
    for key in CHORD:
        bench.on(20000, key)
    bench.finish()
    assert come(bench)[:6] == [(1000 + 960 * k, 5 - k) for k in range(6)]
    assert {frame for frame, _ in come(bench)[6:]} == {20000}


def test_strokes_in_turns_but_no_hand_turns_at_once():
    bench, strokes = strummer(20, 127), ((1000, 1), (9000, -1), (17000, 1), (17000 + JOIN // 2, 1), (40000, -1))
    for n, (frame, _) in enumerate(strokes):
        for key in CHORD:
            bench.on(frame, key, 80, n)
            bench.cc(frame, cc.STRUM, 20, n + 1)
            bench.cc(frame, cc.DIRECTION, 127, n + 1)
    bench.finish()
    sweep = round(strum_times()[20] * RATE)
    for n, (frame, way) in enumerate(strokes):
        stroke = [(frame + sweep * k // 5, s) for k, s in enumerate(range(6)[::way])]
        assert come(bench)[6 * n : 6 * n + 6] == stroke


def test_a_chord_that_comes_key_by_key_is_one_stroke():
    """What lies ahead of the hand waits for it; what lies behind begins a stroke of its own."""
    bench = strummer()
    for frame, key in ((1000, 40), (1100, 56), (1200, 47), (1200, 64)):
        bench.on(frame, key)
    bench.on(20000, 59)
    bench.on(20100, 52)
    bench.finish()
    assert come(bench)[:4] == [(1000 + SWEEP * s // 5, s) for s in (0, 1, 3, 5)]
    assert come(bench)[4:] == [(20000, 4), (20100, 2)]


def test_notes_that_come_later_do_not_wait():
    bench = strummer(127)
    bench.on(1000, 40)
    bench.on(1001 + JOIN, 64)
    bench.finish()
    assert come(bench) == [(1000, 0), (1001 + JOIN, 5)]


@pytest.mark.parametrize("length", [0, 500, 2000, SWEEP + HOLD, SWEEP + HOLD + 1000])
def test_every_string_sounds_for_as_long_as_its_key_was_down_up_to_a_while(length):
    bench = strummer()
    for key in CHORD:
        bench.on(1000, key)
    for key in CHORD:
        bench.off(1000 + length, key)
    bench.finish()
    for s in range(6):
        (pluck,) = [frame for frame, kind, _ in bench.strings[s].events if kind == do.PLUCK]
        (damp,) = [frame for frame, kind, _ in bench.strings[s].events if kind == do.DAMP]
        late = pluck - 1000
        assert damp - bench.lead == max(1000 + length, pluck + (min(length, HOLD) if late else 0))
    assert bench.held() == {} and bench.counters["notes_off_unmatched"] == 0


def test_a_string_that_is_needed_before_the_hand_has_come_is_plucked_once():
    bench = strummer(127)
    for key in CHORD:
        bench.on(1000, key)
    bench.cc(3000, cc.STRUM, 0)
    bench.on(3000, 66)
    bench.finish()
    assert [frame for frame, s in come(bench) if s == 5] == [3000] and len(come(bench)) == 6
    assert bench.counters["plucks_overtaken"] == 1


def test_all_sound_off_takes_the_hand_away_and_all_notes_off_does_not():
    for controller, expected in ((cc.SOUND_OFF, 1), (cc.NOTES_OFF, 6)):
        bench = strummer(127)
        for key in CHORD:
            bench.on(1000, key)
        bench.cc(1500, controller, 0)
        bench.finish()
        assert len(come(bench)) == expected and bench.held() == {}
        assert all(not string.damped for string in bench.strings)


def test_slurs_do_not_wait_for_the_hand():
    bench = strummer()
    bench.cc(0, cc.LEGATO, 127)
    for key in (40, 64):
        bench.on(1000, key)
    bench.on(1000 + SWEEP // 2, 66)  # the hand has yet to come to E4: there is nothing to slur from
    bench.on(20000, 67)
    bench.finish()
    assert [note["articulation"] for note in bench.log] == ["pluck", "pluck", "pluck", "hammer-on"]
    assert len(come(bench)) + bench.counters["plucks_overtaken"] == 3


def test_reset_strums_as_the_preset_does():
    for setting, spread in ((0.0, {0}), (0.1, {0, 960, 1920, 2880, 3840, 4800})):
        bench = Bench({"articulation.strum_time": setting})
        bench.cc(0, cc.STRUM, 127)
        bench.cc(0, cc.DIRECTION, 100)
        bench.cc(0, cc.RESET, 0)
        for key in CHORD:
            bench.on(1000, key)
        bench.finish()
        assert {frame - 1000 for frame, _ in come(bench)} == spread


@pytest.mark.parametrize("seed", range(8))
def test_notes_of_one_frame_may_come_in_any_order(seed):
    """A chord takes strings that still wait for the hand: whatever is decided anew, the same gestures come of it."""
    rng = random.Random(seed)
    first, second = rng.sample(range(40, 76), 5), rng.sample(range(40, 76), 3)
    gap, value = rng.choice((1, 300, 3000)), rng.choice((30, 100, 127)) if seed < 4 else 0
    seen = set()
    for order in itertools.permutations(second):
        bench = strummer(value)
        bench.cc(0, cc.PLANTING, 100 if seed > 2 else 0)
        bench.cc(0, cc.ATTACK, 30)
        for key in first:
            bench.on(1000, key)
        for controller, number in ((cc.PLACE, 90), (cc.ANGLE, 90), (cc.PLANTING, 0), (cc.ATTACK, 60)):
            bench.cc(1000 + gap, controller, number)
        for key in order:
            bench.on(1000 + gap, key, 40)
        bench.finish()
        seen.add(tuple(sorted((frame, s, kind, p[:4]) for frame, kind, s, p in bench.gestures)))
    assert len(seen) == 1


MESSAGES = st.lists(
    st.tuples(
        st.sampled_from((0, 0, 0, 1, 64, 480, 3000, 20000)),
        st.sampled_from(("on", "on", "on", "off", cc.STRUM, cc.DIRECTION, cc.ATTACK, cc.PLANTING, cc.PEDAL, cc.LEGATO)),
        st.integers(40, 79),
        st.sampled_from((0, 0, 30, 64, 127)),
    ),
    min_size=1,
    max_size=60,
)


@settings(max_examples=60, deadline=None)
@given(MESSAGES)
def test_no_note_is_lost_or_stuck(messages):
    """Every note that is plucked is plucked once, or counted as overtaken; and then all ends."""
    bench, frame = Bench(), 0
    for wait, what, key, value in messages:
        frame += wait
        if what == "on":
            bench.on(frame, key)
        elif what == "off":
            bench.off(frame, key)
        else:
            bench.cc(frame, what, value)
    bench.cc(frame + 1, cc.PEDAL, 0)
    bench.cc(frame + 1, cc.NOTES_OFF, 0)
    bench.finish()
    plucked = [int(p[4]) for _, _, p in bench.plucks()]
    wanted = [n for n, note in enumerate(bench.log) if note["articulation"] == "pluck" and note["fate"] != "dropped"]
    assert len(set(plucked)) == len(plucked) and set(plucked) <= set(wanted)
    assert len(wanted) - len(plucked) == bench.counters["plucks_overtaken"]
    for pull, s, p in bench.plucks():
        note = bench.log[int(p[4])]
        assert note["string"] == s and note["release_frame"] == pull + p[3]
    for string in bench.strings:
        assert not string.damped and string.place == 0.0 and string.tension == 1.0
        touched = [p[2] > 0.0 for _, kind, p in string.events if kind == do.TOUCH]
        assert not touched or not touched[-1]
    assert bench.counters["gestures_refused"] == 0 and bench.held() == {}
