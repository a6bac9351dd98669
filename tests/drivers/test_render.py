"""Offline rendering: sample 0 is MIDI time 0, the tail ends by energy, nothing is lost, blocks make no difference."""

import json
import math
import os

import numpy as np
import pytest
import smf
import soundfile
from exact_engine import EXACT, ExactEngine

from ukrt.drivers.files import offline
from ukrt.errors import AudioFileError, MidiFileError, ParameterError
from ukrt.render import render, render_file

RATE = 48000
END = smf.end_of_track()


class Stage:
    """Writes a song and renders it on an exact engine, which stays at hand as ``engine``."""

    def __init__(self, folder):
        self.path = folder / "song.mid"
        self.folder = folder

    def play(self, body, function=render, *args, engine=None, **options):
        self.path.write_bytes(smf.file(body))

        def make(guitar, sample_rate, signal):
            self.engine = ExactEngine(guitar, sample_rate, signal, **(engine or {}))
            return self.engine

        options = {"preset": EXACT, "fingering": "causal"} | options  # its messages as they stand in the file
        result = function(self.path, *args, engine_factory=make, **options)
        assert self.engine.closed
        return result


@pytest.fixture
def stage(tmp_path):
    return Stage(tmp_path)


TWO_NOTES = smf.note(60, 127, 96, delta=96) + smf.note(64, 64, 96) + END  # at 0.5 s and 1 s, end at 1.5 s


