"""A channel for each string, as MIDI guitars send: which string plays, what overlaps become, what bends move."""

from dataclasses import dataclass

import numpy as np
import pytest
from modes_bench import OPEN, guitar_bench, places, ways
from player_bench import Bench, check_plucks

from ukrt.engine import controller_layout as cc
from ukrt.engine import gestures as do
from ukrt.engine.kernels.transfer_player import transfer_player
from ukrt.errors import ParameterError
from ukrt.model.presets import load_preset
from ukrt.playing.written_fingering import write_fingering


@pytest.mark.parametrize(("base", "preset"), [(1, "classical"), (5, "classical"), (11, "classical"), (3, "ukulele")])
def test_the_base_channel_plays_the_highest_string_and_those_after_it_the_others(base, preset):
    """Roland, GR-20: with basic channel 1 the 1st (high E) string sends on channel 1, the 6th (low E) on channel 6."""
    bench = guitar_bench(base, preset=preset)
    strings = [s.note for s in reversed(bench.guitar.strings)]
    for fret in (0, 3, 12):
        frame = bench.frame + 40000
        for number, note in enumerate(strings, start=1):
            bench.on(frame, note + fret, channel=base - 2 + number)
        wanted = {base - 2 + n: (n, fret, note + fret) for n, note in enumerate(strings, start=1)}
        assert places(bench) == wanted
        for number, note in enumerate(strings, start=1):
            bench.off(frame + 20000, note + fret, channel=base - 2 + number)
        assert bench.held() == {}
    assert bench.counters["forces_refused"] == bench.counters["notes_beyond_strings"] == 0
    bench.finish()
    check_plucks(bench) if len(strings) == 6 else None


def test_guitar_mpe_has_its_strings_on_the_members_of_the_lower_zone():
    bench = guitar_bench(mode="guitar-mpe")
    for number, note in enumerate(OPEN, start=1):
        bench.on(100, note + 2, channel=number)
    assert places(bench) == {n: (n, 2, note + 2) for n, note in enumerate(OPEN, start=1)}


def test_overlapping_notes_are_slurred_and_others_are_plucked():
    bench = guitar_bench()
    bench.on(0, 66, channel=0)
    bench.on(9000, 68, channel=0)  # up within the hand's reach
    bench.off(9200, 66, channel=0)  # note-offs of keys that no longer sound end nothing
    bench.on(18000, 64, channel=0)  # down to the open string
    bench.off(18200, 68, channel=0)
    bench.on(27000, 66, channel=0)
    bench.off(27200, 64, channel=0)
    bench.on(36000, 76, channel=0)  # further than the hand reaches
    bench.off(36200, 66, channel=0)
    assert places(bench) == {0: (1, 12, 76)}
    bench.off(45000, 76, channel=0)
    bench.on(45000, 74, channel=0)  # its note-off came first
    assert ways(bench) == ["pluck", "hammer-on", "pull-off", "hammer-on", "slide", "pluck"]
    assert places(bench) == {0: (1, 10, 74)}
    bench.off(51000, 74, channel=0)
    assert bench.held() == {} and bench.counters["notes_off_unmatched"] == 0


def test_a_key_struck_again_is_plucked_again():
    bench = guitar_bench()
    bench.on(0, 66, channel=0)
    bench.on(9000, 66, channel=0)
    assert ways(bench) == ["pluck", "pluck"] and bench.counters["notes_repeated"] == 1


def test_legato_off_plucks_each_note_on_the_one_string_until_controllers_are_reset():
    bench = guitar_bench()
    bench.cc(0, cc.LEGATO, 0, channel=2)
    bench.on(10, 57, channel=2)
    bench.on(9000, 59, channel=2)
    assert ways(bench) == ["pluck", "pluck"] and places(bench) == {2: (3, 4, 59)}
    assert bench.counters["notes_stolen"] == 1 and bench.log[0]["fate"] == "stolen"
    bench.cc(10000, cc.RESET, 0, channel=2)
    bench.on(18000, 57, channel=2)
    assert ways(bench)[-1] == "pull-off"


def test_strings_slur_at_the_same_moment_each_its_own_note_and_unisons_too():
    bench = guitar_bench()
    bench.on(0, 66, channel=0)
    bench.on(0, 66, channel=1)
    bench.on(9000, 67, channel=0)
    bench.on(9000, 67, channel=1)
    assert ways(bench)[2:] == ["hammer-on", "hammer-on"]
    assert places(bench) == {0: (1, 3, 67), 1: (2, 8, 67)}


def test_a_note_its_string_does_not_have_goes_to_another_and_is_counted():
    bench = guitar_bench()
    bench.on(0, 50, channel=0)  # lower than the first string goes
    assert places(bench)[0][0] in (4, 5, 6) and bench.counters["forces_refused"] == 1
    bench.on(9000, 64, channel=0)
    assert places(bench) == {0: (1, 0, 64)}  # one voice: the other string's note has ended
    assert bench.counters["notes_stolen"] == 1
    bench.off(12000, 50, channel=0)
    bench.off(12000, 64, channel=0)
    assert bench.held() == {} and bench.counters["notes_off_unmatched"] == 0


