"""Harmonics and muting: which string is stopped where, what touches it, and when that leaves."""

import random

import pytest
from player_bench import RATE, Bench

from ukrt.engine import controller_layout as cc
from ukrt.engine import gestures as do


def touches(bench):
    return [(frame, s, p) for frame, kind, s, p in bench.gestures if kind == do.TOUCH]


@pytest.mark.parametrize(
    "key, string, fret, partial",
    [(52, 0, 0, 2), (59, 0, 0, 3), (64, 1, 0, 3), (79, 3, 0, 4), (73, 1, 0, 5), (60, 1, 3, 2), (70, None, None, 2)],
)
def test_a_harmonic_is_the_lowest_partial_of_an_open_string_or_the_octave_of_a_stopped_one(key, string, fret, partial):
    bench = Bench()
    bench.cc(0, cc.HARMONIC, 127)
    bench.on(100, key)
    bench.run(9000)
    (note,) = bench.log
    s, fret = (note["string"], note["fret"]) if string is None else (string, fret)
    assert (note["string"], note["fret"], note["articulation"]) == (s, fret, "harmonic")
    assert bench.open[s] + fret == key - {2: 12, 3: 19, 4: 24, 5: 28}[partial]
    (down, _, p), (up, _, q) = touches(bench)
    length, hand = bench.guitar.strings[s].length, bench.guitar.articulation
    stopped = bench.places[s][fret] / length
    assert p[0] == pytest.approx(stopped + (1.0 - stopped) / partial) and p[2] == hand.touch_resistance
    assert (down, up, q[2]) == (100, 100 + bench.lead + round(hand.touch_time * RATE), 0.0)


def test_the_hands_edge_stays_until_the_damper_comes_or_another_note():
    bench = Bench()
    bench.cc(0, cc.MUTE, 127)
    bench.on(100, 45)
    bench.off(9000, 45)
    bench.run(60000)
    ((down, _, p),) = touches(bench)
    assert down == 100 and p[2] == bench.guitar.articulation.mute_resistance and bench.log[0]["articulation"] == "muted"
    bench.on(60100, 45)
    bench.cc(70000, cc.MUTE, 0)
    bench.on(70000, 45)
    bench.run(80000)
    assert [(frame, p[2] > 0.0) for frame, _, p in touches(bench)[1:]] == [(60100, True), (70000, False)]
    assert bench.log[-1]["articulation"] == "pluck"


def test_a_harmonic_ends_with_its_key_and_an_early_end_takes_the_touch_along():
    bench = Bench()
    bench.cc(0, cc.HARMONIC, 127)
    bench.on(100, 64)
    bench.off(600, 64)
    bench.finish()
    assert bench.held() == {} and len(touches(bench)) == 1  # the damper comes in its place
    assert bench.counters["notes_off_unmatched"] == 0


@pytest.mark.parametrize("seed", range(4))
def test_random_touches_leave_nothing_behind(seed):
    """Touched strings end touched by nothing: what is down leaves by itself, by the damper or for the next note."""
    rng, frame = random.Random(seed), 0
    bench = Bench(tick=seed % 2 == 0)
    for _ in range(2000):
        frame += rng.choice((0, 0, 3, 64, 480, 2000, 9000))
        what, key, channel = rng.random(), rng.randint(40, 84), rng.randrange(2)
        if what < 0.5:
            bench.send(frame, 0x90 | channel, key, rng.randint(1, 127))
        elif what < 0.75:
            bench.send(frame, 0x80 | channel, key, 0)
        else:
            number = rng.choice((cc.HARMONIC, cc.MUTE, cc.LEGATO, cc.GLIDE, cc.PEDAL, cc.SOUND_OFF, cc.RESET))
            bench.cc(frame, number, rng.choice((0, 0, 127)), channel)
    for channel in range(2):
        bench.cc(frame + 500, cc.PEDAL, 0, channel)
        bench.cc(frame + 500, cc.NOTES_OFF, 0, channel)
    bench.finish()
    for string in bench.strings:
        down = False
        for _, kind, p in string.events:
            if kind == do.TOUCH:
                down = p[2] > 0.0
            elif kind == do.DAMP:
                down = False
        assert not down and not string.damped and string.place == 0.0
    assert {"harmonic", "muted", "pluck"} <= {note["articulation"] for note in bench.log}
    assert bench.counters["gestures_refused"] == 0
