"""MIDI files: times against mido and by hand, every oddity played or refused in one sentence, hostile input bounded."""

import random
import struct

import mido
import numpy as np
import pytest
import smf
from engine.sysex import LONGEST, master_volume, messages, note_tuning

from ukrt.drivers.files import midi as midi_file
from ukrt.drivers.files import midi_track
from ukrt.drivers.files.midi import load_midi_file
from ukrt.errors import MidiFileError

END = smf.end_of_track()


@pytest.fixture
def load(tmp_path):
    """Load a file of the given bytes."""

    def load_bytes(data, **options):
        path = tmp_path / "song.mid"
        path.write_bytes(data)
        return load_midi_file(path, **options)

    return load_bytes


def refusal(load, data, **options):
    """The sentence with which these bytes are refused."""
    with pytest.raises(MidiFileError) as caught:
        load(data, **options)
    text = str(caught.value)
    assert "song.mid" in text and "\n" not in text
    return text


def random_midi_file(seed, midi_format):
    """A well-formed file written by mido: several tracks, tempo changes, running status, every channel message."""
    rng = random.Random(seed)
    song = mido.MidiFile(type=midi_format, ticks_per_beat=rng.choice([1, 96, 480, 32767]))
    for _ in range(1 if midi_format == 0 else 4):
        track = song.add_track(name="voice")
        for _ in range(60):
            time, channel = rng.choice([0, 0, rng.randrange(1000), rng.randrange(20000)]), rng.randrange(16)
            kind = rng.choice(["note_on", "note_off", "control_change", "program_change", "pitchwheel", "aftertouch",
                               "polytouch", "set_tempo", "text", "sysex"])  # fmt: skip
            if kind == "set_tempo":
                track.append(mido.MetaMessage(kind, tempo=rng.randrange(1, 2**20), time=time))
            elif kind == "text":
                track.append(mido.MetaMessage(kind, text="x" * rng.randrange(300), time=time))
            elif kind == "sysex":
                data = rng.choice([[1, 2, 3], [127, 127, 4, 1, 0, 64], [126, 1, 9, 1], [127] * 50, [127]])
                track.append(mido.Message(kind, data=data, time=time))
            else:
                fields = {"pitchwheel": {"pitch": rng.randrange(-8192, 8192)}, "program_change": {"program": 3}}
                track.append(mido.Message(kind, channel=channel, time=time, **fields.get(kind, {})))
        track.append(mido.MetaMessage("end_of_track", time=rng.randrange(500)))
    return song


@pytest.mark.parametrize("seed", range(20))
def test_well_formed_files_agree_with_mido(seed, tmp_path):
    path = tmp_path / "song.mid"
    random_midi_file(seed, midi_format=seed % 2).save(path)
    score = load_midi_file(path, max_minutes=1e9)
    now, expected = 0.0, []
    for message in mido.MidiFile(path):
        now += message.time
        if message.type == "sysex":
            expected += [(now, *piece) for piece in messages(bytes(message.bytes()))]
        elif not message.is_meta:
            expected.append((now, *[*message.bytes(), 0][:3]))
    times, status, data1, data2 = zip(*expected, strict=True)
    assert len(times) >= 30
    np.testing.assert_allclose(score.time_s, times, rtol=1e-12, atol=1e-9)
    np.testing.assert_array_equal(score.status, status)
    np.testing.assert_array_equal(score.data1, data1)
    np.testing.assert_array_equal(score.data2, data2)
    assert score.duration_s == pytest.approx(now, rel=1e-12)
    assert score.warnings == () and score.title == "voice"


def test_note_on_times_by_hand_through_a_tempo_change_in_another_track(load):
    tempi = smf.tempo(0, 500_000) + smf.tempo(96, 1_000_000) + END
    notes = smf.note(ticks=96) + smf.note(ticks=96) + END
    score = load(smf.file(tempi, notes, midi_format=1))
    assert score.time_s.tolist() == [0.0, 0.5, 0.5, 1.5]
    assert (score.n_notes, score.duration_s) == (2, 1.5)


