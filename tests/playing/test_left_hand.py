"""Trills by a held key, muting and half lifts that sounding notes follow, glissandi over frets, release velocities."""

import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from player_bench import RATE, Bench

from ukrt.engine import controller_layout as cc
from ukrt.engine import gestures as do
from ukrt.engine import player_layout as at
from ukrt.playing.rules import damp_times, loose_curve


def bench_with(*controllers):
    bench = Bench()
    for controller in controllers:
        bench.cc(0, controller, 127)
    return bench


def gestures_from(bench, frame, *kinds):
    return [(when, kind, p) for when, kind, _, p in bench.gestures if when >= frame and kind in kinds]


def ways(bench):
    return [note["articulation"] for note in bench.log]


def test_a_trill_by_a_held_key_alternates_hammer_ons_and_pull_offs():
    bench = bench_with(cc.LEGATO)
    bench.on(0, 45, 90)
    for k in range(5):
        bench.on(9000 + 6000 * k, 47, 60)
        assert list(bench.held().values()) == [(47, 0, 2)]
        bench.off(12000 + 6000 * k, 47)
        assert list(bench.held().values()) == [(45, 0, 0)]
    bench.off(60000, 45)
    assert bench.held() == {}
    bench.finish()
    assert ways(bench) == ["pluck"] + ["hammer-on", "pull-off"] * 5 and len(bench.plucks()) == 1
    counted = bench.counters
    assert counted["notes_on"] == counted["notes_played"] == 6 and counted["notes_resumed"] == 5
    assert counted["notes_off_unmatched"] == 0
    back = bench.log[2]
    assert (back["midi"], back["fret"], back["time_s"], back["end_s"]) == (45, 0, 12000 / RATE, 15000 / RATE)
    assert back["force_n"] == bench.log[0]["force_n"] and back["fate"] == "slurred"
    assert bench.log[1]["fate"] == "played" and bench.log[1]["end_s"] == 12000 / RATE


def test_the_string_goes_back_to_the_held_note_that_began_last():
    bench = bench_with(cc.LEGATO)
    for frame, key in ((0, 45), (9000, 47), (18000, 48)):
        bench.on(frame, key)
    bench.off(27000, 47)  # let go while another sounds: no more than that
    assert list(bench.held().values()) == [(48, 0, 3)]
    bench.off(36000, 48)
    assert list(bench.held().values()) == [(45, 0, 0)]
    bench.finish()
    assert bench.strings[1].place == 0.0 and not bench.strings[1].damped


def test_down_to_a_finger_that_stayed_and_up_to_one_that_hammers_again():
    bench = bench_with(cc.LEGATO)
    bench.on(0, 48)
    bench.on(9000, 46)
    bench.off(18000, 46)
    bench.finish()
    ((frame, kind, p),) = gestures_from(bench, 18000, do.PRESS, do.LIFT)
    assert (frame, kind) == (18000 + bench.lead, do.PRESS) and p[0] == bench.places[1][3] and p[2] > 0.0
    assert ways(bench) == ["pluck", "pull-off", "hammer-on"]


@pytest.mark.parametrize("ends", ["pedal", "sostenuto", "legato off", "out of reach", "another string"])
def test_nothing_is_gone_back_to(ends):
    bench = bench_with(cc.LEGATO)
    bench.on(0, 45)
    bench.on(9000, 47)
    if ends == "pedal":
        bench.cc(10000, cc.PEDAL, 127)
    elif ends == "sostenuto":
        bench.cc(10000, cc.SOSTENUTO, 127)
    elif ends == "legato off":
        bench.cc(10000, cc.LEGATO, 0)
    elif ends == "out of reach":
        bench.off(9500, 45)
        bench.on(9600, 50)
        bench.off(9700, 47)
    else:
        bench.cc(9500, cc.STRING, 1)
        bench.on(9600, 64)
        bench.off(9650, 64)
    last = 50 if ends == "out of reach" else 47
    bench.off(18000, last)
    left = {"pedal": [47], "sostenuto": [47], "another string": [45]}.get(ends, [])
    assert [key for key, *_ in bench.held().values()] == left
    assert bench.counters["notes_resumed"] == (1 if ends == "another string" else 0)


