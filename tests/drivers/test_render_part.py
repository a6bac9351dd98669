"""A part of a rendering is bit for bit what stands there in the whole, on an engine known exactly."""

import itertools
import math

import numpy as np
import pytest
import smf
import soundfile
from exact_engine import EXACT, ExactEngine

from ukrt.errors import MidiFileError, ParameterError
from ukrt.render import render, render_file

RATE = 48000
SONG = smf.file(
    smf.note(60, 127, 96, delta=96) + smf.note(64, 64, 192) + smf.note(67, 90, 96) + smf.event(0, 0xFF, 6, 1, 65)
    + smf.note(72, 9, 96) + smf.end_of_track()
)  # fmt: skip
CUTS = [("0.5", "1.5"), ("bar:2", None), (None, "bar:2.2"), ("marker:A", 3.3), (0.51234, 0.51236), (2.9, 100.0),
        (3.2, None)]  # fmt: skip


@pytest.fixture
def play(tmp_path):
    (tmp_path / "song.mid").write_bytes(SONG)

    def run(function=render, *args, **options):
        options = {"preset": EXACT, "fingering": "causal", "engine_factory": ExactEngine} | options
        return function(tmp_path / "song.mid", *args, **options)

    return run


@pytest.mark.parametrize(("start", "end"), CUTS)
def test_a_part_is_bit_for_bit_what_stands_in_the_whole(play, start, end):
    places = {None: None, "0.5": 0.5, "1.5": 1.5, "bar:2": 2.0, "bar:2.2": 2.5, "marker:A": 2.5}
    for rate, block_size in ((44100, 64), (48000, 512), (96000, 8192)):
        whole, _ = play(sample_rate=rate)
        part, report = play(sample_rate=rate, block_size=block_size, start=start, end=end)
        first = round((places.get(start, start) or 0.0) * rate)
        last = None if end is None else round(places.get(end, end) * rate)
        assert len(part) > 0 and np.array_equal(part, whole[first:last])
        assert report["start_s"] == first / rate and report["frames"] == len(part)


@pytest.mark.parametrize(("suffix", "bits"), [(".wav", "16"), (".wav", "24"), (".wav", "32f"), (".flac", "16")])
def test_files_of_parts_hold_the_wholes_samples_dither_and_normalising_included(play, tmp_path, suffix, bits):
    for options in ({}, {"normalize": True}):
        whole, part = tmp_path / f"whole{suffix}", tmp_path / f"part{suffix}"
        play(render_file, whole, bits=bits, **options)
        report = play(render_file, part, bits=bits, start=0.7, end=1.3, block_size=100, **options)
        kind = "float32" if bits == "32f" else "int32"
        expected = soundfile.read(whole, dtype=kind)[0][round(0.7 * RATE) : round(1.3 * RATE)]
        assert np.any(expected) and np.array_equal(soundfile.read(part, dtype=kind)[0], expected)
        assert report["frames"] == len(expected)


def test_consecutive_parts_make_the_whole(play):
    whole, expected = play()
    cuts = [None, 0.5, 0.987, "bar:2", 2.5, None]
    pieces = [play(start=a, end=b) for a, b in itertools.pairwise(cuts)]
    assert np.array_equal(np.concatenate([sound for sound, _ in pieces]), whole)
    notes = [note | {"release_frame": note["release_frame"] + round(report["start_s"] * RATE)}
             for _, report in pieces for note in report["notes"]]  # fmt: skip
    assert [(n["midi"], n["release_frame"], n["time_s"]) for n in notes] == [
        (n["midi"], n["release_frame"], n["time_s"]) for n in expected["notes"]
    ]
    assert sum(report["notes_total"] for _, report in pieces) == expected["notes_total"] == 4


def test_no_more_is_computed_than_the_part_needs(play):
    engines = []

    def make(*args, **options):
        engines.append(ExactEngine(*args, **options))
        return engines[-1]

    seen = []
    play(end=1.0, block_size=512, engine_factory=make, progress=lambda done_s, total_s: seen.append((done_s, total_s)))
    assert seen[0][1] == 1.0 and all(done_s <= total_s for done_s, total_s in seen)
    assert RATE + ExactEngine.LEAD <= engines[0].frame <= RATE + ExactEngine.LEAD + 512


def test_a_part_that_begins_after_the_end_is_refused_and_leaves_nothing(play, tmp_path):
    for start in (20.0, 1000.0):
        with pytest.raises(ParameterError, match=r"start is .*the sound ends (at|before)"):
            play(render_file, tmp_path / "part.wav", start=start)
    with pytest.raises(MidiFileError, match="bars"):
        play(render_file, tmp_path / "part.wav", start="bar:99")
    with pytest.raises(ParameterError, match="start"):
        play(render_file, tmp_path / "part.wav", start=math.nan)
    assert [path.name for path in tmp_path.iterdir()] == ["song.mid"]
