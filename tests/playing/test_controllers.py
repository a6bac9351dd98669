"""Pedal, pitch bend, registered parameters, and the messages that end all notes."""

import random

import pytest
from player_bench import Bench, check_plucks

from ukrt.engine import gestures as do
from ukrt.engine import player_layout as at
from ukrt.engine.kernels.player import player_reset


def tension_after(bench, s, bend, channel=0):
    bench.bend(bench.frame + 5000, bend, channel)
    bench.run(bench.frame + 5000)
    return bench.strings[s].tension


def rpn(bench, msb, lsb, coarse, fine=None, channel=0):
    frame = bench.frame + 10
    for controller, value in ((101, msb), (100, lsb), (6, coarse), (38, fine)):
        if value is not None:
            bench.cc(frame, controller, value, channel)


def test_the_pedal_lets_notes_ring_until_it_comes_up():
    bench = Bench()
    bench.cc(0, 64, 64)
    bench.on(100, 40)
    bench.on(100, 60)
    bench.off(5000, 40)
    assert len(bench.held()) == 2
    bench.cc(9000, 64, 63)
    assert next(iter(bench.held().values()))[0] == 60 and len(bench.held()) == 1
    bench.run(9000 + bench.lead + 1)
    assert bench.gestures[-1][:3] == (9000 + bench.lead, do.DAMP, 0)
    assert bench.log[0]["end_s"] == 9000 / 48000 and bench.log[1]["end_s"] is None


def test_a_pedalled_note_gives_up_its_string_before_a_held_one_does():
    bench = Bench()
    bench.cc(0, 64, 127)
    for key in (40, 45, 50, 55, 59, 64):
        bench.on(10, key)
    bench.off(20, 50)
    bench.on(5000, 57)
    fates = {note["midi"]: note["fate"] for note in bench.log}
    assert fates.pop(50) == "stolen" and set(fates.values()) == {"played"}
    assert bench.counters["notes_stolen"] == 1


def test_of_held_notes_the_one_plucked_longest_ago_gives_way():
    bench = Bench()
    for frame, key in enumerate((64, 40, 59, 45, 55, 50)):
        bench.on(1000 * frame, key)
    bench.on(9000, 65)
    assert [note["midi"] for note in bench.log if note["fate"] == "stolen"] == [64]
    assert bench.log[0]["end_s"] == 9000 / 48000


def test_bend_changes_tension_by_the_square_of_the_pitch_ratio():
    bench = Bench({"playing.bend_range_semitones": "2"})
    bench.on(0, 60)
    s = bench.log[0]["string"]
    assert tension_after(bench, s, 4096) == pytest.approx(2 ** (1 / 6), rel=1e-12)
    assert tension_after(bench, s, -8192) == pytest.approx(2 ** (-2 / 6), rel=1e-12)
    assert tension_after(bench, s, 0) == 1.0


@pytest.mark.parametrize("semitones", ["0", "0.5", "12"])
def test_the_presets_bend_range_holds_before_any_rpn(semitones):
    bench = Bench({"playing.bend_range_semitones": semitones})
    player_reset(bench.d, bench.i)
    bench.on(0, 60)
    assert tension_after(bench, bench.log[0]["string"], -8192) == pytest.approx(2 ** (-float(semitones) / 6), rel=1e-12)


def test_a_bend_moves_its_own_channels_strings_only_and_acts_with_the_notes_delay():
    bench = Bench()
    bench.on(0, 45, channel=1)
    bench.on(0, 59, channel=2)
    bench.bend(7000, 8191, channel=2)
    bench.finish()
    bends = [(frame, s) for frame, kind, s, _ in bench.gestures if kind == do.TENSION]
    assert bends == [(7000 + bench.lead, 4)]


