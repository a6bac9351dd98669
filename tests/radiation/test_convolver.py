"""The streaming convolver: against direct convolution, between block sizes, after silence, resets and NaN."""

import itertools

import numpy as np
import pytest
from convolver_runs import make_convolver, stream

from ukrt.engine import convolver
from ukrt.engine.kernels import convolve, convolve_layout


def direct(x, ir):
    """Both outputs by np.convolve, cut to the input's length: (n, 2)."""
    sides = [sum(np.convolve(x[:, end], ir[:, end, side]) for end in (0, 1)) for side in (0, 1)]
    return np.stack(sides, axis=1)[: len(x)]


def same(size):
    return itertools.repeat(size)


def random_sizes(seed, largest):
    rng = np.random.default_rng(seed)
    return iter(lambda: int(rng.integers(1, largest + 1)), 0)


@pytest.mark.parametrize("n_taps", (1, 63, 64, 65, 128, 1024, 1025, 8192, 8193))
def test_equals_direct_convolution(n_taps):
    rng = np.random.default_rng(n_taps)
    ir, x = rng.standard_normal((n_taps, 2, 2)), rng.standard_normal((n_taps + 3000, 2))
    expected = direct(x, ir)
    assert np.abs(stream(*make_convolver(ir), x, same(64)) - expected).max() < 1e-12 * np.abs(expected).max()


def test_equals_direct_convolution_at_two_seconds():
    rng = np.random.default_rng(2)
    ir = rng.standard_normal((96000, 2, 2))
    x = np.zeros((120_000, 2))
    x[:9000] = rng.standard_normal((9000, 2))  # np.convolve is direct: the shorter the input, the sooner it is done
    sides = [sum(np.convolve(x[:9000, end], ir[:, end, side]) for end in (0, 1)) for side in (0, 1)]
    expected = np.zeros_like(x)
    expected[:104_999] = np.stack(sides, axis=1)
    found = stream(*make_convolver(ir), x, same(64))
    assert np.abs(found - expected).max() < 1e-12 * np.abs(expected).max()
    assert not found[9000 + 96000 + 3 * 4096 :].any()  # input and response are over: silence is exactly 0


@pytest.mark.parametrize("n_taps", (40, 5000, 24000))
def test_block_size_changes_no_bit(n_taps):
    rng = np.random.default_rng(n_taps)
    ir, x = rng.standard_normal((n_taps, 2, 2)), rng.standard_normal((9000, 2))
    v, vi = make_convolver(ir)
    expected = stream(v, vi, x, same(64))
    for sizes in (same(1), same(7), same(65), same(1000), random_sizes(1, 64), random_sizes(2, 300)):
        convolve.convolver_reset(v, vi)
        assert np.array_equal(stream(v, vi, x, sizes), expected)


@pytest.mark.parametrize("frame", (1, 64, 4096 + 77, 10**9 + 12345))
def test_any_first_frame_after_a_reset(frame):
    rng = np.random.default_rng(frame)
    ir, x = rng.standard_normal((10_000, 2, 2)), rng.standard_normal((12_000, 2))
    v, vi = make_convolver(ir)
    stream(v, vi, x[:5000], same(64))  # something to forget
    convolve.convolver_reset(v, vi)
    expected = direct(x, ir)
    assert np.abs(stream(v, vi, x, same(64), frame) - expected).max() < 1e-12 * np.abs(expected).max()


def test_no_delay_and_no_crosstalk():
    """An impulse at one end comes out at once, and as that end's responses."""
    ir = np.random.default_rng(0).standard_normal((9000, 2, 2))
    for end in (0, 1):
        x = np.zeros((9000, 2))
        x[0, end] = 1.0
        found = stream(*make_convolver(ir), x, same(64))
        assert np.abs(found - ir[:, end]).max() < 1e-13 * np.abs(ir).max() * 5
        assert np.array_equal(found[:64], ir[:64, end])


def test_what_is_not_finite_does_not_stay():
    rng = np.random.default_rng(3)
    ir, x = rng.standard_normal((9000, 2, 2)), rng.standard_normal((30_000, 2))
    v, vi = make_convolver(ir)
    bad = x.copy()
    bad[100, 0], bad[101, 1] = np.nan, np.inf
    later = 9000 + 4 * 4096
    found = stream(v, vi, bad, same(64))
    assert not np.isfinite(found[100]).any()
    expected = direct(x, ir)[later:]
    assert np.abs(found[later:] - expected).max() < 1e-12 * np.abs(expected).max()


@pytest.mark.parametrize("n_taps", (24_000, 96_000, 400_000))
def test_work_is_spread_evenly(n_taps):
    """No slot of a level costs more than 1.3 times the mean, and every unit of every pass falls to one slot."""
    for level in convolve_layout.make_plan(n_taps).levels:
        passes = {(p[0], p[1], p[4]): (p[2], p[3]) for p in convolve_layout._passes(level)}
        slots = convolve_layout.make_program(level)
        assert len(slots) == level.size // 64
        seen = dict.fromkeys(passes, 0)
        costs = []
        for steps in slots:
            costs.append(0.0)
            for op, channel, first, stop, stride, _ in steps:
                assert first == seen[op, channel, stride] < stop
                seen[op, channel, stride] = stop
                costs[-1] += (stop - first) * passes[op, channel, stride][1]
        assert seen == {key: units for key, (units, _) in passes.items()}
        assert max(costs) < 1.3 * np.mean(costs)


def test_illegal_lengths_and_places_are_refused():
    for n_taps in (0, convolve_layout.MAX_TAPS + 1):
        with pytest.raises(ValueError, match="taps"):
            convolver.convolver_size(n_taps)
    len_v, len_vi = convolver.convolver_size(100)
    with pytest.raises(ValueError, match="64-byte"):
        convolver.convolver_prepare(np.zeros((100, 2, 2)), np.zeros(len_v - 1), np.zeros(len_vi, dtype=np.int64))
