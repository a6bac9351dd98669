"""How long a pluck pulls, what a planted finger does, which finger plucks, and how little plucks vary."""

import itertools

import numpy as np
import pytest
from player_bench import RATE, Bench

from ukrt.engine import controller_layout as cc
from ukrt.engine import gestures as do
from ukrt.engine import layout
from ukrt.engine import player_layout as at
from ukrt.engine.kernels.player_variation import chance
from ukrt.playing.rules import attack_times, mute_curve


def pulls(values, **settings):
    bench = Bench(settings or None)
    for n, value in enumerate(values):
        bench.cc(5000 * n, cc.ATTACK, value)
        bench.on(5000 * n, 45)
    bench.finish()
    return [(frame - 5000 * n, p[3]) for n, (frame, _, p) in enumerate(bench.plucks())], bench


def test_the_release_stays_where_it_is_however_long_a_pluck_pulls():
    found, bench = pulls(range(0, 128, 9))
    assert all(begin + pull == bench.lead for begin, pull in found)
    assert all(note["release_frame"] == 5000 * n + bench.lead for n, note in enumerate(bench.log))


def test_attack_goes_from_a_snap_over_the_presets_time_to_all_of_the_plucks():
    ((_, short), (_, usual), (_, whole)), bench = pulls((0, 64, 127), **{"pluck.attack": 0.3})
    assert (short, usual, whole) == (24.0, round(0.3 * bench.lead), bench.lead)
    times = attack_times(bench.guitar.pluck)
    assert np.all(np.diff(times) > 0.0) and np.ptp(np.diff(np.log(times[:65]))) < 1e-9
    assert pulls((64,))[0] == [(0, bench.lead)]


def touches(bench):
    return [(frame, p[0], p[2]) for frame, kind, _, p in bench.gestures if kind == do.TOUCH]


def test_a_planted_finger_comes_with_the_note_and_leaves_before_the_string_does():
    bench = Bench()
    bench.cc(0, cc.PLANTING, 127)
    bench.on(1000, 45)
    bench.off(1100, 45)  # a note cut short is planted all the same
    bench.finish()
    (down, place, resistance), (up, _, nothing) = touches(bench)
    (_, _, p), quick = bench.plucks()[0], round(0.002 * RATE)
    assert (down, up) == (1000, 1000 + bench.lead - quick) and nothing == 0.0
    assert resistance == bench.guitar.articulation.plant_resistance and 0.0 < p[0] - place < 0.01
    assert [kind for _, kind, _ in bench.strings[1].events].index(do.DAMP) > 0


def test_a_planted_finger_leaves_with_the_note_that_it_was_planted_for():
    """Another note on its string, not planted, 4 ms later."""
    bench = Bench()
    bench.cc(0, cc.PLANTING, 127)
    bench.on(1000, 45)
    bench.cc(1200, cc.PLANTING, 0)
    bench.on(1200, 45)
    bench.finish()
    assert [(frame, resistance > 0.0) for frame, _, resistance in touches(bench)] == [(1000, True), (1200, False)]


@pytest.mark.parametrize("controller", [cc.HARMONIC, cc.MUTE, cc.STRUM])
def test_a_hand_that_does_something_else_is_not_planted(controller):
    bench = Bench()
    bench.cc(0, cc.PLANTING, 127)
    bench.cc(0, controller, 127)
    bench.on(1000, 64)
    bench.off(60000, 64)
    bench.finish()
    curve = mute_curve(bench.guitar.articulation.plant_resistance)
    assert curve[127] not in [p for _, _, p in touches(bench)]


def test_planting_and_variation_begin_with_the_presets_and_reset_goes_back_to_it():
    settings = {"articulation.planting": 1.0, "articulation.variation": 1.0}
    usual, sent, back = Bench(settings), Bench(), Bench(settings)
    for bench, value in ((sent, 127), (back, 0)):
        bench.cc(0, cc.PLANTING, value)
        bench.cc(0, cc.VARIATION, value)
    back.cc(0, cc.RESET, 0)
    for bench in (usual, sent, back):
        bench.on(1000, 45)
        bench.finish()
    assert usual.gestures == sent.gestures == back.gestures and len(touches(usual)) == 2