def test_a_note_begins_with_its_channels_bend_and_ends_with_its_string_at_rest():
    bench = Bench()
    bench.bend(0, 4096)
    bench.on(100, 60)
    bench.run(101)
    s = bench.log[0]["string"]
    assert bench.strings[s].tension == pytest.approx(2 ** (1 / 6))
    bench.off(9000, 60)
    bench.finish()
    assert bench.strings[s].tension == 1.0
    assert [kind for _, kind, string, _ in bench.gestures if string == s][-3:] == [do.LIFT, do.TENSION, do.UNDAMP]


def test_dense_bends_cost_few_gestures_and_the_last_one_wins():
    bench = Bench()
    bench.on(0, 60)
    s = bench.log[0]["string"]
    for frame in range(1000, 25000, 3):
        bench.bend(frame, int(8000 * (frame - 13000) / 12000))
    bench.bend(25000, 1234)
    bench.finish()
    moves = [frame for frame, kind, _, _ in bench.gestures if kind == do.TENSION]
    slot = int(bench.i[at.I_BEND_SLOT])
    assert 24000 / slot / 2 < len(moves) <= 24000 / slot + 2
    assert min(b - a for a, b in zip(moves, moves[1:], strict=False)) >= slot
    assert bench.strings[s].tension == pytest.approx(2 ** (1234 / 8192 * 2 / 6), rel=1e-12)
    assert bench.counters["gestures_refused"] == 0 and max(moves) <= 25000 + bench.lead + slot


def test_the_bend_range_follows_rpn_0_with_cents_and_steps():
    bench = Bench()
    bench.on(0, 60, channel=3)
    s = bench.log[0]["string"]
    rpn(bench, 0, 0, 7, 50, channel=3)
    assert tension_after(bench, s, -8192, 3) == pytest.approx(2 ** (-7.5 / 6), rel=1e-12)
    for _ in range(10):
        bench.cc(bench.frame, 96, 0, 3)
    bench.cc(bench.frame, 97, 0, 3)
    bench.run(bench.frame + 2000)
    assert bench.strings[s].tension == pytest.approx(2 ** (-7.59 / 6), rel=1e-12)
    rpn(bench, 127, 127, 2, 0, channel=3)  # null: data entry means nothing
    rpn(bench, 0, 3, 2, 0, channel=3)  # tuning programme: there is only one
    bench.cc(bench.frame, 99, 0, 3)  # NRPN
    bench.cc(bench.frame, 6, 1, 3)
    assert tension_after(bench, s, -8192, 3) == pytest.approx(2 ** (-7.59 / 6), rel=1e-12)
    assert bench.counters["rpn_ignored"] == 4 and bench.counters["nrpn_ignored"] == 1


def test_bends_stop_at_an_octave_and_say_so():
    bench = Bench()
    bench.on(0, 60)
    s = bench.log[0]["string"]
    rpn(bench, 0, 0, 24, 0)
    assert tension_after(bench, s, -8192) == 0.25
    assert tension_after(bench, s, 8191) == 4.0
    assert bench.counters["bends_limited"] == 2


def test_all_notes_off_respects_the_pedal_and_all_sound_off_does_not():
    bench = Bench()
    bench.cc(0, 64, 127)
    bench.on(10, 60)
    bench.on(10, 50, channel=1)
    bench.cc(4000, 123, 0)
    assert len(bench.held()) == 2
    bench.cc(5000, 120, 0)
    assert [note[0] for note in bench.held().values()] == [50]
    assert bench.log[0]["fate"] == "silenced"
    bench.run(5001)
    assert {s for frame, kind, s, _ in bench.gestures if kind == do.DAMP and frame == 5000} == {0, 1, 3, 4, 5}
    for controller in (124, 125, 126, 127):
        bench.on(bench.frame + 9000, 62, channel=1)
        bench.cc(bench.frame + 9000, controller, 0, 1)
        assert bench.held() == {}


