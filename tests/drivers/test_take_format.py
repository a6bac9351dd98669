"""Takes as files: what is written is read, sequencers play it at its speed, and no accident leaves it unreadable."""

import dataclasses
import itertools
import json
from fractions import Fraction

import mido
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from take_bench import (
    ENTRIES,
    NOTE,
    OTHER,
    RESET,
    SETTINGS,
    SHED,
    SOUND,
    SWAP,
    entries_of,
    sounds,
    start_take,
    write_take,
)

from ukrt.drivers.files.midi import load_midi_file
from ukrt.drivers.takes.reader import is_take, read_take
from ukrt.drivers.takes.take import MAX_DELTA, tempo_at, ticks_and_tempo
from ukrt.engine.stage_layout import KIND_SHIFT, KIND_SWAP
from ukrt.errors import UkrtError


@pytest.fixture
def take(tmp_path):
    return write_take(tmp_path / "take.mid")


@pytest.mark.parametrize(
    ("rate", "expected"),
    [(44100, (22050, 500000)), (48000, (24000, 500000)), (88200, (22050, 250000)), (96000, (24000, 250000)),
     (176400, (22050, 125000)), (192000, (24000, 125000))],
)  # fmt: skip
def test_a_tick_is_a_frame_at_usual_rates(rate, expected):
    assert ticks_and_tempo(rate) == expected
    assert tempo_at(rate, expected[0]) == expected[1]


@given(rate=st.one_of(st.integers(44100, 192000), st.floats(44100, 192000)))
def test_a_tick_is_a_frame_at_any_rate_as_nearly_as_whole_numbers_can(rate):
    division, tempo = ticks_and_tempo(rate)
    assert 1 <= division <= 32767 and 1 <= tempo < 2**24
    error = abs(Fraction(tempo, division) * Fraction(rate) / 1_000_000 - 1)
    assert error < 1e-6
    exact = (1_000_000 / Fraction(rate)).denominator <= 32767
    assert (error == 0) == exact


def test_everything_that_was_written_is_read(take):
    read = read_take(take)
    assert is_take(take) and read.warnings == ()
    assert entries_of(read) == ENTRIES and read.frames == 10_000
    assert (read.signal, read.channels, read.settings, read.lost) == ("pressure", 2, SETTINGS, 0)
    assert read.sounds == {0: dataclasses.replace(SOUND, gain=1.0), 1: OTHER}  # the first gain is among the settings
    assert read.parts() == [(0, 11, 48000.0), (11, 10_000, 44100.0)]
    assert set(read.environment) == {"kernels", "numba", "numpy", "machine", "processor", "libc"}


words = st.one_of(
    st.builds(lambda a, b, c: a << 16 | b << 8 | c, st.integers(0x80, 0xBF), st.integers(0, 127), st.integers(0, 127)),
    st.builds(lambda a, b: a << 16 | b << 8, st.integers(0xC0, 0xDF), st.integers(0, 127)),
    st.builds(lambda a, b, c: a << 16 | b << 8 | c, st.sampled_from([0xF0, 0xF4, 0xF5, 0xF7]), st.integers(0, 127),
              st.integers(0, 130)),
    st.builds(lambda a, b, c: a << 16 | b << 8 | c, st.integers(0, 255), st.integers(128, 255), st.integers(0, 255)),
    st.integers(0, 2**32 - 1).map(lambda level: SHED | level),
    st.integers(0, 2**32 - 1).map(lambda frames: RESET | frames),
    st.integers(1, 5).map(lambda number: SWAP | number),
)
steps = st.one_of(st.integers(0, 3), st.integers(0, 100_000), st.integers(2**27, 2**30))


