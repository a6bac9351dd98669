"""What the player asks of the strings: dampers, fingers, plucks and their times."""

import random

import pytest
from player_bench import RATE, Bench, check_plucks

from ukrt.engine import gestures as do
from ukrt.engine import player_layout as at


def kinds(bench, s):
    return [(frame, kind) for frame, kind, string, _ in bench.gestures if string == s]


def test_a_fretted_note_from_pluck_to_open_string():
    bench = Bench()
    bench.on(1000, 60, 100)
    bench.off(20000, 60)
    bench.finish()
    s = bench.log[0]["string"]
    settle, gap, lead = (int(bench.i[k]) for k in (at.I_SETTLE, at.I_GAP, at.I_LEAD))
    off = 20000 + lead
    start = [(1000, do.PRESS), (1000, do.PLUCK)]
    assert kinds(bench, s) == [*start, (off, do.DAMP), (off + settle, do.LIFT), (off + settle + gap, do.UNDAMP)]
    assert lead == round(bench.guitar.pluck.duration * RATE)
    (press,) = [p for _, kind, _, p in bench.gestures if kind == do.PRESS]
    assert press[0] == bench.places[s][bench.log[0]["fret"]] and press[1] < lead
    ((_, _, pluck),) = bench.plucks()
    pluck_model = bench.guitar.pluck
    assert pluck[:4] == (pluck_model.place, bench.log[0]["force_n"], pluck_model.angle, lead)
    assert bench.log[0]["release_frame"] == 1000 + lead and bench.log[0]["end_s"] == 20000 / RATE


def test_an_open_note_needs_no_finger():
    bench = Bench()
    bench.on(0, 40)
    bench.off(9000, 40)
    bench.finish()
    assert [kind for _, kind in kinds(bench, 0)] == [do.PLUCK, do.DAMP, do.UNDAMP]


def test_a_new_note_cancels_the_end_of_the_old_one_and_takes_the_damper_off():
    bench = Bench({"playing.frets": "0"})
    bench.on(0, 40)
    bench.off(10000, 40)
    bench.on(12000, 40)
    bench.finish()
    lead = bench.lead
    wanted = [(0, do.PLUCK), (10000 + lead, do.DAMP), (12000, do.UNDAMP), (12000, do.PLUCK)]
    assert kinds(bench, 0) == wanted


def test_a_note_off_that_has_not_acted_yet_never_acts_once_the_string_is_plucked_again():
    bench = Bench()
    bench.on(0, 40)
    bench.off(10000, 40)
    bench.on(10000, 40)
    bench.finish()
    assert [kind for _, kind in kinds(bench, 0)] == [do.PLUCK, do.PLUCK]


def test_the_finger_stays_for_the_same_fret_and_is_lifted_for_another():
    bench = Bench()
    bench.on(0, 41)
    bench.on(8000, 41)
    bench.off(16000, 41)
    bench.off(16000, 41)
    bench.on(16000, 42)
    bench.finish()
    assert [kind for _, kind in kinds(bench, 0)] == [do.PRESS, do.PLUCK, do.PLUCK, do.LIFT, do.PLUCK, do.PRESS]


def test_a_note_that_ends_when_it_begins_is_plucked_and_damped_at_its_release():
    bench = Bench()
    bench.on(500, 40)
    bench.off(500, 40)
    bench.finish()
    assert kinds(bench, 0)[:2] == [(500, do.PLUCK), (500 + bench.lead, do.DAMP)]
    assert bench.log[0]["fate"] == "played" and bench.log[0]["end_s"] == 500 / RATE


def random_playing(rng, messages=1500):
    """Chords, offs, pedal and bends, often in the same frame and in any order."""
    frame = 0
    for _ in range(messages):
        frame += rng.choice((0, 0, 0, 3, 64, 480, 2000, 9000))
        what, channel = rng.random(), rng.randrange(3)
        key = rng.randint(38, 90) if rng.random() < 0.5 else rng.randint(50, 60)
        if what < 0.45:
            yield frame, (0x90 | channel, key, rng.randint(1, 127))
        elif what < 0.85:
            yield frame, (0x80 | channel, key, 64)
        elif what < 0.93:
            yield frame, (0xB0 | channel, 64, rng.choice((0, 127)))
        else:
            yield frame, (0xE0 | channel, rng.randrange(128), rng.randrange(128))


@pytest.mark.parametrize("idle", ["open", "damped"])
@pytest.mark.parametrize("seed", range(5))
def test_random_playing_leaves_every_string_as_it_should_be(seed, idle):
    rng = random.Random(seed)
    bench = Bench({"playing.idle_strings": idle}, tick=seed % 2 == 0)
    bends, checked = [0] * 3, 0
    for frame, message in random_playing(rng):
        if frame > bench.frame + 2 * bench.lead:
            bench.run(frame)
            for s, (_, channel, _) in bench.held().items():
                assert bench.strings[s].tension == pytest.approx(2 ** (bends[channel] / 8192 * 2 / 6), rel=1e-12)
                checked += 1
        bench.send(frame, *message)
        if message[0] & 0xF0 == 0xE0:
            bends[message[0] & 15] = message[2] * 128 + message[1] - 8192
    assert checked > 300
    last = bench.frame + 500
    for channel in range(3):
        bench.cc(last, 64, 0, channel)
        bench.cc(last, 123, 0, channel)
    assert bench.held() == {}
    bench.finish()
    check_plucks(bench)
    assert len(bench.plucks()) == bench.counters["notes_played"] > 300
    assert bench.counters["gestures_refused"] == 0
    for string in bench.strings:
        assert string.place == 0.0 and string.tension == 1.0 and string.sounding == -1
        assert string.damped == (idle == "damped")


def test_idle_strings_are_damped_from_the_start_where_the_preset_says_so():
    bench = Bench({"playing.idle_strings": "damped"}, tick=True)
    bench.run(64)
    assert all(string.damped for string in bench.strings)
    bench.on(100, 45)
    bench.run(101)
    assert [string.damped for string in bench.strings] == [True, False, True, True, True, True]


def test_when_time_is_told_to_the_player_does_not_matter():
    runs = []
    for tick in (False, True):
        bench = Bench(tick=tick)
        for frame, message in random_playing(random.Random(99), 600):
            bench.send(frame, *message)
        bench.run(bench.frame + 48000)
        runs.append(bench.gestures)
    assert runs[0] == runs[1]