@pytest.mark.parametrize("rate", [44100, 48000, 96000])
def test_releases_fall_on_the_notes_times(stage, rate):
    samples, report = stage.play(TWO_NOTES, sample_rate=rate)
    clicks = np.flatnonzero(np.diff(samples[:, 0]) > 0.01) + 1
    assert clicks.tolist() == [rate // 2, rate]
    assert [note["release_frame"] for note in report["notes"]] == clicks.tolist()
    assert [note["time_s"] for note in report["notes"]] == [0.5, 1.0]


def test_samples_do_not_depend_on_the_block_size(stage):
    expected, _ = stage.play(TWO_NOTES, block_size=512)
    for block_size in (7, 64, 65, 1000, 8192):
        samples, _ = stage.play(TWO_NOTES, block_size=block_size)
        assert max(stage.engine.blocks) == block_size
        assert np.array_equal(samples, expected)


@pytest.mark.parametrize("tail_db", [-20.0, -60.0, -100.0])
def test_the_tail_ends_when_its_energy_and_the_impulse_response_have_died_away(stage, tail_db):
    decay_s, response = 0.5, 24000
    samples, _ = stage.play(
        smf.note(60, 127, 96) + END, tail_db=tail_db, engine={"decay_s": decay_s, "response_frames": response}
    )
    quiet_s = -tail_db / 20.0 * math.log(10.0) * decay_s  # 20 log10 exp(-t / decay) = tail_db
    expected = max(quiet_s, 0.5) * RATE + response + round(offline.FADE_SECONDS * RATE)
    assert expected - offline.CHECK_FRAMES <= len(samples) <= expected + 2 * offline.CHECK_FRAMES
    assert np.max(np.abs(samples[-1])) < 1e-4 * 10.0 ** (tail_db / 20.0)  # faded out


def test_the_tail_is_never_longer_than_30_s_nor_ends_before_the_file(stage):
    samples, report = stage.play(smf.note(60, 127, 96) + END, engine={"decay_s": 1e6}, block_size=8192)
    assert len(samples) == round(30.5 * RATE) and report["duration_s"] == 30.5
    samples, report = stage.play(smf.note(60, 127, 96) + smf.end_of_track(96 * 40), engine={"decay_s": 0.01})
    assert len(samples) >= 20.5 * RATE and report["midi_duration_s"] == 20.5


def test_a_file_without_notes_is_silence_of_its_duration(stage):
    samples, report = stage.play(smf.event(96, 0xB0, 64, 127) + smf.end_of_track(192))
    assert samples.shape == (round(1.5 * RATE), 2) and not np.any(samples)
    assert (report["notes_total"], report["peak_dbfs"], report["notes"]) == (0, None, [])
    samples, report = stage.play(END)
    assert samples.shape == (0, 2) and report["duration_s"] == 0.0
    json.dumps(report)


def test_a_flood_of_messages_is_sent_in_portions_none_of_them_lost(stage):
    body = smf.note(60, 127, 96) + smf.event(0, 0xB0, 1, 2) * 40_000 + smf.note(62, 127, 96) + END
    _, report = stage.play(body, engine={"decay_s": 0.01})
    received = stage.engine.received
    assert len(received) == 40_004 and stage.engine.late == 0
    assert received[-1][0] == RATE and max(frame for frame, *_ in received[:-1]) <= RATE // 2 + 5
    assert report["notes_total"] == len(report["notes"]) == 2


def test_the_log_of_a_long_piece_is_complete(stage, monkeypatch):
    monkeypatch.setattr(ExactEngine, "LOG", 300)
    monkeypatch.setattr(offline, "SEND_LIMIT", 256)
    keys = [40 + k % 40 for k in range(1000)]
    body = b"".join(smf.note(key, 100, 2) for key in keys) + END
    _, report = stage.play(body, engine={"decay_s": 0.0})
    assert [note["midi"] for note in report["notes"]] == keys
    assert all(note["end_s"] == pytest.approx(note["time_s"] + 2 / 192, abs=1e-4) for note in report["notes"])


def test_gain_is_the_presets_and_the_options_for_pressure_and_the_options_for_forces(stage):
    plain, _ = stage.play(TWO_NOTES, signal="bridge-force")
    loud, report = stage.play(TWO_NOTES, signal="strings", gain_db=20.0)
    assert plain.shape[1] == 1 and loud.shape[1] == 6
    np.testing.assert_allclose(loud[:, 0], 10.0 * plain[:, 0], rtol=1e-12)
    assert report["gain_db"] == 20.0 and report["clipped_samples"] == np.count_nonzero(np.abs(loud) > 1.0) > 0
    pressure, report = stage.play(TWO_NOTES, gain_db=-26.0)
    np.testing.assert_allclose(pressure[:70_000, 0], 0.1 * plain[:70_000, 0], rtol=1e-12)
    assert report["gain_db"] == -20.0
    assert report["peak_dbfs"] == pytest.approx(20 * math.log10(np.max(np.abs(pressure))))


@pytest.mark.parametrize("gain_db", [0.0, -3.0])
def test_normalized_sound_peaks_at_minus_one_dbfs(stage, gain_db):
    plain, _ = stage.play(TWO_NOTES, preset=EXACT)
    samples, report = stage.play(TWO_NOTES, normalize=True, gain_db=gain_db)
    assert 20 * math.log10(np.max(np.abs(samples))) == pytest.approx(-1.0 + gain_db)
    np.testing.assert_allclose(samples / np.max(samples), plain / np.max(plain), rtol=1e-12)
    assert report["gain_db"] == pytest.approx(6.0 + 20 * math.log10(np.max(samples) / np.max(plain)))
    assert not np.any(stage.play(smf.end_of_track(96), normalize=True)[0])


def test_a_file_holds_what_the_array_holds(stage):
    samples, expected = stage.play(TWO_NOTES)
    target = stage.folder / "song.wav"
    for options in ({}, {"normalize": True}):
        samples, expected = stage.play(TWO_NOTES, **options)
        report = stage.play(TWO_NOTES, render_file, target, bits="32f", **options)
        read, rate = soundfile.read(target)
        assert rate == RATE and np.array_equal(read, samples.astype(np.float32))
        assert report["bits"] == "32f" and report["notes"] == expected["notes"]
    assert sorted(os.listdir(stage.folder)) == ["song.mid", "song.wav"]
    json.dumps(report, allow_nan=False)


@pytest.mark.parametrize("error", [KeyboardInterrupt, RuntimeError])
@pytest.mark.parametrize("normalize", [False, True])
def test_an_interrupted_rendering_leaves_no_file(stage, error, normalize):
    def progress(done_s, total_s):
        if done_s > 0.3:
            raise error

    with pytest.raises(error):
        stage.play(TWO_NOTES, render_file, stage.folder / "a.wav", progress=progress, normalize=normalize)
    assert os.listdir(stage.folder) == ["song.mid"]
    assert stage.engine.closed


def test_progress_goes_from_the_start_to_beyond_the_file(stage):
    seen = []
    stage.play(TWO_NOTES, progress=lambda done_s, total_s: seen.append((done_s, total_s)))
    done, total = zip(*seen, strict=True)
    assert len(seen) > 5 and list(done) == sorted(done) and done[-1] >= 1.5
    assert all(d <= t for d, t in seen) and total[0] == 1.5


@pytest.mark.parametrize(
    "options",
    [
        {"block_size": 0},
        {"block_size": 8193},
        {"block_size": 64.5},
        {"signal": "noise"},
        {"tail_db": 0.0},
        {"tail_db": math.nan},
        {"gain_db": math.inf},
    ],
)
def test_options_out_of_range_are_refused(stage, options):
    with pytest.raises(ParameterError, match=next(iter(options))):
        stage.play(END, **options)


def test_refused_files_are_refused_before_anything_else_is_looked_at(stage):
    stage.path.write_bytes(smf.file(smf.end_of_track(96 * 150)))
    with pytest.raises(MidiFileError, match="--max-minutes"):
        render(stage.path, "no such preset", max_minutes=1)
    with pytest.raises(AudioFileError, match="legal"):
        render_file(stage.path, stage.folder / "song.mp3", "no such preset")
    with pytest.raises(AudioFileError, match="whole number"):
        render_file(stage.path, stage.folder / "song.wav", "no such preset", sample_rate=math.nan)
    assert os.listdir(stage.folder) == ["song.mid"]
