"""Where and how channels pluck, and the table of controllers."""

import pathlib

import numpy as np
import pytest
from player_bench import RATE, Bench

from ukrt.engine import controller_layout as cc
from ukrt.engine import gestures as do
from ukrt.engine import player_layout as at


def pluck(controller=None, value=None, key=45, **settings):
    """Place and angle of a note's pluck."""
    bench = Bench(settings or None)
    if controller is not None:
        bench.cc(0, controller, value)
    bench.on(10, key)
    bench.finish()
    ((_, _, p),) = bench.plucks()
    return p[0], p[2]


def test_brightness_moves_the_pluck_to_the_bridge_and_to_the_neck():
    places = [pluck(cc.PLACE, value)[0] for value in range(128)]
    assert places[64] == pluck()[0] and np.all(np.diff(places) > 0.0)
    assert places[127] == at.PLACE_BRIDGE and places[0] == at.PLACE_NECK


def test_towards_the_neck_the_pluck_keeps_away_from_the_finger():
    place, _ = pluck(cc.PLACE, 0, key=83)  # fret 19 of the highest string, at 2/3 of it
    finger = 1.0 - 2.0 ** (-19 / 12)
    assert place == pytest.approx(finger + at.LEAST_SHARE * (1.0 - finger))


def test_the_angle_goes_from_parallel_to_normal_to_the_soundboard():
    angles = [pluck(cc.ANGLE, value)[1] for value in range(128)]
    assert angles[64] == pluck()[1] and np.all(np.diff(angles) < 0.0)
    assert angles[0] == np.pi / 2 and angles[127] == 0.0


def test_the_string_is_told_how_to_be_let_go_when_that_changes():
    bench = Bench()
    for frame, value in ((100, 0), (10000, 127), (20000, 127), (30000, 0)):
        bench.cc(frame, cc.FLESH, value)
        bench.on(frame, 45)
    bench.finish()
    told = [(frame, p[1]) for frame, kind, _, p in bench.gestures if kind == do.RELEASE]
    assert told == [(10000, round(bench.guitar.articulation.flesh_time * RATE)), (30000, 0)]


def test_channels_do_not_share_their_expression():
    bench = Bench()
    bench.cc(0, cc.PLACE, 127, channel=1)
    bench.on(10, 45)
    bench.finish()
    assert bench.plucks()[0][2][0] == bench.guitar.pluck.place


def test_the_musicians_page_has_the_table_of_the_code():
    page = pathlib.Path(__file__).parents[2] / "ukrt" / "playing" / "README.md"
    assert f"\n{cc.controller_table()}\n" in page.read_text(encoding="utf-8"), "paste controller_table() into the page"


def test_every_controller_of_the_table_is_followed_and_no_other():
    named = {n for name, n in vars(cc).items() if isinstance(n, int) and name not in ("DOWN", "MIDDLE")}
    for controller in range(120):
        bench = Bench()
        bench.cc(0, controller, 1)
        ignored = bench.counters["controllers_ignored"] + bench.counters["rpn_ignored"]
        data = controller in (cc.DATA_MSB, cc.DATA_LSB, cc.INCREMENT, cc.DECREMENT)  # of no RPN, as yet
        assert ignored == (1 if data or controller not in named else 0), controller