@pytest.mark.parametrize(
    ("frame_byte", "ticks", "rate"), [(24, 4, 96.0), (25, 40, 1000.0), (29, 100, 100 * 30000 / 1001), (30, 80, 2400.0)]
)
def test_smpte_divisions_ignore_the_tempo_and_are_exact(load, frame_byte, ticks, rate):
    body = smf.tempo(0, 1) + smf.note(ticks=12345) + END
    score = load(smf.file(body, division=(256 - frame_byte) << 8 | ticks))
    assert score.time_s[1] == pytest.approx(12345 / rate, rel=1e-15)


def test_format_2_plays_its_tracks_one_after_another_with_their_own_tempo(load):
    first, second = smf.tempo(0, 250_000) + smf.note() + smf.end_of_track(96), smf.note() + END
    score = load(smf.file(first, second, midi_format=2))
    assert score.time_s.tolist() == [0.0, 0.25, 0.5, 1.0]
    assert score.duration_s == 1.0


def exclusive_event(ticks, status, data):
    """A SysEx event: F0, or F7 for a packet that continues it or bytes to be sent as they are."""
    return smf.event(ticks, status, *smf.number(len(data)), *data)


def test_exclusive_messages_come_in_one_packet_or_in_several(load):
    whole = note_tuning({key: key + 0.25 for key in range(60, 72)})
    packets = exclusive_event(0, 0xF0, whole[1:8]) + exclusive_event(96, 0xF7, whole[8:9])
    packets += exclusive_event(96, 0xF7, whole[9:]) + exclusive_event(96, 0xF7, b"\x90\x40\x40") + END
    for body in (exclusive_event(288, 0xF0, whole[1:]) + END, packets):
        score = load(smf.file(body))
        found = list(zip(score.status.tolist(), score.data1.tolist(), score.data2.tolist(), strict=True))
        assert found == messages(whole) and score.n_notes == 0 and score.warnings == ()
    broken = exclusive_event(0, 0xF0, whole[1:20]) + exclusive_event(0, 0xF0, master_volume(5)[1:]) + END
    assert load(smf.file(broken)).status.tolist()[-3:] == [0xF4, 0xF4, 0xF7]
    long = load(smf.file(exclusive_event(0, 0xF0, bytes([127] * 5000 + [0xF7])) + smf.note() + END))
    assert len(long.status) == LONGEST // 2 + 1 + 2


def test_end_of_track_counts_into_the_duration(load):
    assert load(smf.file(smf.end_of_track(960))).duration_s == 5.0
    assert load(smf.file(smf.note() + smf.end_of_track(96))).duration_s == 1.0


def test_simultaneous_events_keep_the_order_of_the_tracks(load):
    off_then_on = [smf.event(0, 0x90, 60, 1) + END, smf.event(0, 0x90, 61, 1) + END, smf.event(0, 0x90, 62, 1) + END]
    assert load(smf.file(*off_then_on, midi_format=1)).data1.tolist() == [60, 61, 62]


def test_rmid_and_foreign_chunks(load):
    plain = smf.header() + smf.chunk(b"Junk", b"abc") + smf.chunk(b"MTrk", smf.note() + END)
    riff = b"RMID" + b"INFO" + struct.pack("<L", 3) + b"abc\0" + b"data" + struct.pack("<L", len(plain)) + plain
    for data in (plain, b"RIFF" + struct.pack("<L", len(riff)) + riff):
        score = load(data)
        assert (score.n_notes, score.warnings) == (1, ())


