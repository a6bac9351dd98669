"""Conformance to MIDI Polyphonic Expression (M1-100-UM v1.1), on messages built after it; sections are named in tests.

Which channels a sequence of configuration messages leaves in which zone is worked out with sets (`zones_by_the_book`);
what a channel is to the player is found by playing on it.
"""

import math
import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from player_bench import Bench
from test_guitar_mode import places

from ukrt.engine import controller_layout as cc
from ukrt.engine import gestures as do
from ukrt.engine import layout
from ukrt.engine import player_layout as at
from ukrt.engine.kernels.player_vibrato import follow_vibrato
from ukrt.engine.kernels.transfer_player import transfer_player

PRESET_RANGE = 4  # semitones outside zones, so that they can be told from masters
LOWER, UPPER = 1, 16  # masters, as musicians count channels
KEYS = (64, 59, 55, 50, 45, 40)  # open strings: as many notes as wanted sound at once


def mpe_bench(mode="mpe"):
    return Bench({"playing.midi_mode": mode, "playing.bend_range_semitones": str(PRESET_RANGE)})


def rpn(bench, channel, number, value, fine=None):
    """A registered parameter on a channel, counted from 1."""
    for controller, data in ((101, 0), (100, number), (6, value), (38, fine)):
        if data is not None:
            bench.cc(bench.frame + 10, controller, data, channel - 1)


def mcm(bench, master, members):
    rpn(bench, master, 6, members)


def swapped(bench, mode):
    """The same guitar in another mode goes on, with the gestures that are still to come."""
    other = mpe_bench(mode)
    bench.run(bench.frame)
    bench.i[layout.H_STRINGS] = other.i[layout.H_STRINGS] = len(bench.strings)
    transfer_player(bench.d, bench.i, other.d, other.i, bench.frame, 1.0)
    other.strings, other.frame = bench.strings, bench.frame
    return other


def zones_by_the_book(messages, start=()):
    """Section 2.1: the newest zone has what it asks for, the other what is left if that is more than a master."""
    zones = dict.fromkeys((LOWER, UPPER), ()) | dict(start)
    for master, members in messages:
        step = 1 if master == LOWER else -1
        zones[master] = tuple(master + step * k for k in range(members + 1)) if members else ()
        other = LOWER + UPPER - master
        left = tuple(channel for channel in zones[other] if channel not in zones[master])
        zones[other] = left if len(left) > 1 and left[0] == other else ()
    return zones


def cents(bench, s):
    """How far string ``s`` is from its own tension, in cents: pitch goes with the root of the tension."""
    return 600.0 * math.log2(bench.strings[s].tension)


def string_of(bench, channel, key):
    return next(s for s, (k, c, _) in bench.held().items() if (k, c) == (key, channel - 1))


def bend(bench, channel, share):
    """A pitch bend to a share of the range, and its effect awaited."""
    bench.bend(bench.frame + 5000, round(share * 8192), channel - 1)
    bench.run(bench.frame + 5000)


def found_zones(bench):
    """What each channel is, by the bends it follows: its own with a member's or a master's range, and a master's."""
    zones, outside = {LOWER: [], UPPER: []}, []
    for channel in range(1, 17):
        bench.on(bench.frame + 60000, 57, channel=channel - 1)
        if not bench.held():
            outside.append(channel)  # percussion
            continue
        s = string_of(bench, channel, 57)
        moved = {}
        for one in {channel, LOWER, UPPER}:
            bend(bench, one, 1 / 8)
            moved[one] = cents(bench, s)
            bend(bench, one, 0)
        own = {round(4800 / 8): "member", round(200 / 8): "master", round(100 * PRESET_RANGE / 8): ""}
        part = own[round(moved[channel])]
        masters = [one for one in (LOWER, UPPER) if one != channel and moved[one] != 0.0]
        if part == "member":
            assert len(masters) == 1 and moved[masters[0]] == pytest.approx(25)
            zones[masters[0]].append(channel)
        elif part == "master":
            assert masters == []
            zones[channel].insert(0, channel)
        else:
            assert masters == []
            outside.append(channel)
        bench.off(bench.frame + 10, 57, channel=channel - 1)
    return {master: tuple(sorted(found)) for master, found in zones.items()}


