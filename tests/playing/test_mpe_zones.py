"""Zones, after MIDI Polyphonic Expression (M1-100-UM v1.1), whose sections are named in tests.

Which channels a sequence of configuration messages leaves in which zone is worked out with sets (`zones_by_the_book`);
what a channel is to the player is found by playing on it.
"""

import random

import pytest
from modes_bench import LOWER, PRESET_RANGE, UPPER, bend, cents, mcm, mpe_bench, string_of

from ukrt.engine import controller_layout as cc


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
