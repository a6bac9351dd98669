"""The report's notes and counters, the velocity curve and the notes outside the range."""

import collections

import numpy as np
import pytest
from player_bench import RATE, Bench

from ukrt.engine import player_layout as at
from ukrt.engine.note_log import read_note_log
from ukrt.model.presets import load_preset
from ukrt.playing.rules import fold_table, force_curve


@pytest.mark.parametrize("preset", ["classical", "paper", "drop-d"])
def test_velocity_to_force_rises_evenly_in_db_through_both_given_forces(preset):
    pluck = load_preset(preset).pluck
    force = force_curve(pluck)
    assert force[20] == pytest.approx(pluck.force_soft) and force[20] <= 1.0
    assert force[127] == pytest.approx(pluck.force_strong)
    assert np.all(np.diff(force[1:]) > 0) and 0.0 < force[1] < force[20]
    steps = np.diff(20 * np.log10(force[1:]))
    assert np.ptp(steps) < 1e-9


def test_the_force_of_a_note_is_the_curves():
    bench = Bench()
    for n, velocity in enumerate((1, 20, 64, 127)):
        bench.on(5000 * n, 45, velocity)
    bench.finish()
    wanted = [force_curve(bench.guitar.pluck)[v] for v in (1, 20, 64, 127)]
    assert [note["force_n"] for note in bench.log] == wanted == [p[1] for _, _, p in bench.plucks()]


def test_notes_outside_the_range_are_played_in_the_nearest_octave():
    table = fold_table([40, 45, 50, 55, 59, 64], 19)
    assert all(table[note] == note for note in range(40, 84))
    assert all(40 <= table[note] <= 83 and (table[note] - note) % 12 == 0 for note in range(128))
    assert table[39] == 51 and table[28] == 40 and table[84] == 72 and table[127] == 79
    assert list(fold_table([60], 0)) == [60 if note % 12 == 0 else -1 for note in range(128)]
    assert fold_table([40, 60], 2)[43] == -1 and fold_table([40, 60], 2)[50] == 62


def test_a_folded_note_is_counted_and_logged_as_it_came():
    bench = Bench()
    bench.on(0, 93)
    note = bench.log[0]
    assert note["midi"] == 93 and 64 + note["fret"] == 81 and note["fate"] == "played"
    assert bench.counters["notes_folded"] == 1 and bench.counters["notes_dropped"] == 0
    bench.off(100, 93)
    assert bench.held() == {}


def test_a_folded_note_makes_way_for_one_at_its_own_octave():
    for order in ((81, 93), (93, 81)):
        bench = Bench()
        for key in order:
            bench.on(0, key)
        pitches = {key: bench.open[s] + fret for s, (key, _, fret) in bench.held().items()}
        assert pitches == {81: 81, 93: 69} and bench.counters["notes_dropped"] == 0


def test_a_pitch_that_no_octave_of_the_instrument_has_is_dropped_and_counted():
    bench = Bench({"playing.frets": "0"})
    bench.on(0, 41)
    bench.off(10, 41)
    bench.on(20, 40)
    assert [note["fate"] for note in bench.log] == ["dropped", "played"]
    assert bench.log[0]["string"] is None and bench.log[0]["end_s"] == 0.0
    assert bench.counters["notes_dropped"] == 1


def test_every_fate_is_told():
    bench = Bench()
    bench.on(0, 40)
    bench.on(4800, 40)  # repeated
    bench.on(9600, 41)  # takes the string that alone can play it
    bench.on(9600, 38, channel=9)
    bench.cc(14400, 120, 0)
    for key in (40, 41, 42):
        bench.on(24000, key)
    fates = [(note["midi"], note["fate"], note["end_s"]) for note in bench.log]
    assert fates[:4] == [(40, "repeated", 0.1), (40, "stolen", 0.2), (41, "silenced", 0.3), (38, "percussion", 0.2)]
    assert collections.Counter(fate for _, fate, _ in fates[4:]) == {"played": 1, "dropped": 2}
    assert {name: bench.counters[name] for name in ("notes_on", "notes_played", "notes_stolen", "notes_repeated")} == {
        "notes_on": 7,
        "notes_played": 4,
        "notes_stolen": 1,
        "notes_repeated": 1,
    }
    assert set(bench.log[0]) == {
        "time_s", "release_frame", "midi", "channel", "string", "fret", "force_n", "articulation", "finger", "end_s",
        "fate",
    }  # fmt: skip


def test_each_note_off_ends_the_oldest_note_of_its_key():
    bench = Bench()
    bench.on(0, 40)
    bench.on(1000, 40)
    bench.off(2000, 40)  # the first one's
    assert len(bench.held()) == 1
    bench.off(3000, 40)
    assert bench.held() == {} and bench.log[1]["end_s"] == 3000 / RATE
    bench.off(4000, 40)
    assert bench.counters["notes_off_unmatched"] == 1
    bench.on(20000, 40)
    bench.on(21000, 41)  # steals
    bench.on(22000, 40)  # steals back
    bench.off(23000, 40)
    bench.off(23001, 41)
    assert [note[0] for note in bench.held().values()] == [40]
    bench.off(24000, 40)
    assert bench.held() == {}


def test_the_log_keeps_the_latest_notes_and_counts_what_it_lost():
    bench = Bench()
    total = at.LOG_CAPACITY + 100
    for n in range(total):
        bench.send(n * 10, 0x90, 40 + n % 40, 1 + n % 127)
        bench.send(n * 10 + 5, 0x80, 40 + n % 40, 0)
    log = bench.log
    assert len(log) == at.LOG_CAPACITY and bench.counters["note_log_overflows"] == 100
    assert [log[0]["midi"], log[-1]["midi"]] == [40 + 100 % 40, 40 + (total - 1) % 40]
    assert log[0]["time_s"] == 1000 / RATE and log[-1]["end_s"] == ((total - 1) * 10 + 5) / RATE
    assert [n["time_s"] for n in read_note_log(bench.d, bench.i, RATE, since=total - 3)] == [
        (total - k) * 10 / RATE for k in (3, 2, 1)
    ]
