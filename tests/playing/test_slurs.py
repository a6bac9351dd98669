"""Hammer-ons, pull-offs and slides: when a note is slurred, on which string, and what the hands are asked to do."""

import random

import pytest
from player_bench import RATE, Bench

from ukrt.engine import controller_layout as cc
from ukrt.engine import gestures as do
from ukrt.engine import player_layout as at


def slurring(*controllers, **settings):
    bench = Bench(settings or None)
    for controller in controllers or (cc.LEGATO,):
        bench.cc(0, controller, 127)
    return bench


def after(bench, frame):
    """What each gesture from ``frame`` on was, of the bench's string of the last note."""
    s = bench.log[-1]["string"]
    return [(at_frame, kind, p) for at_frame, kind, string, p in bench.gestures if string == s and at_frame >= frame]


def ways(bench):
    return [note["articulation"] for note in bench.log]


def test_overlapping_notes_are_plucked_unless_legato_is_on():
    bench = Bench()
    bench.on(0, 45)
    bench.on(9000, 47)
    assert ways(bench) == ["pluck", "pluck"] and len(bench.held()) == 2


def test_a_higher_note_is_hammered_on_when_a_pluck_would_have_released():
    bench = slurring()
    bench.on(0, 45)
    bench.on(9000, 47, 127)
    bench.finish()
    ((frame, kind, p),) = after(bench, 9000)
    s = bench.log[1]["string"]
    hand = bench.guitar.articulation
    assert (frame, kind) == (9000 + bench.lead, do.PRESS) and p[0] == bench.places[s][2]
    assert p[1] == round(hand.hammer_time * RATE) and p[2] == pytest.approx(hand.hammer_speed, abs=1e-5)
    assert ways(bench) == ["pluck", "hammer-on"]
    assert bench.log[0]["fate"] == "slurred" and bench.log[0]["end_s"] == 9000 / RATE
    assert bench.counters["notes_slurred"] == 1 and bench.counters["notes_stolen"] == 0
    assert bench.held() == {s: (47, 0, 2)}


def test_a_soft_hammer_is_slower_as_a_soft_pluck_is_weaker():
    speeds, forces = [], []
    for velocity in (127, 40):
        bench = slurring()
        bench.on(0, 45)
        bench.on(9000, 47, velocity)
        bench.finish()
        speeds.append(after(bench, 9000)[0][2][2])
        forces.append(bench.log[1]["force_n"])
    assert speeds[1] / speeds[0] == pytest.approx(forces[1] / forces[0], rel=1e-4)


def test_a_lower_note_is_pulled_off_to_the_open_string_or_to_a_finger_that_is_there():
    for key, fret in ((45, 0), (46, 1)):
        bench = slurring()
        bench.on(0, 47)
        bench.on(9000, key, 127)
        bench.finish()
        (frame, kind, p), *rest = after(bench, 9000)
        hand = bench.guitar.articulation
        assert (frame, kind, p[1:4]) == (9000, do.LIFT, (bench.lead, hand.pull_force, hand.pull_angle))
        assert [(at_frame, kind, p[2]) for at_frame, kind, p in rest] == (
            [(9000 + bench.lead, do.PRESS, 0.0)] if fret else []
        )
        assert ways(bench) == ["pluck", "pull-off"]


def test_a_trill_goes_on_one_string_and_ends_with_its_last_key():
    bench = slurring()
    bench.on(0, 47)
    for k in range(10):
        old, new = (47, 48) if k % 2 == 0 else (48, 47)
        bench.on(9000 + 5000 * k, new)
        bench.off(9500 + 5000 * k, old)
        assert list(bench.held().values()) == [(new, 0, new - 45)]
    assert ways(bench) == ["pluck"] + ["hammer-on", "pull-off"] * 5
    bench.off(60000, 47)
    assert bench.held() == {}
    bench.finish()
    assert bench.counters["notes_off_unmatched"] == 0 and len(bench.plucks()) == 1


def test_out_of_reach_is_plucked():
    bench = slurring()
    bench.on(0, 46)
    bench.on(9000, 53)
    assert ways(bench) == ["pluck", "pluck"] and len(bench.held()) == 2


