"""Keyswitches: keys that sound nothing and set controllers, live and in files, and where they may lie."""

import itertools
import pathlib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from player_bench import Bench

from ukrt.engine import controller_layout as cc
from ukrt.engine import player_layout as at
from ukrt.errors import ParameterError
from ukrt.model.presets import load_preset
from ukrt.playing import keyswitches
from ukrt.playing.written_notes import written_notes

ON = {"playing.keyswitches": "on"}
FIRST = 21


def key_of(start):
    """The switch whose words begin like this."""
    (key,) = [FIRST + n for n, one in enumerate(keyswitches.KEYSWITCHES) if one.words.startswith(start)]
    return key


def channel_state(bench, channel=0):
    rows = (at.C_LEGATO, at.C_GLIDES, at.C_HARMONIC, at.C_MUTE, at.C_FLESH, at.C_LOOSE, at.C_ANGLE, at.C_PLACE)
    return [max(0, int(bench.i[row + channel])) for row in (*rows, at.C_WHEEL)]


def test_the_musicians_page_has_the_table_of_the_code():
    page = pathlib.Path(__file__).parents[2] / "ukrt" / "playing" / "README.md"
    assert f"\n{keyswitches.keyswitch_table()}\n" in page.read_text(encoding="utf-8"), "paste keyswitch_table()"


def test_its_controllers_are_those_of_the_controller_table():
    for name in ("WHEEL", "ANGLE", "HARMONIC", "FLESH", "MUTE", "LOOSE", "GLIDE", "LEGATO", "PLACE"):
        assert getattr(keyswitches, name) == getattr(cc, name)
    assert len(keyswitches.KEYSWITCHES) <= at.MOST_SWITCHES


@pytest.mark.parametrize("number", range(len(keyswitches.KEYSWITCHES)))
@pytest.mark.parametrize("velocity", [1, 64, 127])
def test_a_switch_does_what_its_controllers_do_and_normal_takes_it_back(number, velocity):
    switched, controlled, fresh = Bench(ON), Bench(ON), Bench(ON)
    switched.on(0, FIRST + number, velocity)
    for controller, value in keyswitches.settings(keyswitches.KEYSWITCHES[number], velocity):
        controlled.cc(0, controller, value)
    assert channel_state(switched) == channel_state(controlled)
    assert (channel_state(switched) == channel_state(fresh)) == (number == 0)
    switched.off(10, FIRST + number)
    assert channel_state(switched) == channel_state(controlled)
    switched.on(20, FIRST)
    assert channel_state(switched) == channel_state(fresh)
    counted = switched.counters
    assert counted["keyswitches"] == 2 and counted["notes_on"] == counted["notes_off_unmatched"] == 0
    assert counted["controllers_ignored"] == counted["notes_folded"] == 0 and switched.log == []


def test_a_switch_ends_those_of_its_group_only():
    bench = Bench(ON)
    for words in ("legato", "pizzicato", "sul tasto"):
        bench.on(0, key_of(words))
    bench.on(0, key_of("harmonics"))
    bench.on(0, key_of("sul ponticello"), 127)
    state = channel_state(bench)
    assert state[0] == 1 and state[2:5] == [1, 0, 0] and state[7] == 127


def test_off_they_are_notes_like_any_other():
    bench = Bench()
    bench.on(0, FIRST)
    assert bench.counters["keyswitches"] == 0 and bench.counters["notes_folded"] == 1 and len(bench.held()) == 1


@pytest.mark.parametrize("words, key", [("harmonics", 64), ("palm mute", 52), ("legato", 54), ("sul tasto", 60)])
def test_within_a_frame_a_switch_acts_whatever_the_order(words, key):
    """The notes of its frame are played as it says, whether they come before or after it."""
    outcomes = set()
    for order in itertools.permutations((key_of(words), key, 43)):
        bench = Bench(ON)
        bench.on(0, 52)
        for one in order:
            bench.on(9000, one)
        bench.finish()
        log = sorted((n["midi"], n["string"], n["fret"], n["articulation"]) for n in bench.log)
        plucks = sorted((frame, s, p[:3]) for frame, s, p in bench.plucks())
        outcomes.add((tuple(log), tuple(plucks), bench.counters["notes_folded"]))
    assert len(outcomes) == 1
    plain = Bench()
    plain.on(0, 52)
    plain.on(9000, key)
    plain.finish()
    assert words == "sul tasto" or {w for *_, w in outcomes.pop()[0]} != {n["articulation"] for n in plain.log}