def test_a_string_remembers_four_keys_and_counts_what_it_forgets():
    bench = bench_with(cc.LEGATO)
    for k, key in enumerate((45, 46, 47, 48, 49, 48, 47)):
        bench.on(9000 * k, key)
    assert bench.counters["holds_forgotten"] == 2
    for k, key in enumerate((47, 48, 49, 48, 47, 46, 45)):
        bench.off(90000 + 9000 * k, key)
    assert bench.held() == {} and bench.counters["notes_off_unmatched"] == 0


def test_portamento_slides_back():
    bench = bench_with(cc.GLIDE)
    bench.on(0, 47)
    bench.on(9000, 50)
    bench.off(30000, 50)
    bench.finish()
    assert ways(bench) == ["pluck", "slide", "slide"] and bench.strings[1].place == bench.places[1][2]


def test_release_velocity_says_how_quickly_the_damper_comes():
    ramps = {}
    for velocity in (0, 1, 30, 64, 100, 127):
        bench = Bench()
        bench.on(0, 45)
        bench.send(9000, 0x80, 45, velocity)
        bench.finish()
        (damp,) = gestures_from(bench, 0, do.DAMP)
        lifted = [frame for frame, *_ in gestures_from(bench, 0, do.UNDAMP)]
        assert lifted[-1] >= damp[0] + damp[2][1] + round(0.15 * RATE)
        ramps[velocity] = damp[2][1]
    usual = round(bench.guitar.damper.attack_time * RATE)
    assert ramps[0] == ramps[64] == usual and ramps[127] == usual // 4 and ramps[1] == 4 * usual
    assert ramps[1] > ramps[30] > ramps[64] > ramps[100] > ramps[127]
    assert damp_times(0.008)[64] == 0.008


def test_the_hands_edge_follows_its_controller_on_notes_that_sound():
    bench = Bench()
    bench.on(0, 45)
    for frame, value in ((9000, 127), (9001, 64), (9200, 20), (20000, 0)):
        bench.cc(frame, cc.MUTE, value)
    bench.run(40000)
    touches = gestures_from(bench, 0, do.TOUCH)
    curve = bench.d[at.D_MUTE : at.D_MUTE + 128]
    slot = int(bench.i[at.I_BEND_SLOT])
    assert [frame for frame, *_ in touches] == [9000 + bench.lead, 9200 + bench.lead, 20000 + bench.lead] and slot < 200
    assert [p[2] for *_, p in touches] == [curve[64], curve[20], 0.0]
    assert ways(bench) == ["pluck"]


def test_a_harmonics_node_is_left_before_the_hand_mutes():
    bench = bench_with(cc.HARMONIC)
    bench.on(0, 64)
    bench.cc(100, cc.MUTE, 127)
    bench.run(40000)
    (_, _, node), (leaves, _, away), (mutes, _, edge) = gestures_from(bench, 0, do.TOUCH)
    assert away[2] == 0.0 and mutes > leaves + away[1] and edge[0] == at.MUTE_PLACE != node[0]


def test_a_half_lift_takes_the_finger_off_the_fret_and_puts_it_back():
    bench = Bench()
    bench.on(0, 48)
    bench.cc(9000, cc.LOOSE, 127)
    bench.cc(9300, cc.LOOSE, 40)
    bench.cc(20000, cc.LOOSE, 0)
    bench.run(40000)
    eased = gestures_from(bench, 9000, do.TOUCH, do.LIFT, do.PRESS)
    assert [kind for _, kind, _ in eased] == [do.TOUCH, do.LIFT, do.TOUCH, do.TOUCH, do.PRESS]
    place = (bench.places[1][3] + at.LOOSE_OFFSET) / bench.guitar.strings[1].length
    assert eased[0][2][0] == pytest.approx(place) and eased[0][2][2] == loose_curve()[127] == 2.0
    assert eased[2][2][2] == loose_curve()[40] and eased[3][2][2] == 0.0
    assert bench.strings[1].place == bench.places[1][3]


