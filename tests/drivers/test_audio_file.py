"""Audio files: what is written is what was computed, whole or not at all, and every refusal is one sentence."""

import os
import subprocess
import sys

import numpy as np
import pytest
import soundfile

from ukrt.drivers.files import audio as audio_file
from ukrt.drivers.files.audio import AudioWriter
from ukrt.errors import AudioFileError

RATE = 48000


def noise(n=5000, channels=2, seed=1):
    return np.random.default_rng(seed).uniform(-0.9, 0.9, (n, channels))


def write(path, samples, bits="24", block=512, **options):
    with AudioWriter(path, RATE, samples.shape[1], bits, **options) as writer:
        for at in range(0, len(samples), block):
            writer.write(samples[at : at + block])
    return writer


@pytest.mark.parametrize(
    ("name", "bits", "error"),
    [
        ("a.wav", "16", 1.5 / 2**15),
        ("a.wav", "24", 0.5 / 2**23),
        ("a.wav", "32f", 2.0**-25),
        ("a.flac", 16, 1.5 / 2**15),
        ("a.FLAC", 24, 0.5 / 2**23),
    ],
)
def test_what_is_read_back_is_what_was_written(tmp_path, name, bits, error):
    samples = noise()
    write(tmp_path / name, samples, bits)
    read, rate = soundfile.read(tmp_path / name, dtype="float64")
    assert rate == RATE and read.shape == samples.shape
    assert 0.5 * error < np.max(np.abs(read - samples)) <= error * (1 + 1e-6)
    assert soundfile.info(tmp_path / name).subtype == {"16": "PCM_16", "24": "PCM_24", "32f": "FLOAT"}[str(bits)]
    assert os.listdir(tmp_path) == [name]


@pytest.mark.parametrize("bits", ["16", "24", "32f"])
def test_bytes_do_not_depend_on_blocks_or_the_time_of_day(tmp_path, bits, monkeypatch):
    samples = noise()
    for block in (1, 333, 5000):
        write(tmp_path / f"{block}.wav", samples, bits, block)
    data = (tmp_path / "1.wav").read_bytes()
    assert all((tmp_path / f"{block}.wav").read_bytes() == data for block in (333, 5000))
    if bits == "32f":
        at = data.index(b"PEAK")
        assert data[at + 12 : at + 16] == bytes(4)
        assert data[at + 16 : at + 20] != bytes(4)  # the peak itself stays


def test_dither_makes_the_mean_follow_a_signal_far_below_one_step(tmp_path):
    samples = np.full((200_000, 1), 0.3 / 2**15)
    write(tmp_path / "a.wav", samples, "16")
    steps = soundfile.read(tmp_path / "a.wav", dtype="int16")[0].astype(float)
    # TPDF of two LSB: mean = signal, variance of the total error 1/4 LSB^2 whatever the signal
    assert np.mean(steps) == pytest.approx(0.3, abs=0.005)
    assert np.var(steps) == pytest.approx(0.25, abs=0.005)


@pytest.mark.parametrize("bits", ["16", "24", "32f"])
def test_silence_stays_silent(tmp_path, bits):
    write(tmp_path / "a.wav", np.zeros((1000, 2)), bits)
    assert not np.any(soundfile.read(tmp_path / "a.wav")[0])


def test_clipping_is_counted_for_integers_and_absent_in_float(tmp_path):
    samples = np.array([[0.5], [1.5], [-1.5], [-1.0], [0.999]])
    assert write(tmp_path / "a.wav", samples, "24").clipped_samples == 2
    np.testing.assert_allclose(soundfile.read(tmp_path / "a.wav")[0], [0.5, 1 - 2.0**-23, -1, -1, 0.999], atol=1e-7)
    assert write(tmp_path / "b.wav", samples, "32f").clipped_samples == 0
    np.testing.assert_allclose(soundfile.read(tmp_path / "b.wav")[0], samples[:, 0], rtol=1e-7)


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt])
def test_an_interrupted_file_leaves_nothing_and_the_old_file_as_it_was(tmp_path, error):
    target = tmp_path / "a.wav"
    target.write_bytes(b"old")
    with pytest.raises(error), AudioWriter(target, RATE, 2) as writer:
        writer.write(noise())
        assert len(os.listdir(tmp_path)) == 2
        raise error
    assert os.listdir(tmp_path) == ["a.wav"] and target.read_bytes() == b"old"


