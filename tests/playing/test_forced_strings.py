"""CC20 names the string, CC21 the position of the hand: for the notes of its channel that follow, until it changes."""

import random

import numpy as np
import pytest
from player_bench import Bench

from ukrt.engine import player_layout as at
from ukrt.engine.kernels.transfer_player import transfer_player

OPEN = (40, 45, 50, 55, 59, 64)
STRING, POSITION = 20, 21


def play_forced(bench, frame, notes, channel=0):
    """Notes of one frame, each as (key, string number), with a CC20 before each."""
    for key, number in notes:
        bench.cc(frame, STRING, number, channel)
        bench.on(frame, key, channel=channel)


def places(bench):
    """Key -> (string number, fret) of what sounds."""
    return {key: (6 - s, fret) for s, (key, _, fret) in bench.held().items()}


def test_every_place_of_the_fingerboard_can_be_asked_for():
    for number in range(1, 7):
        for fret in range(20):
            bench = Bench()
            key = OPEN[6 - number] + fret
            play_forced(bench, 100, [(key, number)])
            assert places(bench) == {key: (number, fret)} and bench.counters["forces_refused"] == 0


def test_in_a_chord_each_controller_binds_the_note_that_follows_it():
    rng = random.Random(3)
    for _ in range(60):
        numbers = rng.sample(range(1, 7), rng.randint(2, 6))
        position = rng.randint(1, 12)
        chord = {}
        for number in numbers:
            chord.setdefault(OPEN[6 - number] + rng.randint(position, position + 4), number)
        bench = Bench()
        play_forced(bench, 100, chord.items())
        assert {key: number for key, (number, _) in places(bench).items()} == chord
        assert bench.counters["forces_refused"] == 0 and bench.counters["searches_cut_short"] == 0


def test_a_string_without_the_note_leaves_the_choice_free_and_is_counted():
    free = Bench()
    free.on(100, 45)
    bench = Bench()
    play_forced(bench, 100, [(45, 1)])  # lower than string 1 goes
    assert places(bench) == places(free) and bench.counters["forces_refused"] == 1
    bench = Bench()
    play_forced(bench, 100, [(64, 7), (64 + 12, 12)])  # six strings only
    assert len(places(bench)) == 2 and bench.counters["forces_refused"] == 2


def test_no_note_is_dropped_because_two_ask_for_one_string():
    bench = Bench()
    play_forced(bench, 100, [(64, 2), (60, 2), (57, 2)])
    held = places(bench)
    assert set(held) == {64, 60, 57} and sum(number == 2 for number, _ in held.values()) == 1
    assert bench.counters["forces_refused"] == 2 and bench.counters["notes_dropped"] == 0


def test_a_forced_string_is_taken_from_the_note_that_sounds_on_it():
    bench = Bench()
    play_forced(bench, 100, [(60, 2)])
    play_forced(bench, 9000, [(62, 2)])
    assert places(bench) == {62: (2, 3)} and bench.counters["notes_stolen"] == 1
    play_forced(bench, 18000, [(62, 3)])  # the same key, on another string: its former sound ends
    assert places(bench) == {62: (3, 7)} and bench.counters["notes_repeated"] == 1


def test_channels_keep_what_they_were_told_until_it_is_taken_back():
    bench = Bench()
    bench.cc(0, STRING, 3, channel=2)
    bench.on(10, 64, channel=2)
    bench.on(10, 60, channel=1)
    assert places(bench)[64] == (3, 9) and places(bench)[60] != (3, 5)
    for frame, message in ((20000, (0xB2, STRING, 0)), (60000, (0xB2, 121, 0)), (99000, (0xFF, 0, 0))):
        bench.cc(frame, 123, 0, channel=2)
        bench.cc(frame, STRING, 6, channel=2)
        bench.on(frame, 55, channel=2)
        assert places(bench)[55] == (6, 15)
        bench.off(frame + 5000, 55, channel=2)
        bench.send(frame + 9000, *message)
        bench.cc(frame + 19000, POSITION, 3, channel=7)
        bench.on(frame + 20000, 50, channel=7)  # brings the hand down
        bench.on(frame + 25000, 55, channel=2)
        assert places(bench)[55] == (3, 0)
        bench.off(frame + 26000, 50, channel=7)
        bench.off(frame + 26000, 55, channel=2)


def test_values_out_of_range_change_nothing_and_are_counted():
    bench = Bench()
    bench.cc(0, STRING, 3)
    bench.cc(0, STRING, 13)
    bench.cc(0, POSITION, 20)  # nineteen frets
    bench.on(0, 64)
    assert places(bench)[64] == (3, 9) and bench.counters["controllers_ignored"] == 2


@pytest.mark.parametrize("position", [1, 3, 5, 7, 9, 12])
def test_in_a_position_every_stopped_note_lies_under_the_hand(position):
    rng = random.Random(position)
    for _ in range(30):
        bench = Bench()
        bench.cc(0, POSITION, position)
        key = OPEN[rng.randrange(6)] + rng.randint(position, position + 3)
        bench.on(100, key)
        ((_, fret),) = places(bench).values()
        assert fret == 0 or position <= fret < position + 4
        assert bench.hand == position and bench.counters["forces_refused"] == 0
        assert bench.counters["hand_shift_frets"] == position - 1


def test_a_note_that_a_position_does_not_have_is_played_elsewhere_and_counted():
    bench = Bench()
    bench.cc(0, POSITION, 9)
    bench.on(100, 41)
    assert places(bench) == {41: (6, 1)} and bench.counters["forces_refused"] == 1 and bench.hand == 1


def test_another_guitar_goes_on_with_what_was_forced():
    old, new = Bench(), Bench()
    old.cc(0, STRING, 4, channel=5)
    old.cc(0, POSITION, 7, channel=5)
    transfer_player(old.d, old.i, new.d, new.i, 100, 1.0)
    assert int(new.i[at.C_STRING + 5]) == 4 and int(new.i[at.C_POSITION + 5]) == 7
    new.on(1000, 59, channel=5)
    assert places(new) == {59: (4, 9)} and new.hand == 7
    assert np.count_nonzero(new.i[at.C_STRING : at.C_STRING + at.CHANNELS]) == 1