# What is odd but playable: (bytes, notes that are read, word in the warning)
NOTE = smf.note()
ODD = {
    "bytes after the end of track": (smf.file(NOTE + END + b"\x2a"), 1, "after its end"),
    "bytes after the last chunk": (smf.file(NOTE + END) + b"\x2a", 1, "after the last chunk"),
    "bytes that are no chunk": (smf.file(NOTE + END) + bytes(20), 1, "no chunk"),
    "no end of track": (smf.file(NOTE), 1, "no end of track"),
    "cut": (smf.file(NOTE + NOTE + END)[:-6], 2, "breaks off"),
    "fewer tracks than declared": (smf.file(NOTE + END, declared=7), 1, "7 tracks, 1 are there"),
    "more tracks than declared": (smf.file(NOTE + END, NOTE + END, midi_format=1, declared=1), 2, "2 are there"),
    "two tracks in format 0": (smf.file(NOTE + END, NOTE + END), 2, "format 0"),
    "unknown format": (smf.file(NOTE + END, midi_format=77), 1, "format 77"),
    "track length too long": (smf.header() + smf.chunk(b"MTrk", NOTE + END, 2**32 - 1), 1, "bytes long"),
    "track length too short": (smf.header() + smf.chunk(b"MTrk", NOTE + END, 5), 1, "bytes long"),
    "track length into the next": (
        smf.header(1, 2) + smf.chunk(b"MTrk", NOTE + END, len(NOTE + END) + 1) + smf.chunk(b"MTrk", NOTE + END),
        2,
        "bytes long",
    ),
    "track length over the next": (
        smf.header(1, 3) + smf.chunk(b"MTrk", NOTE + END, 2 * len(NOTE + END) + 8) + 2 * smf.chunk(b"MTrk", NOTE + END),
        3,
        "next track begins",
    ),
    "header length": (smf.file(NOTE + END).replace(b"\0\0\0\x06", b"\0\0\0\x16", 1), 1, "header"),
    "undefined system messages": (smf.file(smf.event(0, 0xF4) + smf.event(0, 0xF2, 1, 2) + NOTE + END), 1, "2 system"),
    "tempo 0": (smf.file(smf.tempo(0, 0) + NOTE + END), 1, "tempo of 0"),
    "tempo of two bytes": (smf.file(smf.event(0, 0xFF, 0x51, 2, 7, 7) + NOTE + END), 1, "2 bytes"),
    "data byte above 127": (smf.file(NOTE + smf.event(0, 0x90, 200, 1) + NOTE + END), 1, "0xC8"),
    "number of five bytes": (smf.file(NOTE + b"\x81\x80\x80\x80\x00\x90\x3c\x40" + END), 1, "4 bytes"),
    "exclusive beyond the end": (smf.file(NOTE + smf.event(0, 0xF0, 100, 1, 2) + END), 1, "100 bytes where"),
}


@pytest.mark.parametrize("name", ODD)
def test_what_is_odd_is_played_and_told(load, name):
    data, n_notes, word = ODD[name]
    score = load(data)
    assert score.n_notes == n_notes
    assert any(word in text for text in score.warnings), score.warnings
    assert score.time_s[-1] == 0.5


def test_running_status_survives_metas_and_exclusives(load):
    body = (
        smf.event(0, 0x90, 60, 9)
        + smf.event(0, 0xFF, 1, 1, 65)
        + smf.event(0, 0xF0, 1, 0xF7)
        + smf.event(5, 61, 9)
        + END
    )
    assert load(smf.file(body)).data1.tolist() == [60, 61]