def test_half_lifted_fingers_do_not_stop_notes_to_come_and_open_strings_ring_on():
    bench = bench_with(cc.LOOSE)
    bench.on(0, 48)
    bench.on(0, 64)
    bench.run(9000)
    assert bench.strings[1].place == 0.0 and {s for _, kind, s, _ in bench.gestures if kind == do.TOUCH} == {1}
    bench.on(9000, 48)  # the finger comes down anew, and loosens again
    bench.run(18000)
    assert [kind for _, kind, _ in gestures_from(bench, 9000, do.PRESS, do.LIFT)] == [do.PRESS, do.LIFT]
    bench.off(18000, 48)
    bench.finish()
    assert bench.strings[1].place == 0.0 and not bench.strings[1].damped


@pytest.mark.parametrize("first, last, seconds", [(46, 53, 2.0), (53, 46, 0.03), (47, 48, 2.0), (46, 64, 0.03)])
def test_a_glissando_stops_the_string_at_each_fret_in_its_turn(first, last, seconds):
    bench = bench_with(cc.GLIDE, cc.FRETS)
    bench.cc(0, cc.GLIDE_TIME, 0 if seconds < 1.0 else 127)
    bench.cc(0, cc.STRING, 5)
    bench.on(0, first)
    bench.on(9000, last)
    bench.finish()
    landings = gestures_from(bench, 9000, do.PRESS)
    s, way = bench.log[1]["string"], 1 if last > first else -1
    frets = range(first - bench.open[s] + way, last - bench.open[s] + way, way)
    assert [p[0] for *_, p in landings] == [bench.places[s][fret] for fret in frets]
    steps = {b[0] - a[0] for a, b in zip(landings, landings[1:], strict=False)}
    frames = round(seconds * RATE)
    assert landings[0][0] == 9000 + bench.lead and len(steps) < 2
    assert all(p[1] <= step == frames // len(landings) for step in steps for *_, p in landings)
    assert ways(bench) == ["pluck", "slide"]


def test_a_glissando_that_is_cut_short_leaves_the_finger_where_it_had_come_to():
    bench = bench_with(cc.GLIDE, cc.FRETS)
    bench.cc(0, cc.GLIDE_TIME, 127)
    bench.on(0, 46)
    bench.on(9000, 56)
    bench.run(9000 + bench.lead + 3 * 9600 + 10)  # four of ten frets, one in 0.2 s
    assert bench.strings[1].place == bench.places[1][5]
    for key in (46, 56):
        bench.off(bench.frame, key)
    bench.run(bench.frame + 7000)
    assert bench.strings[1].damped and bench.strings[1].place == bench.places[1][5]
    bench.finish()
    assert bench.strings[1].place == 0.0, "the finger of a glissando that was given up goes on"


_NUMBERS = (1, 5, 17, 19, 19, 20, 27, 27, 28, 64, 65, 65, 68, 68, 68, 121, 123, 120)
_MESSAGES = st.lists(
    st.tuples(
        st.sampled_from((0, 0, 1, 63, 130, 480, 481, 3000, 20000)),
        st.sampled_from((0x90, 0x90, 0x90, 0x80, 0x80, 0xB0, 0xB0)),
        st.integers(0, 1),
        st.integers(44, 60),
        st.sampled_from(_NUMBERS),
        st.sampled_from((0, 1, 40, 64, 127)),
    ),
    max_size=120,
)


def finish(bench):
    """Every key comes up; then nothing sounds, nothing touches or stops a string, no key is thought to be down."""
    for channel in range(2):
        bench.cc(bench.frame + 100, cc.PEDAL, 0, channel)
        bench.cc(bench.frame, cc.NOTES_OFF, 0, channel)
    assert bench.held() == {} and bench.counters["gestures_refused"] == 0
    bench.finish()
    assert not bench.i[at.S_HOLDS : at.S_HOLDS + 6].any()
    assert not bench.i[at.I_OWED : at.I_OWED + 2 * 128].any()
    for string in bench.strings:
        assert touch_of(string) is None and not string.damped and string.place == 0.0 and string.tension == 1.0
    counted = bench.counters
    assert counted["notes_on"] + counted["notes_resumed"] == len(bench.log)


def touch_of(string):
    """Where something touches the string (share of L); None: nowhere."""
    down = None
    for _, kind, p in string.events:
        if kind in (do.TOUCH, do.DAMP):
            down = p[0] if kind == do.TOUCH and p[2] > 0.0 else None
    return down


@given(_MESSAGES, st.booleans())
@settings(max_examples=60, deadline=None)
def test_whatever_the_left_hand_does_nothing_sticks(messages, tick):
    bench, frame = Bench(tick=tick), 0
    bench.cc(0, cc.LEGATO, 127)
    for step, kind, channel, key, number, value in messages:
        frame += step
        bench.send(frame, kind | channel, number if kind == 0xB0 else key, value)
    finish(bench)


@pytest.mark.parametrize("seed", range(4))
def test_in_every_pause_fingers_and_hands_are_where_notes_and_controllers_want_them(seed):
    rng, checked, frame = random.Random(seed), 0, 0
    bench = Bench(tick=seed % 2 == 0)
    bench.cc(0, cc.LEGATO, 127)
    for _ in range(120):
        for _ in range(rng.randint(1, 12)):
            frame += rng.choice((0, 0, 3, 130, 480, 3000, 20000))
            kind, channel = rng.choice((0x90, 0x90, 0x80, 0xB0, 0xB0)), rng.randrange(2)
            first = rng.choice((5, 19, 20, 27, 27, 28, 64, 65, 68, 68, 121)) if kind == 0xB0 else rng.randint(44, 62)
            bench.send(frame, kind | channel, first, rng.choice((0, 40, 64, 127)))
        frame += 120000  # longer than any slide
        bench.run(frame)
        for s, (_, channel, fret) in bench.held().items():
            loose, mute = (bench.i[row + channel] for row in (at.C_LOOSE, at.C_MUTE))
            stopped = bench.places[s][fret] if fret and not loose else 0.0
            lying = at.MUTE_PLACE if mute > 0 else None
            if fret and loose:
                lying = (bench.places[s][fret] + at.LOOSE_OFFSET) / bench.guitar.strings[s].length
            assert bench.strings[s].place == stopped and touch_of(bench.strings[s]) == pytest.approx(lying)
            checked += 1
    finish(bench)
    assert checked > 100 and bench.counters["notes_resumed"] > 0


@given(
    st.lists(st.tuples(st.booleans(), st.integers(45, 52)), min_size=2, max_size=5, unique_by=lambda one: one[1]),
    st.permutations(range(5)),
    st.sampled_from((0, 127)),
)
@settings(max_examples=50, deadline=None)
def test_keys_of_one_frame_mean_the_same_in_any_order(messages, order, loose):
    """Whatever comes up and goes down together, over held notes: what sounds then does not depend on the order."""
    outcomes = []
    for numbers in (range(5), order):
        bench = bench_with(cc.LEGATO)
        bench.cc(0, cc.LOOSE, loose)
        for frame, key in ((0, 45), (9000, 47), (18000, 48), (18000, 52)):
            bench.on(frame, key)
        for down, key in (messages[n] for n in numbers if n < len(messages)):
            (bench.on if down else bench.off)(30000, key)
        bench.run(60000)
        places = [(string.place, string.damped, touch_of(string)) for string in bench.strings]
        lasting = [note for note in bench.log if note["end_s"] != note["time_s"]]
        log = sorted(str([n[k] for k in ("midi", "string", "articulation", "fate", "end_s")]) for n in lasting)
        outcomes.append((bench.held(), places, log))
        finish(bench)
    assert outcomes[0] == outcomes[1]


@pytest.mark.parametrize("back", [1, 30, 400])
def test_a_half_lift_that_is_taken_back_before_it_began_leaves_no_finger_behind(back):
    """Found by a storm: the finger that had not lifted was taken for one that had, and stayed under an open string."""
    bench = Bench()
    bench.cc(0, cc.STRING, 1)
    bench.on(0, 69)
    bench.cc(20_000, cc.LOOSE, 100)
    bench.cc(20_000 + back, cc.LOOSE, 0)
    bench.on(20_000 + back + 5, 64)
    bench.off(40_000, 64)
    bench.off(40_000, 69)
    bench.run(20_000 + back + 400)
    assert bench.strings[5].place == 0.0
    bench.finish()
    assert bench.strings[5].place == 0.0 and bench.i[at.S_FINGER + 5] == 0