def test_all_sound_off_in_the_frame_of_a_note_still_damps_it():
    bench = Bench()
    bench.on(1000, 41)
    bench.off(1500, 41)
    bench.on(4000, 43)  # while the finger is still down at the first fret
    bench.cc(4000, 120, 0)
    bench.finish()
    check_plucks(bench)
    assert [kind for _, kind, s, _ in bench.gestures if s == 0][-6:-2] == [do.LIFT, do.PLUCK, do.DAMP, do.PRESS]
    bench.on(20000, 41)
    bench.cc(20000, 120, 0)
    bench.on(20000, 42)
    bench.cc(20000, 120, 0)
    bench.finish()
    assert bench.held() == {} and all(string.sounding == -1 and string.place == 0.0 for string in bench.strings)


def test_reset_controllers_lifts_the_pedal_and_the_bend_but_keeps_the_range():
    bench = Bench()
    rpn(bench, 0, 0, 12, 0)
    bench.cc(10, 64, 127)
    bench.bend(10, 8191)
    bench.on(20, 60)
    bench.on(20, 45)
    bench.off(3000, 45)
    bench.cc(4000, 121, 0)
    assert [note[0] for note in bench.held().values()] == [60]
    bench.run(9000)
    s = bench.log[0]["string"]
    assert bench.strings[s].tension == 1.0
    assert tension_after(bench, s, -8192) == 0.25


def test_system_reset_is_as_good_as_power_off_and_other_system_bytes_are_counted():
    bench = Bench()
    rpn(bench, 0, 0, 12, 0)
    bench.cc(0, 64, 127)
    bench.on(20, 60)
    for status in range(0xF0, 0xFF):
        bench.send(30, status, 1, 2)
    assert len(bench.held()) == 1 and bench.counters["messages_ignored"] == 11  # the others are pieces of SysEx
    assert bench.counters["sysex_ignored"] == bench.counters["sysex_refused"] == 1
    bench.send(40, 0xFF)
    assert bench.held() == {}
    bench.on(20000, 60)
    bench.off(30000, 60)
    assert bench.held() == {}


def test_percussion_is_counted_and_not_played():
    bench = Bench()
    bench.on(0, 38, channel=9)
    bench.off(100, 38, channel=9)
    bench.cc(100, 120, 0, channel=9)
    bench.finish()
    assert bench.gestures == [] and bench.counters["notes_percussion"] == 1
    assert bench.counters["notes_dropped"] == 0 and bench.log[0]["fate"] == "percussion"


@pytest.mark.parametrize("seed", range(8))
def test_any_bytes_at_any_time_and_then_silence(seed):
    rng = random.Random(seed)
    bench = Bench({"playing.idle_strings": rng.choice(("open", "damped"))}, tick=seed % 2 == 0)
    frame = 0
    for _ in range(4000):
        frame += rng.choice((0, 0, 1, 50, 1000))
        status = rng.choice((rng.randrange(-300, 600), rng.randrange(0x80, 0x100), 0x90 | rng.randrange(16)))
        bench.send(frame - rng.choice((0, 0, 0, 200)), status, rng.randrange(-9, 300), rng.randrange(-9, 300))
    for channel in range(16):
        bench.cc(frame, 64, 0, channel)
        bench.cc(frame, 66, 0, channel)
        bench.cc(frame, 123, 0, channel)
    assert bench.held() == {}
    bench.frame = frame
    bench.finish()
    counters = bench.counters
    assert counters["gestures_refused"] == 0 and counters["notes_played"] > 300
    parts = counters["notes_played"] + counters["notes_dropped"] + counters["notes_percussion"]
    assert counters["notes_on"] == parts == len(bench.log)
    assert all(note["end_s"] is not None for note in bench.log)
    assert all(string.sounding == -1 and string.place == 0.0 for string in bench.strings)
    frames = [gesture[0] for gesture in bench.gestures]
    assert all(0 <= s < 6 and 1 <= kind <= do.RELEASE for _, kind, s, _ in bench.gestures) and frames[0] >= 0
