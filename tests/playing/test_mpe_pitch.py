"""Bends of members and masters, after MIDI Polyphonic Expression (M1-100-UM v1.1), whose sections are named in
tests."""

import pytest
from modes_bench import LOWER, UPPER, bend, cents, mcm, mpe_bench, rpn, string_of, swapped

from ukrt.engine import controller_layout as cc
from ukrt.engine import gestures as do


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


def test_sostenuto_and_fine_tuning_of_a_master_are_its_members():
    bench = mpe_bench()
    bench.on(0, 64, channel=1)
    s = string_of(bench, 2, 64)
    bench.cc(5000, cc.SOSTENUTO, 127, channel=0)
    bench.off(6000, 64, channel=1)
    for frame, controller, value in ((7000, 101, 0), (7000, 100, 1), (7000, 6, 96)):
        bench.cc(frame, controller, value, channel=0)
    bench.run(20_000)
    assert string_of(bench, 2, 64) == s and cents(bench, s) == pytest.approx(50)
    bench.cc(20_000, cc.SOSTENUTO, 0, channel=0)
    assert bench.held() == {}
