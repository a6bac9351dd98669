"""A known impulse response comes back from records of a hammer; coherence is what its closed form says."""

import numpy as np
import pytest
from identify.hammer_records import COUNT, RATE, error_db, known_response, record

from ukrt.errors import MeasurementError
from ukrt.identify.hammer import find_hits, hammer_response

SECONDS = COUNT / RATE


def respond(force, pressure, **options):
    return hammer_response([(force, pressure[:, None], "record")], RATE, SECONDS, **options)


@pytest.mark.parametrize("width", [2e-4, 4e-4, 1e-3])
def test_a_known_response_comes_back_in_the_band(width):
    taps = known_response()
    force, pressure = record(taps, width=width, force_noise=1e-3, noise=2e-5)
    found = respond(force, pressure)
    assert found.hits == 8 and found.left_out == 0
    assert 1.2 / width < found.band_hz < 3.0 / width  # a half-sine's spectrum ends at 1.5 / width
    assert error_db(found.taps[:, 0], taps, 50.0, min(1.2 / width, 6000.0)) < -50.0


def test_without_noise_the_error_is_the_regularisation_alone():
    taps = known_response(last_hz=1500.0)
    found = respond(*record(taps, width=2e-4))
    assert error_db(found.taps[:, 0], taps, 50.0, 2000.0) < -70.0


def test_what_is_beyond_the_band_is_let_go():
    taps = known_response()
    found = respond(*record(taps, width=2e-3, noise=1e-4))
    spectrum = np.abs(np.fft.rfft(found.taps[:, 0], 2 * COUNT))
    beyond = np.fft.rfftfreq(2 * COUNT, 1 / RATE) > 2.0 * found.band_hz
    assert spectrum[beyond].max() < 3e-3 * spectrum.max()
    assert np.abs(found.transfer[beyond]).max() > 0.1 * spectrum.max()  # the noise that is kept out


def test_a_response_without_time_of_flight_loses_a_little():
    """Cut at the band's edge it rings before time zero; what does is folded behind it."""
    taps = known_response(flight=0.0)
    assert error_db(respond(*record(taps, width=2e-4)).taps[:, 0], taps, 50.0, 3000.0) < -45.0


def test_averaging_lowers_the_error_as_noise_demands():
    taps = known_response(last_hz=1500.0)
    few, many = (respond(*record(taps, hits, noise=1e-3, same=True, seed=3)) for hits in (3, 48))
    gain = error_db(few.taps[:, 0], taps, 50, 2000) - error_db(many.taps[:, 0], taps, 50, 2000)
    assert gain == pytest.approx(10 * np.log10(16), abs=2.0)


@pytest.mark.parametrize("noise", [3e-5, 2e-4])
def test_coherence_is_its_closed_form(noise):
    """S / (S + N) with S = |H F|^2 and N = n sigma^2 for white noise over n samples; n hits raise it by (1 - it)^2 / n
    (Bendat and Piersol, Random Data, 9.2)."""
    taps, hits = known_response(), 40
    force, pressure = record(taps, hits, noise=noise, same=True)
    found = respond(force, pressure)
    size = 2 * COUNT
    one, _ = record(taps, 1, same=True)
    signal = np.abs(np.fft.rfft(one[4000 : 4000 + COUNT], size) * np.fft.rfft(taps, size)) ** 2
    exact = signal / (signal + COUNT * noise**2)
    exact += (1.0 - exact) ** 2 / hits
    hz = found.frequencies
    for low in (100.0, 400.0, 1000.0, 2000.0):
        band = (hz > low) & (hz < 2 * low)
        assert np.mean(found.coherence[band, 0]) == pytest.approx(np.mean(exact[band]), abs=0.02)
    assert np.corrcoef(found.coherence[hz < 4000, 0], exact[hz < 4000])[0, 1] > 0.95


def test_one_hit_has_no_coherence():
    assert np.all(np.isnan(respond(*record(known_response(), hits=1)).coherence))


def test_records_of_single_hits_are_as_good_as_one_of_all():
    taps = known_response()
    whole = record(taps, 4, same=True)
    parts = []
    for k in range(4):
        at = slice(int((0.05 + 0.35 * k) * RATE), int((0.40 + 0.35 * k) * RATE))
        parts.append((whole[0][at], whole[1][at][:, None], f"record {k}"))
    found = hammer_response(parts, RATE, SECONDS)
    assert found.hits == 4
    assert found.taps[:, 0] == pytest.approx(respond(*whole).taps[:, 0], abs=1e-3 * np.abs(taps).max())


def test_an_exponential_window_is_taken_out_again():
    taps = known_response()
    force, pressure = record(taps, 20, noise=1e-4, force_noise=1e-4)
    plain, weighted = respond(force, pressure), respond(force, pressure, decay=0.03)
    for found in (plain, weighted):
        assert error_db(found.taps[: COUNT // 4, 0], taps[: COUNT // 4], 50, 3000) < -20.0
    below = plain.frequencies < 3000.0
    assert np.mean(1 - weighted.coherence[below]) < 0.5 * np.mean(1 - plain.coherence[below])


def test_rebounds_and_hurried_hits_are_left_out():
    taps = known_response()
    force, _ = record(taps, 6, same=True, force_noise=1e-3)
    double = force.copy()
    at = int((0.1 + 0.35 * 2) * RATE)
    double[at + 2400 : at + 2420] += 3.0  # 50 ms later
    for signal, counts in ((force, (6, 0)), (double, (5, 2))):  # the hit and its rebound
        begins, left_out = find_hits(signal, RATE, COUNT)
        assert (len(begins), left_out) == counts
    hurried, _ = record(taps, 6, apart=0.2, same=True)
    with pytest.raises(MeasurementError, match="hits that cannot be used"):
        respond(hurried[: int(1.25 * RATE)], hurried[: int(1.25 * RATE)])


def test_two_microphones_keep_their_own_response_and_scale():
    left, right = known_response(0), known_response(1)
    force, first = record(left)
    _, second = record(right)
    found = hammer_response([(force, np.stack([first, second], 1), "r")], RATE, SECONDS)
    for n, taps in enumerate((left, right)):
        assert error_db(found.taps[:, n], taps, 50, 3000) < -50.0
    doubled = hammer_response([(2 * force, np.stack([first, second], 1), "r")], RATE, SECONDS)
    assert doubled.taps == pytest.approx(found.taps / 2, rel=1e-9, abs=1e-12)