def sorted_zones(messages, start=()):
    return {master: tuple(sorted(zone)) for master, zone in zones_by_the_book(messages, start).items()}


# Zones ----------------------------------------------------------------------------------------------------------------


def test_mode_mpe_begins_with_a_lower_zone_of_15_members():
    assert found_zones(mpe_bench()) == {LOWER: tuple(range(1, 17)), UPPER: ()}


@pytest.mark.parametrize(
    ("messages", "lower", "upper"),
    [
        ([(1, 7)], range(1, 9), ()),
        ([(1, 7), (16, 7)], range(1, 9), range(9, 17)),
        ([(16, 5)], (), range(11, 17)),
        ([(1, 10), (16, 7)], range(1, 9), range(9, 17)),  # the newer zone keeps all it asks for
        ([(16, 7), (1, 10)], range(1, 12), range(12, 17)),
        ([(16, 7), (1, 14)], range(1, 16), ()),  # a master without members is no zone
        ([(16, 7), (1, 15)], range(1, 17), ()),
        ([(1, 3), (16, 15)], (), range(1, 17)),  # channel 1 is a member
        ([(16, 15), (1, 2)], range(1, 4), range(4, 17)),
        ([(1, 7), (16, 7), (1, 0)], (), range(9, 17)),
        ([(1, 7), (1, 0)], (), ()),
    ],
)
def test_configuration_messages_make_and_shrink_zones(messages, lower, upper):
    book = zones_by_the_book(messages)
    assert {one: sorted(zone) for one, zone in book.items()} == {LOWER: list(lower), UPPER: list(upper)}
    bench = mpe_bench("keyboard")  # where there is no zone before the first message
    for master, members in messages:
        mcm(bench, master, members)
    assert found_zones(bench) == sorted_zones(messages)
    assert bench.counters["zones_set"] == len(messages) and bench.counters["rpn_ignored"] == 0


@pytest.mark.parametrize("seed", range(6))
def test_any_sequence_of_configuration_messages(seed):
    rng = random.Random(seed)
    bench, messages = mpe_bench(), []
    for _ in range(rng.randint(2, 8)):
        messages.append((rng.choice((LOWER, UPPER)), rng.randint(0, 15)))
        mcm(bench, *messages[-1])
    assert found_zones(bench) == sorted_zones(messages, {LOWER: tuple(range(1, 17))})


def test_configuration_messages_on_other_channels_or_of_more_members_are_ignored_and_counted():
    bench = mpe_bench()
    for channel in range(2, 16):
        mcm(bench, channel, 4)
    mcm(bench, LOWER, 16)
    mcm(bench, UPPER, 127)
    assert bench.counters["rpn_ignored"] == 16 and bench.counters["zones_set"] == 0
    assert found_zones(bench)[LOWER] == tuple(range(1, 17))


def test_channels_that_come_or_leave_are_silenced_and_reset_and_others_go_on():
    """2.1.3: notes end and controls are reset on each channel that enters or leaves the control of MPE."""
    bench = mpe_bench()
    mcm(bench, LOWER, 5)
    bench.cc(bench.frame + 1, cc.PEDAL, 127, channel=0)
    for channel, key in ((3, 64), (5, 59), (6, 55), (9, 50)):
        bend(bench, channel, 0.01)
        bench.on(bench.frame + 1, key, channel=channel - 1)
    bench.off(bench.frame + 1, 59, channel=4)  # only the pedal holds it
    mcm(bench, LOWER, 3)
    assert {channel + 1 for _, channel, _ in bench.held().values()} == {3, 9}
    bench.on(bench.frame + 30000, 59, channel=4)
    bench.run(bench.frame + 1)
    assert cents(bench, string_of(bench, 5, 59)) == 0.0  # its bend has been forgotten


def test_the_parameter_stays_chosen_for_a_second_entry():
    bench = mpe_bench("keyboard")
    mcm(bench, LOWER, 9)
    bench.cc(bench.frame + 1, cc.DATA_MSB, 3, channel=0)
    assert bench.counters["zones_set"] == 2 and found_zones(bench)[LOWER] == (1, 2, 3, 4)


