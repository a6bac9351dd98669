"""Pressure, timbre and a zone's messages, after MIDI Polyphonic Expression (M1-100-UM v1.1), whose sections are
named in tests; and strings with MPE expression."""

import pytest
from modes_bench import LOWER, OPEN, UPPER, bend, cents, mcm, mpe_bench, places, string_of

from ukrt.engine import controller_layout as cc
from ukrt.engine import player_layout as at
from ukrt.engine.kernels.player_vibrato import follow_vibrato


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


def test_guitar_mpe_follows_a_configuration_message_and_bends_as_mpe_does():
    bench = mpe_bench("guitar-mpe")
    for channel in range(2, 8):
        bench.on(0, OPEN[channel - 2], channel=channel - 1)
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