def test_a_string_is_taken_back_from_a_note_that_does_not_belong_there():
    bench = guitar_bench()
    bench.cc(0, cc.STRING, 2, channel=0)
    bench.on(10, 62, channel=0)
    assert places(bench) == {0: (2, 3, 62)}  # CC 20 comes before the mode
    bench.on(9000, 60, channel=1)
    assert places(bench) == {1: (2, 1, 60)} and bench.log[0]["fate"] == "stolen"


def test_channels_beyond_the_strings_play_as_a_keyboard_does_and_are_counted():
    bench = guitar_bench(base=3)
    bench.on(0, 60, channel=0)
    bench.on(9000, 64, channel=0)
    bench.on(9000, 52, channel=12)
    assert len(bench.held()) == 3 and ways(bench) == ["pluck"] * 3
    assert bench.counters["notes_beyond_strings"] == 3


def test_channel_10_is_a_string_where_it_is_one_and_percussion_elsewhere():
    bench = guitar_bench(base=8)
    bench.on(0, 57, channel=9)
    assert places(bench) == {9: (3, 2, 57)}
    bench = guitar_bench(base=3)
    bench.on(0, 57, channel=9)
    assert bench.held() == {} and bench.counters["notes_percussion"] == 1


def test_channels_must_end_at_16():
    load_preset("classical", {"playing.midi_mode": "guitar", "playing.base_channel": "11"})
    with pytest.raises(ParameterError, match="from 1 to 11"):
        load_preset("classical", {"playing.midi_mode": "guitar", "playing.base_channel": "12"})
    with pytest.raises(ParameterError, match=r"keyboard.*guitar.*mpe"):
        load_preset("classical", {"playing.midi_mode": "piano"})


def test_a_bend_moves_its_own_string_only():
    bench = guitar_bench()
    for channel, note in enumerate(OPEN):
        bench.on(0, note + 2, channel=channel)
    bench.bend(9000, 4096, channel=3)
    bench.finish()
    bends = [(frame, s, p[0]) for frame, kind, s, p in bench.gestures if kind == do.TENSION]
    assert [bend[:2] for bend in bends] == [(9000 + bench.lead, 2)]
    assert bends[0][2] == pytest.approx(2 ** (100 / 600), rel=1e-12)


def test_bend_range_is_each_channels_own_and_zones_cannot_be_set():
    bench = guitar_bench()
    for controller, value in ((101, 0), (100, 6), (6, 15)):
        bench.cc(0, controller, value, channel=0)
    for controller, value in ((101, 0), (100, 0), (6, 12)):
        bench.cc(0, controller, value, channel=1)
    assert bench.counters["zones_set"] == 0 and bench.counters["rpn_ignored"] == 1
    for channel in range(3):
        bench.on(100, OPEN[channel], channel=channel)
        bench.bend(9000, -4096, channel=channel)
    bench.finish()
    cents = [600 * np.log2(bench.strings[5 - channel].tension) for channel in range(3)]
    assert cents == pytest.approx([-100, -600, -100])


def test_another_guitar_goes_on_in_its_own_mode_and_no_note_hangs():
    old, new = guitar_bench(base=8), Bench()
    old.on(0, 57, channel=9)
    old.on(0, 64, channel=7)
    transfer_player(old.d, old.i, new.d, new.i, 5000, 1.0)
    assert [channel for _, channel, _ in new.held().values()] == [7]  # channel 10 is percussion from here on
    new.off(9000, 64, channel=7)
    new.off(9000, 57, channel=9)
    assert new.held() == {}
    again = guitar_bench(base=8)
    old.cc(6000, cc.POLY, 0, channel=7)
    transfer_player(old.d, old.i, again.d, again.i, 7000, 1.0)
    again.on(60000, 45, channel=7)
    assert places(again) == {7: (5, 0, 45)} and again.counters["forces_refused"] == 0  # poly, as it was told


@dataclass(frozen=True)
class Rows:
    """A score of (seconds, status, data1, data2)."""

    time_s: np.ndarray
    status: np.ndarray
    data1: np.ndarray
    data2: np.ndarray
    duration_s: float = 1.0


def score_of(*rows):
    return Rows(*(np.array(column) for column in zip(*rows, strict=True)))


NOTE = ((0.0, 0x90, 64, 80), (1.0, 0x80, 64, 0))


@pytest.mark.parametrize("mode", ["guitar", "guitar-mpe", "mpe"])
def test_files_for_strings_or_zones_are_played_as_they_come(mode):
    score = score_of(*NOTE)
    same, summary = write_fingering(score, load_preset("classical", {"playing.midi_mode": mode}))
    assert same is score and summary.choice == "causal" and mode in summary.why


@pytest.mark.parametrize(
    ("channel", "number", "choice"), [(0, 6, "causal"), (15, 6, "causal"), (3, 6, "look-ahead"), (0, 0, "look-ahead")]
)
def test_a_file_that_makes_zones_itself_is_one_of_them(channel, number, choice):
    status = 0xB0 | channel
    setting = ((0.0, status, 101, 0), (0.0, status, 100, number), (0.0, status, 6, 7))
    score = score_of(*setting, *NOTE)
    assert write_fingering(score, load_preset("classical"))[1].choice == choice
