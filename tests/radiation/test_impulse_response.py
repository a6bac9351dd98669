"""Loading of impulse responses: channels, rates, what resampling keeps, what is refused and how."""

import numpy as np
import pytest
import soundfile

from ukrt.errors import ImpulseResponseError
from ukrt.radiation import impulse_response as ir


def write(path, data, rate=48000, **more):
    soundfile.write(path, data, rate, subtype=more.pop("subtype", "FLOAT"), **more)
    return path


def transfer(samples, rate, frequencies):
    """H at the given frequencies: (n_frequencies, 2, 2)."""
    times = np.arange(len(samples)) / rate
    return np.tensordot(np.exp(-2j * np.pi * np.outer(frequencies, times)), samples, axes=1)


@pytest.mark.parametrize("channels", (1, 2, 4))
def test_channels(tmp_path, channels):
    data = np.random.default_rng(0).standard_normal((50, channels)).astype(np.float32)
    loaded = ir.load_impulse_response(write(tmp_path / "a.wav", data), 48000)
    assert loaded.samples.shape == (50, 2, 2) and loaded.sample_rate == 48000.0
    for end in (0, 1):
        for side in (0, 1):
            channel = {1: 0, 2: side, 4: 2 * end + side}[channels]
            assert np.array_equal(loaded.samples[:, end, side], data[:, channel])


def test_flac_and_integers(tmp_path):
    data = np.array([0.5, -0.25, 0.125])
    loaded = ir.load_impulse_response(write(tmp_path / "a.flac", data, subtype="PCM_24"), 48000.0)
    assert np.array_equal(loaded.samples[:, 1, 0], data)


@pytest.mark.parametrize("rates", ((48000, 44100), (44100, 48000), (48000, 192000), (96000, 48000), (22050, 88200)))
def test_resampling_keeps_the_transfer_function(rates):
    """A decaying sinusoid: its continuous-time transfer function at both rates, also between."""
    from_rate, to_rate = rates
    decay, omega = 60.0, 2 * np.pi * 440.0
    times = np.arange(from_rate // 4) / from_rate
    h = np.exp(-decay * times) * np.sin(omega * times) / from_rate
    made = ir.resample_response(np.broadcast_to(h[:, None, None], (len(h), 2, 2)), from_rate, to_rate)
    frequencies = np.array([0.0, 100.0, 430.0, 440.0, 455.0, 1000.0])
    s = 2j * np.pi * frequencies
    exact = omega / ((s + decay) ** 2 + omega**2)
    found = transfer(made, to_rate, frequencies)
    assert np.abs(found - exact[:, None, None]).max() < 1e-3 * np.abs(exact).max()
    own = np.exp(-1j * np.outer(2 * np.pi * frequencies, times)) @ h  # what the file's own samples say
    assert (np.abs(found - own[:, None, None]) < 1e-3 * np.abs(own)[:, None, None]).all()


@pytest.mark.parametrize("to_rate", (44100, 96000))
def test_resampling_an_impulse_keeps_its_gain_and_adds_no_delay(to_rate):
    made = ir.resample_response(np.ones((1, 2, 2)), 48000, to_rate)
    found = transfer(made, to_rate, np.array([0.0, 50.0, 1000.0]))[:, 0, 0]
    assert np.abs(np.abs(found) - 1.0).max() < 1e-3
    assert np.abs(np.angle(found[1]) / (2 * np.pi * 50.0)) < 1.0 / to_rate  # less than one sample


def test_same_rate_changes_no_bit(tmp_path):
    data = np.random.default_rng(1).standard_normal((100, 4)).astype(np.float32)
    assert np.array_equal(
        ir.load_impulse_response(write(tmp_path / "a.wav", data, 44100), 44100).samples.reshape(-1, 4), data
    )


def test_longest_legal_response_fits_the_convolver_at_every_rate(tmp_path):
    from ukrt.engine.convolver import convolver_size

    path = write(tmp_path / "a.wav", np.zeros(96000))
    assert convolver_size(len(ir.load_impulse_response(path, 192000).samples))


def refusals(folder):
    """Files that are refused, each with a part of the sentence."""
    (folder / "text.wav").write_text("this is not audio")
    (folder / "cut.wav").write_bytes(write(folder / "whole.wav", np.ones(100)).read_bytes()[:20])
    (folder / "nothing.wav").write_bytes(b"")
    not_finite = np.ones(10)
    not_finite[3] = np.nan
    infinite = np.where(np.isnan(not_finite), np.inf, not_finite)
    return [
        ("no-such-name", "no impulse response is called .*classical"),
        (folder / "missing.wav", "no such file"),
        (folder, "folder"),
        (folder / "text.wav", "not an audio file"),
        (folder / "cut.wav", "not an audio file"),
        (folder / "nothing.wav", "not an audio file"),
        (write(folder / "three.wav", np.ones((10, 3))), "3 channels, but legal are 1, 2"),
        (write(folder / "empty.wav", np.ones((0, 2))), "empty"),
        (write(folder / "nan.wav", not_finite), "not finite"),
        (write(folder / "inf.wav", infinite), "not finite"),
        (write(folder / "long.wav", np.ones(96001)), "legal are at most 2 s"),
        (write(folder / "slow.wav", np.ones(10), 1000), "1000 Hz, but legal are 8000 to 384000"),
    ]


def test_refusals_are_one_sentence_that_says_what_is_legal(tmp_path):
    for name, expected in refusals(tmp_path):
        with pytest.raises(ImpulseResponseError, match=expected) as caught:
            ir.load_impulse_response(name, 48000)
        assert str(name) in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.parametrize("rate", (0.0, -48000.0, float("nan"), float("inf"), 1e9))
def test_absurd_engine_rates_are_refused(rate):
    with pytest.raises(ImpulseResponseError, match="legal are 8000"):
        ir.load_impulse_response("classical", rate)