@settings(max_examples=60, deadline=None)
@given(
    journal=st.lists(st.tuples(steps, words), max_size=12),
    cuts=st.lists(st.integers(0, 12), max_size=3),
    rest=steps,
    rate=st.sampled_from([44100, 48000, 96000, 50001.5]),
)
def test_any_journal_comes_back_whatever_the_portions_in_which_it_was_written(
    tmp_path_factory, journal, cuts, rest, rate
):
    path = tmp_path_factory.mktemp("take") / "take.mid"
    frames = np.cumsum([0, *(step for step, _ in journal)])[1:].tolist()
    entries = list(zip(frames, [word for _, word in journal], strict=True))
    file = start_take(path, float(rate))
    bounds = sorted({0, *(min(cut, len(entries)) for cut in cuts), len(entries)})
    for first, last in itertools.pairwise(bounds):
        file.append(entries[first:last], frames[last - 1], sounds)
    total = (frames[-1] if frames else 0) + rest
    file.append([], total, sounds)
    file.close()
    read = read_take(path)
    assert entries_of(read) == entries and read.frames == total and read.warnings == ()
    assert all(
        read.sounds[word & 0xFF] == sounds(word & 0xFF) for _, word in entries if word >> KIND_SHIFT == KIND_SWAP
    )
    data = path.read_bytes()
    assert int.from_bytes(data[18:22], "big") == len(data) - 22
    ticks = sum(message.time for message in mido.MidiFile(path).tracks[0])
    assert ticks == total


def test_sequencers_play_takes_at_their_speed_with_the_frames_beyond_what_one_delta_holds(tmp_path):
    frames = [0, 48000, 3 * MAX_DELTA + 7, 3 * MAX_DELTA + 8]
    file = start_take(tmp_path / "take.mid")
    file.append([(frame, NOTE) for frame in frames], 4 * MAX_DELTA, sounds)
    file.append([], 6 * MAX_DELTA, sounds)
    file.close()
    score = load_midi_file(tmp_path / "take.mid", max_minutes=1e9)
    np.testing.assert_array_equal(np.rint(score.time_s * 48000).astype(int), frames)
    assert score.warnings == () and score.title == "paper"
    assert score.duration_s == pytest.approx(6 * MAX_DELTA / 48000, rel=1e-12)
    assert read_take(tmp_path / "take.mid").frames == 6 * MAX_DELTA
    now, times = 0.0, []
    for message in mido.MidiFile(tmp_path / "take.mid"):
        now += message.time
        if message.type == "note_on":
            times.append(now)
    np.testing.assert_allclose(times, np.array(frames) / 48000, rtol=1e-12)


def test_lost_entries_are_told(tmp_path):
    file = start_take(tmp_path / "take.mid")
    file.append([(5, NOTE)], 100, sounds)
    file.append([(200, NOTE)], 300, sounds, lost=17)
    file.close()
    read = read_take(tmp_path / "take.mid")
    assert entries_of(read) == [(5, NOTE), (200, NOTE)] and read.lost == 17
    assert len(read.warnings) == 1 and "17 entries" in read.warnings[0]


REFUSED = [
    ({"sample_rate": None}, "sample_rate"),
    ({"sample_rate": True}, "sample_rate"),
    ({"signal": "noise"}, "signal"),
    ({"channels": 2.5}, "channels"),
    ({"settings": []}, "settings"),
    ({"division": 480}, "another program"),
]


@pytest.mark.parametrize(("change", "words"), REFUSED)
def test_heads_that_say_the_impossible_are_refused_by_key(take, change, words):
    rewrite_head(take, change)
    with pytest.raises(UkrtError, match=words) as caught:
        read_take(take)
    assert "\n" not in str(caught.value) and "take.mid" in str(caught.value)


def test_takes_of_a_later_format_are_refused(take):
    take.write_bytes(take.read_bytes().replace(b"ukrt take 1 ", b"ukrt take 2 ", 1))
    with pytest.raises(UkrtError, match="format 2, 1 is"):
        read_take(take)


def test_ordinary_midi_files_are_no_takes(tmp_path):
    song = mido.MidiFile(type=0)
    song.add_track(name="ukrt take").append(mido.Message("note_on", note=60))
    song.save(tmp_path / "song.mid")
    (tmp_path / "empty.mid").write_bytes(b"")
    assert not any(is_take(tmp_path / name) for name in ("song.mid", "empty.mid", "none.mid", "", "a\0b"))


def rewrite_head(path, change):
    """Change keys of the JSON in a take's first event."""
    data = path.read_bytes()
    first = data.index(b"{")
    last = data.index(b"}}\0\xff\x01") + 2
    tree = json.loads(data[first:last]) | change
    body = b"ukrt take 1 " + json.dumps(tree).encode()
    size = bytes((len(body) >> 7 | 0x80, len(body) & 0x7F))
    path.write_bytes(data[:22] + b"\0\xff\x01" + size + body + data[last:])
