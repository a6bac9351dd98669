"""The player on other fingerboards: keys of a scale, a capo, strings that do not ascend."""

import itertools
import math
import random

import pytest
from measure.forced_notes import note_pitch
from player_bench import Bench

from ukrt.engine.engine import Engine
from ukrt.model.fingerboard import fingerboard
from ukrt.model.presets import load_preset
from ukrt.playing.rules import fold_table

OPEN = (40, 45, 50, 55, 59, 64)
TRITAVE = {"name": "bp", "cents": [1200 * math.log2(3) * n / 13 for n in range(1, 14)]}
WHITE = {"degrees": ["0", "x", "2", "x", "4", "5", "x", "7", "x", "9", "x", "11"]}


def test_octaves_of_a_scale_are_as_many_keys_as_it_has_notes():
    table = fold_table((40, 45), 10, repeat=19)
    assert table[40] == table[59] == table[21] == 40 and table[55] == table[74] == 55
    for key in range(128):
        assert table[key] == -1 or ((table[key] - key) % 19 == 0 and 40 <= table[key] <= 55)
    assert [key for key in range(40, 59) if table[key] < 0] == [56, 57, 58]  # three of nineteen are nowhere


def test_keys_without_a_note_are_not_played_in_another_octave():
    plays = [key % 12 != 1 for key in range(128)]
    table = fold_table(OPEN, 19, 12, plays)
    assert all(table[key] == -1 for key in range(1, 128, 12))
    assert table[40] == 40 and table[28] == 40


def test_a_capo_moves_the_open_strings_and_shrinks_the_neck():
    bench = Bench({"playing.capo": 3})
    bench.places = bench.places[:, :17]
    frame = 1000
    for key in range(128):
        bench.on(frame, key)
        bench.off(frame + 10_000, key)
        frame += 40_000
    bench.finish()
    for note in bench.log:
        key = note["midi"] if 43 <= note["midi"] <= 83 else None
        assert note["string"] is not None and 0 <= note["fret"] <= 16
        if key is not None:
            assert OPEN[note["string"]] + 3 + note["fret"] == key
    assert bench.counters["notes_folded"] == 128 - 41


def test_every_key_of_a_scale_is_found_on_the_fret_that_sounds_it():
    bench = Bench({"tuning.scale": TRITAVE, "playing.frets": 16})
    board = fingerboard(bench.guitar)
    cents = [0.0, *TRITAVE["cents"]]
    for n, key in enumerate(range(49, 83)):
        bench.on(1000 + 40_000 * n, key)
        bench.off(11_000 + 40_000 * n, key)
    bench.finish()
    for note in bench.log:
        turns, degree = divmod(note["midi"] - 60, 13)
        above = turns * cents[-1] + cents[degree] - cents[9]  # 440 Hz is the ninth degree, key 69
        assert board.hz[note["string"], note["fret"]] == pytest.approx(440.0 * 2 ** (above / 1200), rel=1e-12)


def test_a_note_whose_octave_is_taken_moves_on_by_the_scales_own():
    """Key 36 belongs at 49, which only the lowest string has, and that plays 49 itself: a tritave up is 62."""
    bench = Bench({"tuning.scale": TRITAVE, "playing.frets": 16})
    keys = fingerboard(bench.guitar).open_keys
    bench.on(1000, 49)
    bench.on(1000, 36)
    assert [keys[note["string"]] + note["fret"] for note in bench.log] == [49, 62]


def test_keys_that_the_map_leaves_out_are_dropped_and_counted():
    bench = Bench({"tuning.keyboard": WHITE})
    for n, key in enumerate((60, 61, 62, 63)):
        bench.on(1000 + 40_000 * n, key)
        bench.off(11_000 + 40_000 * n, key)
    bench.finish()
    assert [note["fate"] for note in bench.log] == ["played", "dropped", "played", "dropped"]
    assert bench.counters["notes_dropped"] == 2 and bench.counters["notes_played"] == 2


# A re-entrant instrument ----------------------------------------------------------------------------------------------
UKULELE = (67, 60, 64, 69)
SHAPES = ("0003", "2000", "2010", "0212", "2223", "0100", "1202", "0002", "0001", "0000")  # C, A minor, F, G7, ...


@pytest.mark.parametrize("shape", SHAPES)
def test_a_ukulele_plays_its_common_chords_where_everybody_does(shape):
    keys = [key + int(fret) for key, fret in zip(UKULELE, shape, strict=True)]
    bench = Bench(preset="ukulele")
    for key in set(keys):  # of two strings in unison MIDI says one
        bench.on(1000, key)
    frets = {note["string"]: note["fret"] for note in bench.log}
    assert len(frets) == len(set(keys))
    assert all(shape[string] == str(fret) for string, fret in frets.items())


def test_the_high_string_on_the_bass_side_is_no_crossing():
    """C#4 G4 B4: the open G string lies before the second fret of B4; strings that ascend would have made it wrong."""
    bench = Bench(preset="ukulele")
    for key in (61, 67, 71):
        bench.on(1000, key)
    assert {note["midi"]: (note["string"], note["fret"]) for note in bench.log} == {61: (1, 1), 67: (0, 0), 71: (3, 2)}


def test_no_note_of_a_ukuleles_chord_is_dropped_that_four_strings_could_play():
    rng = random.Random(3)
    for _ in range(60):
        chord = [rng.randint(60, 84) for _ in range(rng.randint(2, 4))]
        bench = Bench(preset="ukulele")
        for channel, key in enumerate(chord):
            bench.on(1000, key, channel=channel)
        ways = itertools.permutations(UKULELE, len(chord))
        possible = any(all(0 <= key - low <= 15 for key, low in zip(chord, way, strict=True)) for way in ways)
        if possible:
            assert bench.counters["notes_dropped"] == bench.counters["notes_folded"] == 0


# Heard ----------------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("preset", "settings", "notes"),
    [
        ("classical", {"tuning.scale": TRITAVE, "playing.frets": 16, "playing.capo": 2}, [(1, 0), (4, 7)]),
        ("ukulele", {}, [(0, 3), (1, 0)]),
    ],
)
def test_what_is_heard_is_the_scales_note(preset, settings, notes):
    engine = Engine(load_preset(preset, {"playing.idle_strings": "damped", **settings}))
    for string, fret in notes:
        assert abs(note_pitch(engine, string, fret, 1.0).cents) < 0.5
    engine.close()