def test_system_reset_brings_back_the_modes_zones():
    bench = mpe_bench()
    mcm(bench, LOWER, 0)
    mcm(bench, UPPER, 4)
    bench.send(bench.frame + 1, 0xFF)
    assert found_zones(bench) == {LOWER: tuple(range(1, 17)), UPPER: ()}


def test_channel_10_is_percussion_only_outside_zones():
    bench = mpe_bench()
    bench.on(0, 60, channel=9)
    assert len(bench.held()) == 1
    mcm(bench, LOWER, 8)
    bench.on(bench.frame + 1, 60, channel=9)
    assert bench.held() == {} and bench.counters["notes_percussion"] == 1


# Pitch ----------------------------------------------------------------------------------------------------------------


def test_a_members_bend_and_its_masters_add_up():
    """2.4: the pitch of a note is bent by its member channel and by the master, each with its own range."""
    bench = mpe_bench()
    mcm(bench, UPPER, 6)
    bench.on(bench.frame + 1, 64, channel=2)
    bench.on(bench.frame + 1, 59, channel=12)
    bend(bench, 3, 0.125)
    bend(bench, LOWER, -0.5)
    bend(bench, 13, -0.0625)
    bend(bench, UPPER, 0.25)
    assert cents(bench, string_of(bench, 3, 64)) == pytest.approx(4800 * 0.125 - 200 * 0.5)
    assert cents(bench, string_of(bench, 13, 59)) == pytest.approx(-4800 * 0.0625 + 200 * 0.25)


def test_the_bend_range_of_one_member_is_all_members_and_the_masters_is_its_own():
    """2.4: a range sent to any member is the whole zone's; one sent to the master is the master's."""
    bench = mpe_bench()
    mcm(bench, LOWER, 7)
    mcm(bench, UPPER, 7)
    for channel, key in ((3, 64), (4, 59), (12, 55)):
        bench.on(bench.frame + 1, key, channel=channel - 1)
    for channel in (3, 4, 12, LOWER, UPPER):
        bend(bench, channel, 0.0625)
    rpn(bench, 8, 0, 24, 50)  # to a member that has no note
    rpn(bench, LOWER, 0, 5)
    bench.run(bench.frame + 5000)
    for channel, key in ((3, 64), (4, 59)):
        assert cents(bench, string_of(bench, channel, key)) == pytest.approx(0.0625 * (2450 + 500))
    assert cents(bench, string_of(bench, 12, 55)) == pytest.approx(0.0625 * (4800 + 200))
    mcm(bench, LOWER, 7)  # 2.4: back to 48 and 2
    bench.run(bench.frame + 5000)
    assert cents(bench, string_of(bench, 3, 64)) == pytest.approx(0.0625 * (4800 + 200))


def test_ranges_up_to_96_semitones_are_taken_and_strings_stop_at_an_octave():
    bench = mpe_bench()
    bench.on(0, 64, channel=1)
    rpn(bench, 5, 0, 96)
    bend(bench, 2, 0.0625)
    s = string_of(bench, 2, 64)
    assert cents(bench, s) == pytest.approx(600) and bench.counters["bends_limited"] == 0
    bend(bench, 2, 0.25)
    assert cents(bench, s) == pytest.approx(1200) and bench.counters["bends_limited"] == 1
    rpn(bench, 5, 0, 127)
    bend(bench, 2, 0.0625)
    assert cents(bench, s) == pytest.approx(600)
    bend(bench, 2, 0.1171875)  # 1125 cents
    bend(bench, LOWER, 0.5)  # 100 more
    assert cents(bench, s) == pytest.approx(1200) and bench.counters["bends_limited"] == 2


