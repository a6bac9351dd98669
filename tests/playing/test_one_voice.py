"""Channels with one voice: CC 126 and 127, mode 4 of the MIDI 1.0 Detailed Specification."""

import pytest
from modes_bench import guitar_bench, places, ways
from player_bench import Bench

from ukrt.engine import controller_layout as cc


def mono_channels(bench):
    """Channels on which the second of two overlapping notes ends the first."""
    found = []
    for channel in range(16):
        frame = bench.frame + 40000
        bench.on(frame, 45, channel=channel)
        bench.on(frame + 9000, 59, channel=channel)
        if len(bench.held()) == 1:
            found.append(channel + 1)
        bench.cc(frame + 18000, cc.NOTES_OFF, 0, channel=channel)
        assert bench.held() == {}
    return found


@pytest.mark.parametrize(
    ("basic", "value", "wanted"),
    [(1, 6, range(1, 7)), (3, 1, [3]), (14, 6, [14, 15, 16]), (2, 0, range(2, 8)), (1, 16, set(range(1, 17)) - {10})],
)
def test_mono_on_gives_one_voice_to_m_channels_from_its_own_up_to_16(basic, value, wanted):
    """MIDI 1.0: channels N through N+M-1 up to a maximum of 16; M = 0 assigns all voices, one per channel, from N."""
    bench = Bench()
    assert mono_channels(bench) == []
    bench.cc(bench.frame + 1, cc.MONO, value, channel=basic - 1)
    assert mono_channels(bench) == list(wanted)
    bench.cc(bench.frame + 1, cc.POLY, 0, channel=basic - 1)
    assert mono_channels(bench) == []


def test_both_modes_messages_let_keys_come_up():
    for controller in (cc.MONO, cc.POLY):
        bench = Bench()
        bench.on(0, 60, channel=4)
        bench.on(0, 45, channel=8)
        bench.cc(5000, controller, 1, channel=4)
        assert [channel for _, channel, _ in bench.held().values()] == [8]


def test_a_mono_channel_of_a_keyboard_slurs_and_stays_on_its_string_where_it_can():
    bench = Bench()
    bench.cc(0, cc.MONO, 1)
    bench.on(10, 45)
    bench.on(9000, 47)
    assert ways(bench) == ["pluck", "hammer-on"] and places(bench) == {0: (5, 2, 47)}
    bench.cc(10000, cc.LEGATO, 0)
    bench.on(18000, 50)  # an open string, for a keyboard; the voice's own string has it, too
    assert ways(bench)[-1] == "pluck" and places(bench) == {0: (5, 5, 50)}


def test_poly_frees_the_strings_of_a_guitar_and_mono_gives_them_back():
    bench = guitar_bench()
    bench.cc(0, cc.POLY, 0, channel=0)
    bench.on(10, 45, channel=0)
    bench.on(10, 64, channel=0)
    bench.on(10, 52, channel=3)
    assert len(bench.held()) == 3 and bench.counters["forces_refused"] == 0
    bench.cc(20000, cc.MONO, 6, channel=0)
    bench.on(60000, 61, channel=1)
    assert places(bench)[1] == (2, 2, 61)


def test_notes_of_one_moment_are_a_chord_even_on_one_voice_and_all_end():
    bench = guitar_bench()
    bench.on(0, 66, channel=0)
    bench.on(0, 59, channel=0)
    assert len(bench.held()) == 2 and bench.counters["forces_refused"] == 1
    bench.on(9000, 68, channel=0)
    assert places(bench) == {0: (1, 4, 68)}
    for key in (66, 59, 68):
        bench.off(18000, key, channel=0)
    assert bench.held() == {} and bench.counters["notes_off_unmatched"] == 0
