"""The shipped response: made by its generator, the preset's modes in it, its level and decay."""

import numpy as np
import pytest
from tool_scripts import load_tool

from ukrt.model.presets import load_preset
from ukrt.radiation.impulse_response import impulse_response_names, load_impulse_response

RATE = 48000


@pytest.fixture(scope="module")
def response():
    return load_impulse_response("classical", RATE).samples


@pytest.fixture(scope="module")
def generator():
    return load_tool("make_impulse_response")


def spectrum(samples, points=1 << 18):
    """Frequencies [Hz] and H (n, 4) [Pa/N]."""
    return np.fft.rfftfreq(points, 1 / RATE), np.fft.rfft(samples.reshape(-1, 4), points, axis=0)


def fitted_pole(samples, frequency, zeta):
    """Frequency and damping of the pole near ``frequency``: (s - p) H is a low polynomial there, by least squares."""
    frequencies, h = spectrum(samples)
    near = np.abs(frequencies - frequency) < max(2.5 * zeta * frequency, 4.0)
    s = 2j * np.pi * (frequencies[near] - frequency)
    scale = np.abs(s).max()
    h = h[near]
    powers = np.stack([(s / scale) ** k for k in range(3)], axis=1)
    n, channels = h.shape
    system = np.zeros((n * channels, 1 + 3 * channels), dtype=complex)
    for channel in range(channels):
        rows = slice(n * channel, n * (channel + 1))
        system[rows, 0] = h[:, channel]
        system[rows, 1 + 3 * channel : 4 + 3 * channel] = powers
    pole = np.linalg.lstsq(system, (s[:, None] * h).T.ravel(), rcond=None)[0][0] + 2j * np.pi * frequency
    return abs(pole) / (2 * np.pi), -pole.real / abs(pole)


def test_generator_reproduces_the_file(response, generator):
    made = generator.make_response(load_preset("classical").body)
    assert made.shape == response.shape == (24000, 2, 2)
    assert np.abs(made - response).max() <= np.finfo(np.float32).eps * np.abs(response).max()


def test_shows_the_body_modes(response):
    body = load_preset("classical").body
    for frequency, zeta in zip(body.frequencies_hz, body.damping_ratios, strict=True):
        assert frequency < 1000.0
        found = fitted_pole(response, frequency * 1.002, zeta)  # not started from the answer
        assert found == (pytest.approx(frequency, rel=3e-3), pytest.approx(zeta, rel=0.1))


def test_ends_of_the_bridge_differ_by_the_shapes(response):
    """Where one mode dominates, treble over bass is the ratio of its shapes (air and board modes)."""
    body = load_preset("classical").body
    frequencies, h = spectrum(response)
    for n, tolerance in ((0, 0.1), (1, 0.1)):
        at = np.argmin(np.abs(frequencies - body.frequencies_hz[n]))
        ratio = h[at, 2:] / h[at, :2]
        assert np.abs(ratio - body.shapes_treble[n] / body.shapes_bass[n]).max() < tolerance


def test_level_and_slope(response):
    frequencies, h = spectrum(response)
    size = np.abs(h)
    peaks = size.max(axis=0)
    assert (peaks > 1.0).all() and (peaks < 3.0).all()
    assert (frequencies[size.argmax(axis=0)] < 250.0).all()  # a breathing mode is the loudest

    def level(low, high):
        return np.sqrt((size[(frequencies >= low) & (frequencies < high)] ** 2).mean())

    assert level(1000, 2000) == pytest.approx(0.2, rel=0.4) and level(2000, 4000) == pytest.approx(0.2, rel=0.4)
    per_octave = 20 * np.log10(level(5000, 10000) / level(10000, 20000))
    assert 5.0 < per_octave < 11.0
    assert level(10, 40) < 0.01 * peaks.min()


def test_no_lone_peak_above_the_modes(response):
    """Nothing rings out of the wood: above 1.1 kHz no peak stands more than 13 dB over its third of an octave."""
    frequencies, h = spectrum(response)
    power = np.abs(h) ** 2
    for centre in 1250.0 * 2.0 ** (np.arange(11) / 3):
        band = power[(frequencies > centre * 2 ** (-1 / 6)) & (frequencies < centre * 2 ** (1 / 6))]
        assert (10 * np.log10(band.max(axis=0) / band.mean(axis=0)) < 13.0).all()


def test_high_frequencies_decay_faster(response):
    """Energy left after 20 ms, by octave: wood, not a reverb."""
    gate = np.clip((np.arange(len(response)) - 840) / 240, 0.0, 1.0)  # from 17.5 to 22.5 ms, softly
    late = response * np.sin(0.5 * np.pi * gate)[:, None, None] ** 2
    left = []
    frequencies, whole = spectrum(response)
    _, rest = spectrum(late)
    for low in (150.0, 1200.0, 2400.0, 4800.0, 9600.0):
        band = (frequencies > low) & (frequencies < 2 * low)
        left.append(10 * np.log10((np.abs(rest[band]) ** 2).sum() / (np.abs(whole[band]) ** 2).sum()))
    assert left == sorted(left, reverse=True)
    assert left[0] > -8.0 and left[-1] < -30.0


def test_starts_at_once_and_ends_softly(response):
    flat = np.abs(response.reshape(-1, 4))
    assert (flat[0] < 1e-3 * flat.max(axis=0)).all()  # no jump at time zero
    energy = np.cumsum(flat**2, axis=0) / (flat**2).sum(axis=0)
    assert (energy[48] > 0.05).all()  # and no time of flight: sound within the first millisecond
    assert (flat[-50:] < 1e-5 * flat.max(axis=0)).all()


def test_is_shipped():
    assert "classical" in impulse_response_names()