def test_switches_are_a_channels_own_and_percussion_has_none():
    bench = Bench(ON)
    bench.on(0, key_of("legato"), channel=3)
    bench.on(0, key_of("legato"), channel=9)
    assert channel_state(bench, 3)[0] == 1 and channel_state(bench)[0] == 0
    assert bench.counters["keyswitches"] == 1 and bench.counters["notes_percussion"] == 1


def test_a_note_that_sounds_is_ended_by_its_key_though_that_became_a_switch():
    bench = Bench()
    bench.on(0, FIRST)
    bench.i[at.I_SWITCH_KEY] = FIRST
    bench.off(9000, FIRST)
    assert bench.held() == {} and bench.counters["notes_off_unmatched"] == 0


@pytest.mark.parametrize("preset", ["classical", "drop-d", "seven-string", "eight-string", "ukulele"])
def test_the_first_key_of_a_piano_suits_every_shipped_guitar(preset):
    guitar = load_preset(preset, ON)
    assert min(keyswitches.switches_of(guitar)) == FIRST and keyswitches.switches_of(load_preset(preset)) == {}


@pytest.mark.parametrize("key", [30, 39, 40, 60, 83, 120, 127])
def test_keys_within_the_range_or_beyond_midi_are_refused(key):
    with pytest.raises(ParameterError, match=r"keyswitch_key is \d+, but it must be from 0 to 29 or from 84 to 117"):
        Bench(ON | {"playing.keyswitch_key": str(key)})


def test_above_the_range_is_as_good():
    bench = Bench(ON | {"playing.keyswitch_key": "84"})
    bench.on(0, 85)
    assert channel_state(bench)[0] == 1


def _score(*rows):
    time_s, status, data1, data2 = (np.array(column) for column in zip(*rows, strict=True))
    columns = {"time_s": time_s, "status": status, "data1": data1, "data2": data2}
    return type("Rows", (), columns | {"duration_s": float(time_s[-1])})


def test_files_slur_by_switches_too_and_do_not_finger_them():
    switches = keyswitches.switches_of(load_preset("classical", ON))
    legato, normal = key_of("legato"), FIRST
    rows = [(0.0, 0x90, legato, 90), (0.1, 0x80, legato, 0)]
    for k, key in enumerate((60, 62, 64)):
        rows += [(1.0 + k, 0x90, key, 80), (2.1 + k, 0x80, key, 0)]
    rows += [(6.0, 0x90, normal, 1), (6.1, 0x80, normal, 0), (7.0, 0x90, 60, 80), (8.0, 0x90, 62, 80)]
    notes = written_notes(_score(*sorted(rows)), switches)
    assert [note.key for note in notes] == [60, 62, 64, 60, 62]
    assert [note.slurred_from and note.slurred_from.key for note in notes] == [None, 60, 62, None, None]


_EVENTS = st.lists(
    st.tuples(
        st.sampled_from((0, 0, 3, 480, 9000)),
        st.sampled_from((0x90, 0x90, 0x80)),
        st.integers(0, 1),
        st.one_of(st.integers(FIRST, FIRST + 15), st.integers(44, 60)),
        st.integers(1, 127),
    ),
    max_size=80,
)


@given(_EVENTS)
@settings(max_examples=40, deadline=None)
def test_whatever_is_switched_no_note_sticks_and_all_are_counted(events):
    bench, frame, switched, notes = Bench(ON), 0, 0, 0
    for step, status, channel, key, velocity in events:
        frame += step
        bench.send(frame, status | channel, key, velocity)
        is_switch = FIRST <= key < FIRST + len(keyswitches.KEYSWITCHES)
        switched += status == 0x90 and is_switch
        notes += status == 0x90 and not is_switch
    for channel in range(2):
        bench.cc(frame + 100, 123, 0, channel)
    bench.finish()
    counted = bench.counters
    assert bench.held() == {} and counted["keyswitches"] == switched and counted["notes_on"] == notes
    assert counted["notes_on"] == counted["notes_played"] + counted["notes_dropped"]
    assert all(string.place == 0.0 and not string.damped for string in bench.strings)


def test_back_to_normal_leaves_one_voice_channels_their_legato():
    """Where a channel has one voice it is legato unless it was told otherwise; a switch that ends tells it nothing."""
    bench = Bench(ON | {"playing.midi_mode": "guitar"})
    bench.on(0, key_of("legato"))
    bench.on(0, FIRST)
    bench.on(0, 65)
    bench.on(9000, 67)
    assert [note["articulation"] for note in bench.log] == ["pluck", "hammer-on"]
