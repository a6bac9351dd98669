"""Takes after accidents: cut off, killed or out of room at any byte, mutated; read as far as they go, or refused."""

import errno
import random

import numpy as np
import pytest
from take_bench import ENTRIES, NOTE, entries_of, sounds, start_take, write_take

from ukrt.drivers.files.midi import load_midi_file
from ukrt.drivers.takes.reader import is_take, read_take
from ukrt.errors import UkrtError


@pytest.fixture
def take(tmp_path):
    return write_take(tmp_path / "take.mid")


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
    file = start_take(path)
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
    assert states == {(2, 10), (8, 8000)} | ({(len(ENTRIES), 10_000)} if isinstance(error, Killed) else set())


def test_an_end_never_reaches_over_a_page(tmp_path):
    file = start_take(tmp_path / "take.mid")
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
