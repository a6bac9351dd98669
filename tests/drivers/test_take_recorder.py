"""The recorder: what an engine of known samples gives is on the disk, whole, whatever is lost, full or changed."""

import errno
import struct
import threading

import numpy as np
import pytest
import soundfile
from take_engine import FakeEngine, FakeInstance

from ukrt.drivers.takes import growing
from ukrt.drivers.takes.reader import read_take
from ukrt.drivers.takes.recorder import Recorder
from ukrt.engine.stage_layout import KIND_SHIFT, KIND_SWAP
from ukrt.errors import AudioFileError, MidiFileError

NOTE = 0x90 << 16 | 60 << 8 | 100


@pytest.fixture
def engine():
    return FakeEngine()


@pytest.fixture
def record(engine, tmp_path):
    """Starts a recorder of everything without its thread."""
    return Recorder(engine, tmp_path / "take.mid", tmp_path / "take.wav")


def sound_of(path):
    return soundfile.read(path, dtype="float32", always_2d=True)


def test_files_hold_everything_after_every_look(engine, record, tmp_path):
    rng = np.random.default_rng(3)
    for look in range(30):
        for _ in range(rng.integers(0, 4)):
            engine.note(NOTE + look)
            engine.run(int(rng.integers(0, 1500)))
        record.drain()
        take, (samples, rate) = read_take(tmp_path / "take.mid"), sound_of(tmp_path / "take.wav")
        np.testing.assert_array_equal(samples, engine.samples(0, engine.frame))
        acted = [entry for entry in engine.entries if entry[0] < engine.frame]
        assert list(zip(take.event_frames.tolist(), take.event_words.tolist(), strict=True)) == acted
        assert take.frames == engine.frame and rate == 48000 and take.warnings == ()
    record.close()
    assert len(acted) > 20
    assert record.counts() == {
        "entries": len(acted), "lost_entries": 0, "take_frames": engine.frame, "sound_frames": engine.frame,
        "lost_frames": 0, "files": [str(tmp_path / "take.mid"), str(tmp_path / "take.wav")],
    }  # fmt: skip
    assert record.news() == []
    record.close()
    assert record.counts()["take_frames"] == engine.frame


def test_the_thread_looks_by_itself_and_followers_see_every_entry_once(engine):
    seen, enough = [], threading.Event()

    def follow(entries):
        seen.extend(entries.tolist())
        if len(seen) >= 2:
            enough.set()

    recorder = Recorder(engine)  # nothing is recorded
    recorder.follow(follow)
    recorder.start()
    engine.note(NOTE)
    engine.run(100)
    engine.note(NOTE + 1)
    engine.run(100)
    assert enough.wait(10.0)
    recorder.close()
    assert seen == [[0, NOTE], [100, NOTE + 1]] and recorder.counts()["files"] == []


def test_entries_and_samples_that_were_overwritten_are_told_and_replaced_by_silence(engine, record, tmp_path):
    engine.note(NOTE)
    engine.run(500)
    record.drain()
    for _ in range(20):
        engine.note(NOTE)
    engine.run(engine.RING + 700)
    engine.lose_entries(7)
    record.close()
    samples, _ = sound_of(tmp_path / "take.wav")
    expected = engine.samples(0, engine.frame)
    expected[500:1200] = 0.0
    np.testing.assert_array_equal(samples, expected)
    counts, news = record.counts(), record.news()
    assert (counts["lost_entries"], counts["lost_frames"]) == (7, 700)
    assert [("7 entries" in one, "700 frames" in one) for one in news] == [(True, False), (False, True)]
    assert read_take(tmp_path / "take.mid").lost == 7


def test_another_sample_rate_goes_on_in_another_file(engine, record, tmp_path):
    engine.run(1000)
    other = FakeInstance(sample_rate=44100.0, gain=2.5)
    record.announce(other)
    engine.swap(other)
    engine.note(NOTE)
    engine.run(300)
    (tmp_path / "take-3.wav").write_bytes(b"something else")
    again = FakeInstance(sample_rate=96000.0)
    engine.swap(again)  # not announced
    engine.run(200)
    record.close()
    parts = {"take.wav": (0, 1000, 48000), "take-2.wav": (1000, 1300, 44100), "take-4.wav": (1300, 1500, 96000)}
    for name, (first, last, rate) in parts.items():
        samples, found = sound_of(tmp_path / name)
        np.testing.assert_array_equal(samples, engine.samples(first, last))
        assert found == rate
    take = read_take(tmp_path / "take.mid")
    assert take.parts() == list(parts.values())
    assert [(one.sample_rate, one.gain) for one in take.sounds.values()][1:] == [(44100.0, 2.5), (96000.0, 1.0)]
    assert record.counts()["files"][1:] == [str(tmp_path / name) for name in parts]
    assert len(record.news()) == 2


def test_a_swap_at_the_same_rate_stays_in_the_file(engine, record, tmp_path):
    engine.run(10)
    engine.swap(FakeInstance())
    engine.run(10)
    record.close()
    assert len(sound_of(tmp_path / "take.wav")[0]) == 20 and not (tmp_path / "take-2.wav").exists()
    assert read_take(tmp_path / "take.mid").event_words.tolist() == [KIND_SWAP << KIND_SHIFT | 1]