def fingers(*chords):
    bench = Bench()
    for n, chord in enumerate(chords):
        for key in chord:
            bench.on(10000 * n, key)
        for key in chord:
            bench.off(10000 * n + 5000, key)
    found = [[note["finger"] for note in bench.log if note["time_s"] == 10000 * n / RATE] for n in range(len(chords))]
    return ["".join(together) for together in found]


def test_the_thumb_has_the_bass_strings_and_the_others_take_turns():
    assert fingers([40], [45], [50]) == ["p", "p", "p"]
    assert fingers([64], [64], [59], [64]) == ["i", "m", "a", "i"]
    assert fingers([40, 55, 59, 64]) == ["pima"]
    assert fingers([64], [55, 64], [64]) == ["i", "ma", "i"]
    assert fingers([64], [64], [55, 64], [64]) == ["i", "m", "ia", "m"]


def test_no_finger_plucks_single_notes_twice_running():
    keys = np.random.default_rng(1).integers(67, 80, 200)  # treble strings alone have them
    found = fingers(*([int(key)] for key in keys))
    assert all(one != other for one, other in itertools.pairwise(found))


def varied(count=400, value=127, seed=1, keys=(64,), tick=False):
    """Place, angle and force of many plucks of the same velocity, with their fingers."""
    bench = Bench({"articulation.seed": seed}, tick=tick)
    if value is not None:
        bench.cc(0, cc.VARIATION, value)
    for n in range(count):
        bench.on(1000 * n, keys[n % len(keys)])
        bench.off(1000 * n + 500, keys[n % len(keys)])
    bench.finish()
    return np.array([p[:3] for _, _, p in bench.plucks()]), [note["finger"] for note in bench.log]


def test_plucks_vary_little_and_about_what_is_asked():
    """Standard deviations: 2.5 mm of 650, 3 degrees, 0.7 dB; the mean is the fingers'."""
    plain, _ = varied(value=None)
    assert np.all(plain == plain[0])
    found, used = varied()
    moved = found - plain
    decibels = 20.0 * np.log10(found[:, 1] / plain[:, 1])
    assert 0.002 < moved[:, 0].std() < 0.006 and np.abs(moved[:, 0]).max() < 0.015
    assert 0.03 < moved[:, 2].std() < 0.08 and np.abs(moved[:, 2]).max() < 0.2
    assert 0.4 < decibels.std() < 1.0 and np.abs(decibels).max() < 2.5
    ring, index = (decibels[[name == finger for name in used]] for finger in "ai")
    assert ring.mean() < index.mean() - 0.3
    half, _ = varied(value=64)
    assert (half - plain)[:, 0] == pytest.approx(64 / 127 * moved[:, 0], abs=1e-12)


def test_chance_is_the_seeds_and_repeats_nothing():
    """Triangular, and no connection from note to note, from question to question, from seed to seed."""
    rows = []
    for seed in (0, 1, 2, 2**31 - 1):
        i = np.zeros(layout.I_SIZE, np.int64)
        i[at.I_SEED] = seed
        rows += [[chance(i, n, which) for n in range(4000)] for which in range(3)]
    rows = np.array(rows)
    assert np.abs(rows).max() <= 1.0 and np.abs(rows.mean(axis=1)).max() < 0.03
    assert rows.var(axis=1) == pytest.approx(1.0 / 6.0, abs=0.01)
    together = np.corrcoef(np.concatenate([rows[:, :-1], rows[:, 1:]]))
    assert np.abs(together - np.diag(np.diag(together))).max() < 0.07
    assert np.array_equal(varied()[0], varied(tick=True)[0])


def test_a_varied_pluck_stays_between_finger_and_bridge():
    keys = (83,)  # fret 19 of the highest string
    plain, _ = varied(1, value=None, keys=keys)
    found, _ = varied(keys=keys)
    finger = 1.0 - 2.0 ** (-19 / 12)
    assert np.all(found[:, 0] >= min(plain[0, 0], finger + 0.25 * (1.0 - finger))) and np.all(found[:, 0] <= 0.97)
