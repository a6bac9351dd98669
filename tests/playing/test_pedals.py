"""CC 64, 66, 67: which notes ring on, against a plain model of the MIDI specification's words; what soft plucks are."""

import math
import random

import pytest
from player_bench import Bench

from ukrt.engine import gestures as do
from ukrt.engine import player_layout as at
from ukrt.engine.kernels.player import player_reset

OPEN = (40, 45, 50, 55, 59, 64)


def keys(bench):
    return sorted(key for key, _, _ in bench.held().values())


def test_sostenuto_holds_the_keys_that_are_down_and_no_others():
    bench = Bench()
    bench.on(0, 60)
    bench.on(10, 52)
    bench.off(1000, 52)
    bench.cc(2000, 66, 64)
    bench.on(3000, 67)
    bench.cc(3500, 66, 127)  # it is down already: catches nothing more
    bench.off(4000, 60)
    bench.off(4000, 67)
    assert keys(bench) == [60]
    bench.cc(50_000, 66, 63)
    assert keys(bench) == []
    bench.run(50_000 + bench.lead + 1)
    assert [s for frame, kind, s, _ in bench.gestures if kind == do.DAMP and frame == 50_000 + bench.lead] != []


def test_sostenuto_catches_the_chord_of_its_own_frame_but_what_comes_behind_it():
    bench = Bench()
    bench.on(0, 60)
    bench.on(0, 64)
    bench.off(0, 64)
    bench.cc(0, 66, 127)
    bench.on(0, 67)
    for key in (60, 67):
        bench.off(5000, key)
    assert keys(bench) == [60]


def test_the_pedals_add_up():
    bench = Bench()
    bench.on(0, 60)
    bench.cc(10, 66, 127)
    bench.on(20, 64)
    bench.cc(30, 64, 127)
    bench.off(40, 60)
    bench.off(40, 64)
    assert keys(bench) == [60, 64]
    bench.cc(50, 64, 0)
    assert keys(bench) == [60]
    bench.cc(60, 64, 127)
    bench.cc(70, 66, 0)  # the other pedal has it now
    assert keys(bench) == [60]
    bench.cc(80, 64, 0)
    assert keys(bench) == []


@pytest.mark.parametrize(
    ("controller", "left"), [(123, [60]), (120, []), (121, []), (124, [60])], ids=["123", "120", "121", "124"]
)
def test_messages_that_end_notes(controller, left):
    bench = Bench()
    bench.on(0, 60)
    bench.cc(10, 66, 127)
    bench.on(20, 64)
    if controller == 121:  # both keys are up; pedals go up
        bench.off(30, 60)
        bench.off(30, 64)
    bench.cc(40, controller, 0)
    assert keys(bench) == left
    assert bench.i[at.C_SOSTENUTO] == (controller != 121)


def test_sostenuto_is_its_channels_own():
    bench = Bench()
    bench.on(0, 60, channel=0)
    bench.on(0, 64, channel=1)
    bench.cc(10, 66, 127, channel=1)
    bench.off(20, 60, channel=0)
    bench.off(20, 64, channel=1)
    assert keys(bench) == [64]


def test_a_caught_note_gives_up_its_string_and_what_takes_it_is_not_caught():
    bench = Bench()
    for key in OPEN:
        bench.on(0, key)
    bench.cc(10, 66, 127)
    bench.off(20, 50)
    bench.on(5000, 57)  # the only string that no key holds
    assert {note["midi"]: note["fate"] for note in bench.log}[50] == "stolen"
    bench.off(6000, 57)
    assert keys(bench) == [40, 45, 55, 59, 64]


@pytest.mark.parametrize("seed", range(6))
def test_any_order_of_keys_and_pedals(seed):
    """Six keys, each kept on its own string by CC 20, so that none is stolen; messages often at the same frame (but for
    a key that goes down and up in one: with its chord it is decided anew, after what comes later)."""
    rng, bench, frame, begun = random.Random(seed), Bench(), 0, {}
    down, caught, ringing, pedals = set(), set(), set(), {64: False, 66: False}
    for _ in range(1500):
        frame += rng.choice((0, 0, 1, 700, 20_000))
        what = rng.randrange(5)
        key = rng.choice(OPEN)
        if what < 2 and key not in down:
            bench.cc(frame, 20, 6 - OPEN.index(key))
            bench.on(frame, key)
            down, ringing, caught = down | {key}, ringing | {key}, caught - {key}
            begun[key] = frame
        elif what == 2 and key in down and begun[key] < frame:
            bench.off(frame, key)
            down = down - {key}
        elif what > 2:
            number = rng.choice((64, 66))
            pedals[number], before = rng.random() < 0.5, pedals[number]
            bench.cc(frame, number, rng.randrange(64, 128) if pedals[number] else rng.randrange(64))
            if number == 66 and pedals[66] != before:
                caught = set(down) if pedals[66] else set()
        ringing = {key for key in ringing if key in down or pedals[64] or (pedals[66] and key in caught)}
        assert keys(bench) == sorted(ringing)


def test_soft_plucks_are_3_db_softer_and_fleshier_until_121():
    bench = Bench()
    plucks = []
    for frame, (controller, value) in enumerate(((67, 0), (67, 64), (18, 100), (121, 0), (18, 0))):
        bench.cc(100_000 * frame, controller, value)
        bench.on(100_000 * frame + 10, 60, 90)
        bench.off(100_000 * frame + 9000, 60)
        bench.run(100_000 * frame + 50_000)
        release = int(bench.i[at.S_RELEASE + bench.log[-1]["string"]])
        plucks.append((bench.plucks()[-1][2][1], bench.log[-1]["force_n"], release))
    full, flesh = plucks[0][0], int(bench.i[at.I_FLESH])
    assert [force / full for force, _, _ in plucks] == pytest.approx([1.0, 0.7, 0.7, 1.0, 1.0])
    assert all(force == logged for force, logged, _ in plucks)
    assert 20 * math.log10(0.7) == pytest.approx(-3.0, abs=0.2)
    assert [release for _, _, release in plucks] == [0, 48 * flesh // 127, flesh, 100 * flesh // 127, 0]


def test_nothing_of_the_pedals_survives_a_reset():
    bench = Bench()
    for controller in (64, 66, 67):
        bench.cc(0, controller, 127)
    bench.on(10, 60)
    player_reset(bench.d, bench.i)
    assert not bench.i[[at.C_PEDAL, at.C_SOSTENUTO, at.C_SOFT, at.S_CAUGHT]].any()
