"""No note hangs, whatever is sent, in whatever mode, and whatever modes follow each other."""

from hypothesis import given, settings
from hypothesis import strategies as st
from modes_bench import LOWER, UPPER, mcm, mpe_bench, swapped

from ukrt.engine import controller_layout as cc
from ukrt.engine import player_layout as at

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
