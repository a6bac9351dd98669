"""The convolver's tail left out and taken up again: what remains, how it fades, and that it comes back whole."""

import numpy as np
import pytest
from engine.shedding import convolver

from ukrt.engine.kernels.convolve import convolve_chunk, convolver_reset, convolver_shed

BLOCK, TAIL_FROM, PERIOD = 64, 8192, 4096
FRAMES, DOWN, UP = 96 * 1024, 20032, 60032


def _response(n_taps=20000):
    rng = np.random.default_rng(1)
    return rng.standard_normal((n_taps, 2, 2)) * np.exp(-np.arange(n_taps) / 6000.0)[:, None, None]


def _convolve(response, force, changes=None):
    """``changes``: {frame: levels left out}, at multiples of 64."""
    v, vi = convolver(response)
    out, piece = np.zeros((len(force), 2)), np.zeros(2 * BLOCK)
    for start in range(0, len(force), BLOCK):
        if start in (changes or {}):
            convolver_shed(vi, changes[start])
        convolve_chunk(v, vi, start, BLOCK, force[start : start + BLOCK].T.copy().ravel(), 0, piece, 0)
        out[start : start + BLOCK] = piece.reshape(2, BLOCK).T
    return out


@pytest.fixture(scope="module")
def sounds():
    """Noise through the whole response, through its first 8192 taps, and with the tail left out from DOWN to UP."""
    force = np.random.default_rng(2).standard_normal((FRAMES, 2))
    response = _response()
    head = np.where(np.arange(len(response))[:, None, None] < TAIL_FROM, response, 0.0)
    return _convolve(response, force), _convolve(head, force), _convolve(response, force, {DOWN: 1, UP: 0})


def test_only_the_tail_is_left_out(sounds):
    whole, head, shed = sounds
    assert np.array_equal(shed[:DOWN], whole[:DOWN])
    gone = slice(DOWN + 3 * PERIOD, UP)
    assert np.abs(shed[gone] - head[gone]).max() < 1e-11 * np.abs(head).max()
    assert np.abs(whole[gone] - head[gone]).max() > 0.01 * np.abs(head).max()


def test_it_comes_back_whole_to_the_bit(sounds):
    whole, _, shed = sounds
    assert not np.array_equal(shed[UP : UP + PERIOD], whole[UP : UP + PERIOD])
    assert np.array_equal(shed[UP + 4 * PERIOD :], whole[UP + 4 * PERIOD :])


def test_it_fades_without_a_step(sounds):
    """Going and coming its energy passes between the tail's own and none over a period, and no sample jumps."""
    whole, head, shed = sounds
    tail, left = whole - head, shed - head
    steady = np.mean(tail[DOWN - PERIOD : FRAMES] ** 2)
    energy = np.mean(left.reshape(-1, 512, 2) ** 2, axis=(1, 2)) / steady
    assert energy.max() < 1.5 * np.max(np.mean(tail.reshape(-1, 512, 2) ** 2, axis=(1, 2))) / steady
    edges = np.abs(np.diff(energy))
    assert edges[DOWN // 512 :].max() < 0.35, "from one half of a block to the next it changes little by little"
    assert np.abs(np.diff(left, axis=0)).max() < 1.1 * np.abs(np.diff(tail, axis=0)).max()


def test_a_tone_leaves_no_click():
    """A steady tone: where its tail goes and comes, what is heard above 2 kHz stays 15 dB below the tail itself."""
    n = np.arange(FRAMES)
    force = np.stack([np.sin(2 * np.pi * 200.0 / 48000.0 * n)] * 2, axis=1)
    response = _response()
    head = np.where(np.arange(len(response))[:, None, None] < TAIL_FROM, response, 0.0)
    left = _convolve(response, force, {DOWN: 1, UP: 0}) - _convolve(head, force)
    frames = np.lib.stride_tricks.sliding_window_view(left[30000 - PERIOD :, 0], 1024)[::256] * np.hanning(1024)
    spectra = np.abs(np.fft.rfft(frames)) ** 2
    high = spectra[:, round(2000 / 48000 * 1024) :].sum(axis=1) / spectra.sum(axis=1).max()
    assert high.max() < 0.03


def test_a_short_response_has_no_tail_to_leave_out():
    force = np.random.default_rng(3).standard_normal((4 * PERIOD, 2))
    response = _response(5000)
    assert np.array_equal(_convolve(response, force), _convolve(response, force, {0: 1}))


def test_reset_takes_the_whole_response_up_again():
    response = _response()
    v, vi = convolver(response)
    convolver_shed(vi, 1)
    convolver_reset(v, vi)
    fresh = convolver(response)
    assert np.array_equal(vi, fresh[1]) and np.array_equal(v, fresh[0])