def test_only_held_notes_of_the_same_channel_are_slurred():
    bench = slurring()
    bench.on(0, 47, channel=1)
    bench.on(9000, 48)
    bench.off(15000, 48)
    bench.on(20000, 49)
    assert ways(bench) == ["pluck"] * 3


def test_portamento_slides_between_stopped_notes_in_the_time_it_is_given():
    for value, seconds in ((None, 0.1), (0, 0.03), (127, 2.0)):
        bench = slurring(cc.GLIDE)
        if value is not None:
            bench.cc(0, cc.GLIDE_TIME, value)
        bench.on(0, 47)
        bench.on(9000, 54)
        bench.finish()
        ((frame, kind, p),) = after(bench, 9000)
        s = bench.log[1]["string"]
        assert (frame, kind, p[1], p[2]) == (9000 + bench.lead, do.PRESS, round(seconds * RATE), 0.0)
        assert p[0] == bench.places[s][54 - bench.open[s]] and ways(bench) == ["pluck", "slide"]
    bench = slurring(cc.GLIDE)
    bench.on(0, 45)
    bench.on(9000, 47)
    assert ways(bench) == ["pluck", "pluck"], "an open string cannot be slid from"


def test_notes_of_one_frame_are_slurred_alike_in_any_order():
    chord, outcomes = [47, 52, 60, 49], set()
    for seed in range(12):
        random.Random(seed).shuffle(chord)
        bench = slurring()
        bench.on(0, 45)
        bench.on(0, 50)
        for key in chord:
            bench.on(9000, key)
        bench.finish()
        outcomes.add(tuple(sorted((n["midi"], n["string"], n["articulation"], n["fate"]) for n in bench.log)))
        gestures = {s: [(k, p[:4]) for _, k, string, p in bench.gestures if string == s] for s in range(6)}
        assert sum(len(row) for row in gestures.values()) == len(bench.gestures)
    assert len(outcomes) == 1
    assert {"hammer-on"} <= {note[2] for note in outcomes.pop()}


def test_reset_ends_slurring_but_leaves_the_sound():
    bench = slurring(cc.LEGATO, cc.GLIDE)
    bench.cc(0, cc.PLACE, 127)
    bench.cc(0, cc.RESET, 0)
    bench.on(0, 45)
    bench.on(9000, 47)
    assert ways(bench) == ["pluck", "pluck"]
    assert bench.gestures[0][3][0] == at.PLACE_BRIDGE


def random_slurs(rng, messages):
    frame = 0
    for _ in range(messages):
        frame += rng.choice((0, 0, 3, 64, 200, 480, 481, 2000, 9000))
        what, channel, value = rng.random(), rng.randrange(2), rng.randrange(128)
        if what < 0.5:
            yield frame, (0x90 | channel, rng.randint(44, 70), rng.randint(1, 127))
        elif what < 0.8:
            yield frame, (0x80 | channel, rng.randint(44, 70), 64)
        elif what < 0.98:
            numbers = (1, 5, 16, 64, 65, 65, 68, 68, 68, 74)
            yield frame, (0xB0 | channel, rng.choice(numbers), value)
        else:
            yield frame, (0xB0 | channel, rng.choice((120, 121, 123)), 0)


@pytest.mark.parametrize("seed", range(6))
def test_whatever_is_slurred_the_finger_is_where_the_note_wants_it_and_nothing_sticks(seed):
    rng = random.Random(seed)
    bench, checked = Bench(tick=seed % 2 == 0), 0
    for frame, message in random_slurs(rng, 2000):
        if frame > bench.frame + 2 * bench.lead:
            bench.run(frame)
            for s, (_, _, fret) in bench.held().items():
                assert bench.strings[s].place == (bench.places[s][fret] if fret else 0.0)
                assert not bench.strings[s].damped
                checked += 1
        bench.send(frame, *message)
    last = bench.frame + 500
    for channel in range(2):
        bench.cc(last, 64, 0, channel)
        bench.cc(last, 123, 0, channel)
    assert bench.held() == {}
    bench.finish()
    assert checked > 200 and bench.counters["notes_slurred"] > 100
    assert {"hammer-on", "pull-off", "slide", "pluck"} == set(ways(bench))
    assert bench.counters["gestures_refused"] == 0
    assert all(string.place == 0.0 and string.tension == 1.0 and not string.damped for string in bench.strings)