def test_a_full_wav_file_goes_on_in_another(engine, monkeypatch, tmp_path):
    monkeypatch.setattr(growing, "WAV_MAX_BYTES", 8 * 1000)
    recorder = Recorder(engine, audio=tmp_path / "take.wav")
    engine.run(700)
    recorder.drain()
    engine.run(1800)
    recorder.close()
    parts = [sound_of(tmp_path / name)[0] for name in ("take.wav", "take-2.wav", "take-3.wav")]
    assert [len(part) for part in parts] == [1000, 1000, 500]
    np.testing.assert_array_equal(np.concatenate(parts), engine.samples(0, 2500))


@pytest.mark.parametrize("name", ["_take", "_wav"])
def test_a_full_disk_ends_one_file_in_a_sentence_and_the_rest_goes_on(engine, record, tmp_path, name):
    engine.note(NOTE)
    engine.run(5000)
    record.drain()
    file = getattr(record, name) if name == "_take" else record._wav._file
    file._file = FullDisk(file._file, room=0 if name == "_take" else 3000)
    engine.note(NOTE)
    engine.run(1000)
    record.drain()
    engine.note(NOTE)
    engine.run(1000)
    record.close()
    news = record.news()
    assert len(news) == 1 and "No space left" in news[0] and str(tmp_path) in news[0]
    samples, take = sound_of(tmp_path / "take.wav")[0], read_take(tmp_path / "take.mid")
    np.testing.assert_array_equal(samples, engine.samples(0, 5000 if name == "_wav" else 7000))
    assert (take.frames, len(take.event_words)) == ((5000, 1) if name == "_take" else (7000, 3))
    assert (tmp_path / "take.wav").stat().st_size == growing.WAV_HEADER.size + 8 * len(samples)
    assert take.warnings == () and record.failure is None


def test_a_wav_file_is_playable_between_any_two_writes(engine, tmp_path):
    recorder = Recorder(engine, audio=tmp_path / "take.wav")
    engine.run(400)
    recorder.drain()
    file = recorder._wav._file
    real, put, states = file._put, [], []

    def spy(data, at):
        put.append(at)
        real(data, at)
        states.append(len(sound_of(tmp_path / "take.wav")[0]))

    file._put = spy
    engine.run(600)
    recorder.drain()
    assert put == [growing.WAV_HEADER.size + 8 * 400, 0] and states == [400, 1000]
    recorder.close()


def test_the_header_is_what_others_write(engine, tmp_path):
    recorder = Recorder(engine, audio=tmp_path / "take.wav")
    engine.run(100)
    recorder.close()
    info = soundfile.info(tmp_path / "take.wav")
    assert (info.format, info.subtype, info.channels, info.samplerate, info.frames) == ("WAV", "FLOAT", 2, 48000, 100)
    data = (tmp_path / "take.wav").read_bytes()
    assert struct.unpack("<I", data[4:8])[0] == len(data) - 8
    assert struct.unpack("<I", data[54:58])[0] == len(data) - 58


REFUSED = [
    ({"take": "there.mid"}, MidiFileError, "exists already"),
    ({"take": "take.wav"}, MidiFileError, "suffix"),
    ({"take": "none/take.mid"}, MidiFileError, "cannot be written"),
    ({"take": "take\0.mid"}, MidiFileError, "cannot be written"),
    ({"audio": "there.wav"}, AudioFileError, "exists already"),
    ({"audio": "take.flac"}, AudioFileError, "suffix"),
    ({"take": "take.mid", "audio": "there.wav"}, AudioFileError, "exists already"),
]


@pytest.mark.parametrize(("files", "kind", "words"), REFUSED)
def test_what_cannot_be_recorded_is_refused_and_leaves_nothing(engine, tmp_path, files, kind, words):
    for name in ("there.mid", "there.wav"):
        (tmp_path / name).write_bytes(b"old")
    with pytest.raises(kind, match=words) as caught:
        Recorder(engine, **{key: f"{tmp_path}/{name}" for key, name in files.items()})
    assert "\n" not in str(caught.value)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["there.mid", "there.wav"]
    assert (tmp_path / "there.wav").read_bytes() == b"old"


def test_a_recording_begins_at_the_beginning(engine, tmp_path):
    engine.run(1)
    with pytest.raises(MidiFileError, match="first frame"):
        Recorder(engine, tmp_path / "take.mid")


def test_a_fault_in_a_follower_is_told_and_everything_else_goes_on(engine, record, tmp_path):
    def fail(entries):
        raise ZeroDivisionError("a fault")

    seen = []
    record.follow(fail)
    record.follow(seen.append)
    for _ in range(2):
        engine.note(NOTE)
        engine.run(100)
        record.drain()
    record.close()
    assert len(seen) == 2 and record.failure is None
    assert ["a fault" in one for one in record.news()] == [True]
    assert read_take(tmp_path / "take.mid").frames == 200


def test_a_fault_of_the_recorder_is_told_and_what_is_recorded_stays(engine, record, tmp_path, monkeypatch):
    engine.run(100)
    record.drain()
    monkeypatch.setattr(engine, "journal", lambda since: 1 / 0)
    record.start()
    record._thread.join(10.0)
    record.close()
    assert isinstance(record.failure, ZeroDivisionError) and "nothing more is recorded" in record.news()[0]
    assert read_take(tmp_path / "take.mid").frames == len(sound_of(tmp_path / "take.wav")[0]) == 100


class FullDisk:
    """A file that can grow by ``room`` bytes; what it has can be written over."""

    def __init__(self, file, room):
        self._file, self._most = file, file.seek(0, 2) + room

    def __getattr__(self, name):
        return getattr(self._file, name)

    def write(self, data):
        room = self._most - self._file.tell()
        if room <= 0:
            raise OSError(errno.ENOSPC, "No space left on device")
        return self._file.write(data[:room])