def test_an_existing_file_is_replaced_only_where_allowed(tmp_path):
    target = tmp_path / "a.wav"
    target.write_bytes(b"old")
    with pytest.raises(AudioFileError, match="exists"):
        AudioWriter(target, RATE, 2, overwrite=False)
    assert target.read_bytes() == b"old"
    (tmp_path / "link.wav").symlink_to(target)
    write(tmp_path / "link.wav", noise())
    assert (tmp_path / "link.wav").is_symlink() and soundfile.info(target).frames == 5000


REFUSED = [
    ({"path": "a.mp3"}, ".wav and .flac"),
    ({"path": "a"}, ".wav and .flac"),
    ({"path": "none/a.wav"}, "folder"),
    ({"path": "folder.wav"}, "regular file"),
    ({"path": "a\0b.wav"}, "file name"),
    ({"path": "x" * 300 + ".wav"}, "cannot be written|file name"),
    ({"bits": "20"}, "16, 24 and 32f"),
    ({"path": "a.flac", "bits": "32f"}, "no 32 bit float"),
    ({"path": "a.flac", "channels": 12}, "at most 8"),
    ({"path": "a.flac", "sample_rate": 768000}, "655350"),
    ({"sample_rate": 44100.5}, "whole number"),
    ({"channels": 0}, "1 to 1024"),
]


@pytest.mark.parametrize(("change", "words"), REFUSED)
def test_what_cannot_be_written_is_refused_before_anything_is(tmp_path, change, words):
    (tmp_path / "folder.wav").mkdir()
    options = {"path": "a.wav", "sample_rate": RATE, "channels": 2} | change
    options["path"] = os.path.join(tmp_path, options["path"])
    with pytest.raises(AudioFileError, match=words) as caught:
        AudioWriter(**options)
    assert "\n" not in str(caught.value)
    assert os.listdir(tmp_path) == ["folder.wav"]


def test_not_a_number_is_refused(tmp_path):
    with pytest.raises(AudioFileError, match="finite"), AudioWriter(tmp_path / "a.wav", RATE, 1) as writer:
        writer.write(np.array([[0.0], [np.nan]]))
    assert os.listdir(tmp_path) == []


def test_a_full_disk_is_told_and_leaves_nothing(tmp_path):
    """A limit on the size of files stands in for a full disk: both make the write fail half-way."""
    pytest.importorskip("resource")
    script = """
import resource, sys, numpy
resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, 200_000))
from ukrt.drivers.files.audio import AudioWriter
from ukrt.errors import AudioFileError
try:
    with AudioWriter(sys.argv[1], 48000, 2) as writer:
        for _ in range(100):
            writer.write(numpy.full((4800, 2), 0.1))
except AudioFileError as error:
    print(error)
"""
    done = subprocess.run(
        [sys.executable, "-c", script, str(tmp_path / "a.wav")], capture_output=True, text=True, check=True
    )
    assert "a.wav: cannot be written (" in done.stdout and done.stderr == ""
    assert os.listdir(tmp_path) == []


def test_files_beyond_four_gigabytes_become_rf64_or_are_refused(tmp_path, monkeypatch):
    samples = noise()
    assert write(tmp_path / "a.wav", samples, max_frames=2**32).format == "RF64"
    np.testing.assert_allclose(soundfile.read(tmp_path / "a.wav")[0], samples, atol=2.0**-23)
    assert soundfile.info(tmp_path / "a.wav").format == "RF64"
    monkeypatch.setattr(audio_file, "WAV_MAX_BYTES", 6 * 4000)
    with pytest.raises(AudioFileError, match="4 GB"):
        write(tmp_path / "b.wav", samples)
    assert os.listdir(tmp_path) == ["a.wav"]
