"""The transform against NumPy's: values, order, round trip, linear convolution, shares of passes."""

import numpy as np
import pytest
from convolver_runs import aligned

from ukrt.engine.kernels import fft, fft_tables

SIZES = (64, 128, 256, 512, 1024, 4096)


def bench(n):
    """Array with room for a transform of n: tiles at 0 and 2 n, table at 4 n, x at 16 n, work at 20 n."""
    table = fft_tables.fft_table(n)
    d = aligned(24 * n)
    d[4 * n : 4 * n + len(table)] = table
    return d


def forward(d, n, x, tiles):
    d[16 * n : 17 * n] = x
    fft.fft_forward(d, 16 * n, 20 * n, tiles, n, fft_tables.fft_radices(n)[0], 4 * n)
    parts = d[tiles : tiles + 2 * n].reshape(-1, 2, 8)
    return (parts[:, 0] + 1j * parts[:, 1]).ravel()


def inverse(d, n, spectrum):
    parts = spectrum.reshape(-1, 8)
    d[: 2 * n].reshape(-1, 2, 8)[:, 0], d[: 2 * n].reshape(-1, 2, 8)[:, 1] = parts.real, parts.imag
    d[16 * n : 20 * n] = 0.0
    fft.fft_inverse_add(d, 0, 20 * n, 16 * n, n, fft_tables.fft_radices(n)[0], 4 * n)
    return np.array([d[16 * n + fft_tables.place_of(k)] for k in range(2 * n)]) / n


@pytest.mark.parametrize("n", SIZES)
def test_values_equal_numpy(n):
    rng = np.random.default_rng(n)
    x = rng.standard_normal(n)
    ours = forward(bench(n), n, x, 0)
    turned = np.fft.ifft(x * np.exp(0.5j * np.pi * np.arange(n) / n)) * n
    bins = (fft_tables.fft_angles(n) - 0.5 * np.pi / n) * n / (2 * np.pi)
    assert np.abs(bins - np.rint(bins)).max() < 1e-6
    assert sorted(np.rint(bins).astype(int) % n) == list(range(n))  # every root once
    assert np.abs(ours - turned[np.rint(bins).astype(int) % n]).max() < 2e-15 * np.abs(turned).max()


@pytest.mark.parametrize("n", (64, 512))
def test_single_sample_is_a_power_of_the_root(n):
    for k in (0, 1, n // 3, n - 1):
        x = np.zeros(n)
        x[k] = 1.0
        assert np.abs(forward(bench(n), n, x, 0) - np.exp(1j * k * fft_tables.fft_angles(n))).max() < 1e-12


@pytest.mark.parametrize("n", SIZES)
def test_product_of_spectra_is_linear_convolution(n):
    rng = np.random.default_rng(n + 1)
    x, h = rng.standard_normal((2, n))
    d = bench(n)
    product = forward(d, n, x, 0) * forward(d, n, h, 2 * n)
    expected = np.convolve(x, h)
    assert np.abs(inverse(d, n, product)[:-1] - expected).max() < 1e-14 * np.abs(expected).max()


def test_shares_of_a_pass_are_the_pass():
    n, rng = 512, np.random.default_rng(5)
    whole, parts = bench(n), bench(n)
    whole[16 * n : 17 * n] = parts[16 * n : 17 * n] = rng.standard_normal(n)
    fft.fft_first_pass(whole, 16 * n, 20 * n, n, 8, 4 * n, 0, 8)
    for start, stop in ((3, 8), (0, 1), (1, 3)):
        fft.fft_first_pass(parts, 16 * n, 20 * n, n, 8, 4 * n, start, stop)
    assert np.array_equal(whole, parts)


@pytest.mark.parametrize("n", (0, 32, 65, 100))
def test_other_sizes_are_refused(n):
    with pytest.raises(ValueError, match="power of two"):
        fft_tables.fft_radices(n)