def test_a_bend_before_the_note_is_where_it_starts_and_notes_elsewhere_stay():
    """3.3.3: the state of a member channel is followed while it has no note, too."""
    bench = mpe_bench()
    bench.on(0, 59, channel=3)
    bend(bench, 3, 0.03125)
    bench.on(bench.frame + 1000, 64, channel=2)
    bench.run(bench.frame + 1)
    start = next(p for frame, kind, s, p in reversed(bench.gestures) if kind == do.TENSION)
    s = string_of(bench, 3, 64)
    assert start[0] == 2 ** (150 / 600) and cents(bench, s) == pytest.approx(150)
    assert not [1 for frame, kind, other, _ in bench.gestures if kind == do.TENSION and other != s]


def test_notes_of_one_member_channel_share_its_bend_and_end_by_their_own_keys():
    """3.2: where there are more notes than channels, a channel has several."""
    bench = mpe_bench()
    bench.on(0, 64, channel=4)
    bench.on(3000, 55, channel=4)
    bend(bench, 5, 0.02)
    both = [cents(bench, string_of(bench, 5, key)) for key in (64, 55)]
    assert both == pytest.approx([round(0.02 * 8192) / 8192 * 4800] * 2)
    bench.off(bench.frame + 1, 64, channel=4)
    assert [key for key, _, _ in bench.held().values()] == [55]
    bench.on(bench.frame + 9000, 50, channel=4)
    bench.off(bench.frame + 1, 55, channel=4)
    assert [key for key, _, _ in bench.held().values()] == [50]
    assert bench.counters["notes_off_unmatched"] == 0


def test_a_released_note_keeps_its_bend_when_its_channel_has_another():
    """3.3.3: after the note-off per-note control no longer affects the note; the master's still does."""
    bench = mpe_bench()
    bench.cc(0, cc.PEDAL, 127, channel=0)
    bench.on(10, 64, channel=1)
    bend(bench, 2, 0.0625)
    old = string_of(bench, 2, 64)
    bench.off(bench.frame + 1, 64, channel=1)
    bend(bench, 2, -0.03125)
    bench.on(bench.frame + 1, 50, channel=1)
    bench.run(bench.frame + 1)
    new = string_of(bench, 2, 50)
    assert (cents(bench, old), cents(bench, new)) == (pytest.approx(300), pytest.approx(-150))
    bend(bench, 2, 0.125)
    rpn(bench, 9, 0, 24)
    bend(bench, LOWER, 0.5)
    assert (cents(bench, old), cents(bench, new)) == (pytest.approx(400), pytest.approx(400))
    other = swapped(bench, "mpe")
    bend(other, 2, 0.0)
    bend(other, LOWER, -0.5)
    assert (cents(other, old), cents(other, new)) == (pytest.approx(200), pytest.approx(-100))


def test_a_string_plucked_again_follows_its_channel_again():
    bench = mpe_bench()
    bench.cc(0, cc.PEDAL, 127, channel=0)
    bench.on(10, 64, channel=1)
    s = string_of(bench, 2, 64)
    bench.off(9000, 64, channel=1)
    bench.on(18000, 64, channel=1)
    bend(bench, 2, 0.0625)
    assert string_of(bench, 2, 64) == s and cents(bench, s) == pytest.approx(300)


def test_a_note_that_rings_out_does_not_follow_its_channels_next_note():
    bench = mpe_bench()
    bench.on(0, 64, channel=1)
    s = string_of(bench, 2, 64)
    bench.off(9000, 64, channel=1)
    bench.bend(9100, 4000, channel=1)
    bench.on(9100, 50, channel=1)
    bench.run(9100 + bench.lead)
    moved = [(other, p[0]) for _, kind, other, p in bench.gestures if kind == do.TENSION]
    assert [other for other, _ in moved] != [] and s not in dict(moved)


# Pressure, timbre, zone messages --------------------------------------------------------------------------------------


