"""Takes as files: what is written is read, sequencers play it at its speed, and no accident leaves it unreadable."""

import dataclasses
import errno
import itertools
import json
import random
from fractions import Fraction

import mido
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ukrt.drivers.growing import GrowingTake
from ukrt.drivers.midi_file import load_midi_file
from ukrt.drivers.take import MAX_DELTA, Sound, tempo_at, ticks_and_tempo
from ukrt.drivers.take_reader import is_take, read_take
from ukrt.engine.stage_layout import KIND_RESET, KIND_SHED, KIND_SHIFT, KIND_SWAP
from ukrt.errors import UkrtError
from ukrt.model.presets import load_preset

PAPER = load_preset("paper")
SETTINGS = {"limiter": True, "output_gain": 0.1}
SOUND = Sound(PAPER, 48000.0, {"name": "hall.wav", "file": "/tmp/hall.wav", "sha256": "0" * 64}, 0.1)
OTHER = dataclasses.replace(SOUND, guitar=dataclasses.replace(PAPER, name="Größe"), sample_rate=44100.0, gain=3.5)
NOTE = 0x90 << 16 | 60 << 8 | 100
SHED, RESET, SWAP = (kind << KIND_SHIFT for kind in (KIND_SHED, KIND_RESET, KIND_SWAP))
ENTRIES = [(0, NOTE), (10, SHED | 2), (10, NOTE), (11, SWAP | 1), (11, 0xC0 << 16 | 5 << 8), (500, RESET | 64),
           (500, 0xFF << 16), (501, 0x90 << 16 | 200 << 8 | 1), (9000, 0xE0 << 16 | 127 << 8)]  # fmt: skip


def sounds(number):
    return OTHER if number == 1 else dataclasses.replace(OTHER, sample_rate=44100.0 + number)


@pytest.fixture
def take(tmp_path):
    """A take with every kind of entry."""
    file = GrowingTake(tmp_path / "take.mid", SOUND, "pressure", 2, SETTINGS)
    file.append(ENTRIES, 10_000, sounds)
    file.close()
    return tmp_path / "take.mid"


def entries_of(take):
    return list(zip(take.event_frames.tolist(), take.event_words.tolist(), strict=True))


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
    file = GrowingTake(path, dataclasses.replace(SOUND, sample_rate=float(rate)), "pressure", 2, SETTINGS)
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
    file = GrowingTake(tmp_path / "take.mid", SOUND, "pressure", 2, SETTINGS)
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
    file = GrowingTake(tmp_path / "take.mid", SOUND, "pressure", 2, SETTINGS)
    file.append([(5, NOTE)], 100, sounds)
    file.append([(200, NOTE)], 300, sounds, lost=17)
    file.close()
    read = read_take(tmp_path / "take.mid")
    assert entries_of(read) == [(5, NOTE), (200, NOTE)] and read.lost == 17
    assert len(read.warnings) == 1 and "17 entries" in read.warnings[0]


def test_a_take_cut_off_anywhere_is_read_up_to_there_or_refused_in_a_sentence(take):
    data = take.read_bytes()
    begin = data.index(b"\xff\x51")  # the tempo follows the first preset
    outcomes = set()
    for size in [*range(0, begin, 997), *range(begin - 20, begin + 100), *range(begin, len(data) - 200, 101),
                 *range(len(data) - 200, len(data))]:  # fmt: skip
        take.write_bytes(data[:size])
        try:
            read = read_take(take)
        except UkrtError as error:
            assert "\n" not in str(error) and "take.mid" in str(error)
            outcomes.add("refused")
            continue
        found = entries_of(read)
        assert found == ENTRIES[: len(found)]
        assert [0, *(frame for frame, _ in found)][-1] <= read.frames <= [*ENTRIES, (10_000, 0)][len(found)][0]
        assert len(read.warnings) == 1 and "breaks off" in read.warnings[0]
        outcomes.add(len(found))
    assert outcomes == {"refused", *range(len(ENTRIES) + 1)}


class Killed(BaseException):
    """Stands for the end of the process: nothing is done after it."""