REFUSED = {
    "empty": (b"", "is empty"),
    "text": (b"not a midi file", "MThd"),
    "four bytes": (b"MThd", "header"),
    "short header": (smf.chunk(b"MThd", b"\0\0\0\1\0") + smf.chunk(b"MTrk", NOTE + END), "at least 6"),
    "no track": (smf.header(), "no track"),
    "division 0": (smf.file(NOTE + END, division=0), "1 to 32767"),
    "SMPTE of 16 frames": (smf.file(NOTE + END, division=0xF060), "24, 25, 29 or 30"),
    "SMPTE of 0 ticks": (smf.file(NOTE + END, division=0xE700), "0 ticks"),
    "data without status": (smf.file(b"\0\x40\x40" + END), "status byte"),
    "RIFF without data": (b"RIFF\x10\0\0\0RMIDabcd\0\0\0\0", "data chunk"),
    "a megabyte of 0xFF": (smf.header() + smf.chunk(b"MTrk", b"\xff" * 2**20), "4 bytes"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_understood_is_refused(load, name):
    data, word = REFUSED[name]
    assert word in refusal(load, data)


def test_what_is_no_readable_file_is_refused(tmp_path):
    for path, word in ((tmp_path, "folder"), (tmp_path / "none.mid", "no such file"), (tmp_path / "a\0b", "read")):
        with pytest.raises(MidiFileError, match=word):
            load_midi_file(path)


def test_long_pieces_are_refused_naming_the_option(load):
    data = smf.file(NOTE + smf.end_of_track(96 * 2 * 60 * 3))
    assert "--max-minutes" in refusal(load, data, max_minutes=3)
    assert load(data, max_minutes=3.01).n_notes == 1
    forever = smf.file(NOTE + b"".join(smf.tempo(0x0FFFFFFF, 0xFFFFFF) for _ in range(5)) + END, division=1)
    assert "--max-minutes" in refusal(load, forever)


def test_too_many_bytes_or_events_are_refused(load, monkeypatch):
    monkeypatch.setattr(midi_file, "MAX_BYTES", 100)
    assert "larger than" in refusal(load, smf.file(NOTE * 20 + END))
    monkeypatch.undo()
    monkeypatch.setattr(midi_file, "MAX_EVENTS", 40)
    assert "events" in refusal(load, smf.file(NOTE * 20 + END))
    assert load(smf.file(NOTE * 19 + END)).n_notes == 19


def test_names_are_cleaned_of_terminal_escapes(load):
    name = b"\x1b[2JRom\xc3\xa1nza\x07\n" + b"x" * 1000
    title = load(smf.file(b"\0\xff\x03" + smf.number(len(name)) + name + END)).title
    assert title.startswith("[2JRom\xe1nza x") and len(title) == midi_track.MAX_TEXT and title.isprintable()


def mutate(rng, data):
    """Flip, cut, insert, duplicate or overwrite some bytes."""
    data = bytearray(data)
    for _ in range(rng.choice([1, 1, 1, 2, 4, 16])):
        at = rng.randrange(len(data) + 1)
        size = rng.randrange(1, 12)
        kind = rng.randrange(6)
        if kind == 0 and at < len(data):
            data[at] ^= 1 << rng.randrange(8)
        elif kind == 1:
            del data[at : at + size]
        elif kind == 2:
            data[at:at] = rng.randbytes(size)
        elif kind == 3:
            data[at:at] = data[at : at + 20 * size]
        elif kind == 4:
            data[at : at + size] = rng.choice([b"\xff", b"\0", b"\x80", b"\x7f"]) * size
        else:
            del data[at:]
    return bytes(data)


def test_mutated_files_are_played_or_refused_and_nothing_else(load, tmp_path):
    rng = random.Random(20_000)
    seeds = [data for data, *_ in ODD.values()]
    for seed in range(6):
        path = tmp_path / f"{seed}.mid"
        random_midi_file(seed, midi_format=seed % 3).save(path)
        seeds.append(path.read_bytes())
    outcomes = {"played": 0, "refused": 0}
    for _ in range(4000):
        data = mutate(rng, rng.choice(seeds))
        try:
            score = load(data)
        except MidiFileError as error:
            assert "\n" not in str(error)
            outcomes["refused"] += 1
            continue
        outcomes["played"] += 1
        assert np.all(np.diff(score.time_s) >= 0.0) and np.all(np.isfinite(score.time_s))
        assert len(score.time_s) <= len(data)
        assert np.all(score.time_s <= score.duration_s + 1e-9) and score.duration_s <= 7200.0
        channel, piece = (score.status >= 0x80) & (score.status < 0xF0), np.isin(score.status, [0xF0, 0xF4, 0xF5, 0xF7])
        assert np.all(channel | piece) and np.all((score.data1 | score.data2) < 0x80)
    assert min(outcomes.values()) > 400, outcomes


def test_every_odd_file_of_the_collections(shared_data):
    refused = {}
    paths = sorted((shared_data / "midi_odd").rglob("*.mid"))
    for path in paths:
        try:
            score = load_midi_file(path)
        except MidiFileError as error:
            refused[path.name] = str(error)
            continue
        if path.name.startswith(("test-vlq", "test-illegal", "test-corrupt", "test-running", "test-non-midi")):
            assert score.n_notes == 8 and score.duration_s == 4.0, path.name  # "You must hear a C-Major scale"
    assert len(paths) > 80
    assert sorted(refused) == [
        "MIDIBadHeaderChunk.mid",
        "MIDIBadHeaderSMTPE.mid",
        "MIDIBadTrackHdr.mid",
        "test-empty-file.mid",
        "test-not-a-midi-file.mid",
    ]