def vibrato(bench, channel, key):
    """Depth [cents] of the note's vibrato half a second later."""
    slot = int(bench.i[at.I_VIBRATO_SLOT])
    for now in range(-(-bench.frame // slot) * slot, bench.frame + 24000, slot):
        bench.run(now)
        follow_vibrato(bench.d, bench.i, now)
    return float(bench.d[at.D_DEPTH + string_of(bench, channel, key)])


def test_pressure_is_the_notes_own_the_masters_is_everyones_and_the_larger_counts():
    bench = mpe_bench()
    full = bench.guitar.articulation.vibrato_depth
    bench.on(0, 64, channel=1)
    bench.on(0, 59, channel=2)
    bench.send(10, 0xD0 | 1, 64)
    assert [vibrato(bench, *note) for note in ((2, 64), (3, 59))] == pytest.approx([full * 64 / 127, 0.0])
    bench.send(bench.frame, 0xD0, 32)
    assert [vibrato(bench, *note) for note in ((2, 64), (3, 59))] == pytest.approx([full * 64 / 127, full * 32 / 127])
    bench.cc(bench.frame, cc.PEDAL, 127, channel=0)
    bench.off(bench.frame, 64, channel=1)
    bench.send(bench.frame, 0xD0 | 1, 127)  # for a note to come; the one that rings has left the channel
    assert vibrato(bench, 2, 64) == pytest.approx(full * 32 / 127)


def test_timbre_of_the_master_moves_that_of_the_members():
    def place(mode, *messages):
        bench = mpe_bench(mode)
        for channel, value in messages:
            bench.cc(0, cc.PLACE, value, channel - 1)
        bench.on(10, 64, channel=1)
        bench.run(100)
        return bench.plucks()[0][2][0]

    for member, master, both in ((100, 44, 80), (20, 64, 20), (20, 10, 0), (100, 120, 127)):
        assert place("mpe", (2, member), (1, master)) == place("keyboard", (2, both))
    assert place("keyboard", (2, 100), (1, 44)) == place("keyboard", (2, 100))


def test_the_masters_controllers_are_the_whole_zones():
    """2.3: pedals and other zone messages on the master are for all of its notes, and for no other zone's."""
    bench = mpe_bench()
    mcm(bench, LOWER, 7)
    mcm(bench, UPPER, 7)
    bench.cc(bench.frame + 1, cc.PEDAL, 127, channel=0)
    for channel, key in ((2, 64), (3, 59), (12, 55)):
        bench.on(bench.frame + 1, key, channel=channel - 1)
    for channel, key in ((2, 64), (3, 59), (12, 55)):
        bench.off(bench.frame + 9000, key, channel=channel - 1)
    assert {key for key, _, _ in bench.held().values()} == {64, 59}
    bench.cc(bench.frame + 1, cc.PEDAL, 0, channel=0)
    assert bench.held() == {}


@pytest.mark.parametrize("controller", [cc.SOUND_OFF, cc.NOTES_OFF, 124, 125])
def test_all_off_on_the_master_is_for_its_zone(controller):
    bench = mpe_bench()
    mcm(bench, LOWER, 7)
    mcm(bench, UPPER, 7)
    for channel, key in ((1, 64), (3, 59), (12, 55), (16, 50)):
        bench.on(bench.frame + 1, key, channel=channel - 1)
    bench.cc(bench.frame + 9000, controller, 0, channel=2)
    assert {channel + 1 for _, channel, _ in bench.held().values()} == {1, 12, 16}
    bench.cc(bench.frame + 1, controller, 0, channel=15)
    assert {channel + 1 for _, channel, _ in bench.held().values()} == {1}


def test_reset_controllers_on_the_master_resets_its_members_too():
    bench = mpe_bench()
    bench.on(0, 64, channel=1)
    bend(bench, 2, 0.0625)
    bend(bench, LOWER, 0.5)
    bench.cc(bench.frame + 1, cc.RESET, 0, channel=0)
    bench.run(bench.frame + 5000)
    assert cents(bench, string_of(bench, 2, 64)) == 0.0
    bend(bench, 2, 0.0625)
    assert cents(bench, string_of(bench, 2, 64)) == pytest.approx(300)


def test_notes_of_the_master_are_played_and_an_ignored_controller_is_counted_once():
    bench = mpe_bench()
    bench.on(0, 64, channel=0)
    bend(bench, LOWER, 0.5)
    bend(bench, 2, 0.5)
    assert cents(bench, string_of(bench, 1, 64)) == pytest.approx(100)
    bench.cc(bench.frame, 3, 1, channel=0)
    assert bench.counters["controllers_ignored"] == 1


def test_mode_4_gives_each_member_one_voice():
    """2.2: in mode 4 a new note on a member channel ends the one before; mode 3 brings chords back."""
    for sender in (LOWER, 2):
        bench = mpe_bench()
        bench.cc(0, cc.MONO, 15, channel=sender - 1)
        bench.on(10, 45, channel=4)
        bench.on(10, 64, channel=5)
        bench.on(9000, 59, channel=4)
        assert {key for key, _, _ in bench.held().values()} == {59, 64}
        bench.cc(10000, cc.POLY, 0, channel=sender - 1)
        bench.on(40000, 45, channel=4)
        bench.on(50000, 59, channel=4)
        assert len(bench.held()) == 2


# Strings with MPE expression ------------------------------------------------------------------------------------------


def test_guitar_mpe_follows_a_configuration_message_and_bends_as_mpe_does():
    bench = mpe_bench("guitar-mpe")
    for channel in range(2, 8):
        bench.on(0, KEYS[channel - 2], channel=channel - 1)
    bend(bench, 4, 0.0625)
    bend(bench, LOWER, 0.5)
    assert [cents(bench, 5 - k) for k in range(6)] == pytest.approx([100, 100, 400, 100, 100, 100])
    mcm(bench, LOWER, 3)
    bench.on(bench.frame + 60000, 66, channel=1)
    bench.on(bench.frame, 45, channel=7)
    assert places(bench)[1] == (1, 2, 66) and bench.counters["notes_beyond_strings"] == 1
    mcm(bench, UPPER, 6)  # the highest string next to its master, as below
    bench.on(bench.frame + 60000, 61, channel=13)
    assert places(bench)[13] == (2, 2, 61)


# No note hangs --------------------------------------------------------------------------------------------------------

_CHANNEL = st.integers(0, 15)
_NUMBERS = st.sampled_from([1, 6, 20, 38, 64, 65, 66, 68, 74, 98, 100, 101, 120, 121, 123, 126, 127])
_MESSAGES = st.one_of(
    st.tuples(st.sampled_from([0x90, 0x80]), _CHANNEL, st.integers(36, 80), st.integers(0, 127)),
    st.tuples(st.just(0x90), st.integers(0, 3), st.integers(58, 66), st.integers(1, 127)),
    st.tuples(st.just(0xB0), _CHANNEL, _NUMBERS, st.integers(0, 127)),
    st.tuples(st.just("mcm"), st.sampled_from([LOWER, UPPER]), st.integers(0, 15), st.just(0)),
    st.tuples(st.just(0xE0), _CHANNEL, st.integers(0, 127), st.integers(0, 127)),
    st.tuples(st.just("mode"), st.sampled_from(["keyboard", "guitar", "mpe", "guitar-mpe"]), st.just(0), st.just(0)),
)


@settings(max_examples=60, deadline=None)
@given(
    mode=st.sampled_from(["keyboard", "guitar", "mpe", "guitar-mpe"]),
    events=st.lists(st.tuples(st.sampled_from([0, 0, 1, 700, 9000]), _MESSAGES), max_size=60),
)
def test_no_note_hangs_in_any_mode(mode, events):
    """Whatever is sent and whatever guitars follow each other: after CC 121 and 123 everywhere no string sounds."""
    bench = mpe_bench(mode)
    for wait, (status, *data) in events:
        frame = bench.frame + wait
        if status == "mcm":
            mcm(bench, data[0], data[1])
        elif status == "mode":
            bench.run(frame)
            bench = swapped(bench, data[0])
        else:
            bench.send(frame, status | data[0], data[1], data[2])
    for channel in range(16):
        bench.cc(bench.frame, cc.RESET, 0, channel)
        bench.cc(bench.frame, cc.NOTES_OFF, 0, channel)
    assert bench.held() == {}
    bench.finish()
    assert all(string.sounding == -1 for string in bench.strings)
    assert not bench.i[at.I_OWED : at.I_OWED + 16 * 128].any()
    counts = bench.counters
    assert counts["notes_on"] == counts["notes_played"] + counts["notes_dropped"] + counts["notes_percussion"]