class Disk:
    """A file whose writes end after so many new bytes, with an error.

    Bytes within one page of what is there already are written whole or not at all, as systems do it.
    """

    def __init__(self, file, limit, error):
        self._file, self._left, self._error = file, limit, error
        self._size = file.seek(0, 2)
        self.written, self.failing = 0, False

    def __getattr__(self, name):
        return getattr(self._file, name)

    def write(self, data):
        at = self._file.tell()
        in_place = at + len(data) <= self._size
        assert not in_place or at // 4096 == (at + len(data) - 1) // 4096
        if in_place and isinstance(self._error, OSError):
            return self._file.write(data)
        size = len(data) if self._left is None else min(len(data), self._left - self.written)
        if size <= 0 or (in_place and size < len(data)):
            raise self._error
        self.written += size
        self._size = max(self._size, at + size)
        return self._file.write(data[:size])


def write_with_an_end(path, limit, error):
    """A take to which two portions are appended on a `Disk`; returns what it failed with, and the bytes written."""
    file = GrowingTake(path, SOUND, "pressure", 2, SETTINGS)
    file.append(ENTRIES[:2], 10, sounds)
    file._file = disk = Disk(file._file, limit, error)
    try:
        file.append(ENTRIES[2:8], 8000, sounds)
        file.append(ENTRIES[8:], 10_000, sounds)
    except (Killed, OSError) as caught:
        return caught, disk.written
    finally:
        disk.close()
    return None, disk.written


@pytest.mark.parametrize("error", [Killed(), OSError(errno.ENOSPC, "No space left on device")])
def test_a_process_killed_or_a_disk_full_at_any_byte_leaves_a_whole_take(tmp_path, error):
    path = tmp_path / "take.mid"
    total = write_with_an_end(path, None, error)[1]
    states = set()
    for limit in [*range(0, total - 150, 61), *range(total - 150, total)]:
        path.unlink()
        assert write_with_an_end(path, limit, error)[0] is error
        read = read_take(path)
        assert read.warnings == () and entries_of(read) == ENTRIES[: len(read.event_words)]
        assert len(load_midi_file(path).time_s) >= 1  # others find the notes, too
        states.add((len(read.event_words), read.frames))
    assert states == {(2, 10), (8, 8000)} | ({(9, 10_000)} if isinstance(error, Killed) else set())


def test_an_end_never_reaches_over_a_page(tmp_path):
    file = GrowingTake(tmp_path / "take.mid", SOUND, "pressure", 2, SETTINGS)
    file._file = Disk(file._file, None, None)  # which asserts it
    rng = random.Random(1)
    frame, expected = 0, []
    for _ in range(4000):
        frame += rng.choice([1, 200, 20_000])
        expected.append((frame, NOTE))
        file.append(expected[-1:], frame + rng.choice([0, 0, 300]), sounds)
        frame = file.frames
        file.append([], frame := frame + rng.choice([0, 1, 200, 20_000]), sounds)
    file.close()
    read = read_take(tmp_path / "take.mid")
    assert entries_of(read) == expected and read.frames == frame


def test_mutated_takes_raise_nothing_but_our_errors(take, tmp_path):
    data = take.read_bytes()
    begin = data.index(b"\xff\x51")
    rng = random.Random(5)
    target = tmp_path / "mutated.mid"
    read_ones = 0
    for _ in range(1500):
        mutated = bytearray(data)
        for _ in range(rng.choice([1, 1, 2, 10])):
            at = rng.choice([rng.randrange(len(data)), rng.randrange(400), rng.randrange(begin, len(data))])
            match rng.randrange(3):
                case 0:
                    mutated[at % len(mutated)] = rng.randrange(256)
                case 1:
                    del mutated[at % len(mutated) : at % len(mutated) + rng.choice([1, 5, 1000])]
                case 2:
                    mutated[at % len(mutated) : at % len(mutated)] = rng.choice(
                        [b"\0", b"\xff" * 9, b"9" * 5000, b"[" * 5000, b'{"a":', b"NaN", b"1e999", b"-1", b"null"]
                    )
            if not mutated:
                break
        target.write_bytes(mutated)
        is_take(target)
        try:
            read = read_take(target)
        except UkrtError as error:
            assert "\n" not in str(error)
        else:
            read_ones += 1
            assert np.all(np.diff(read.event_frames) >= 0) and read.frames >= 0
            read.parts()
    assert read_ones > 100


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
