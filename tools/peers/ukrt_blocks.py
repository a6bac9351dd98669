"""Used by ``bench_peers``: ukrt's convolver, one block of 64 frames after the other.

    python -m peers.ukrt_blocks TAPS SECONDS

Two inputs and two outputs, as the guitar needs. Prints what ``zita_blocks`` prints: CPU time [s], then the quantiles
0.5 and 0.99 of the blocks' times [us].
"""

import sys
import time

import numba
import numpy as np

from ukrt.engine import convolver
from ukrt.engine.kernels import convolve
from ukrt.engine.kernels.machine import ticks, ticks_now

from .peer import BLOCK, SAMPLE_RATE


@numba.njit
def _blocks(v, vi, sound, out, first, times):
    """Convolve a block for each of ``times``, which is filled with ticks; ``sound`` (n, 128) goes round."""
    for k in range(len(times)):
        inputs = sound[(first + k) % len(sound)]
        before = ticks()
        convolve.convolve_chunk(v, vi, BLOCK * (first + k), BLOCK, inputs, 0, out, 0)
        times[k] = ticks() - before


def aligned(length):
    """Zeros on a 64-byte boundary: ndarray (length,)."""
    room = np.zeros(length + 8)
    start = -room.ctypes.data // 8 % 8
    return room[start : start + length]


def measure(n_taps, seconds):
    """CPU time [s] of so much sound, median and 99th percentile of the blocks' times [us]."""
    rng = np.random.default_rng(1)
    len_v, len_vi = convolver.convolver_size(n_taps)
    v, vi, out = aligned(len_v), np.zeros(len_vi, np.int64), aligned(2 * BLOCK)
    decay = np.exp(-5.0 * np.arange(n_taps) / n_taps)[:, None, None]
    convolver.convolver_prepare(0.01 * decay * rng.standard_normal((n_taps, 2, 2)), v, vi)
    sound = rng.uniform(-1.0, 1.0, (SAMPLE_RATE // BLOCK, 2 * BLOCK))
    warm_up, n = SAMPLE_RATE // BLOCK, int(seconds * SAMPLE_RATE) // BLOCK
    times = np.zeros(n, np.int64)
    _blocks(v, vi, sound, out, 0, times[:warm_up])
    before, clock, counter = time.process_time(), time.perf_counter(), ticks_now()
    _blocks(v, vi, sound, out, warm_up, times)
    taken, ticks_a_second = time.process_time() - before, (ticks_now() - counter) / (time.perf_counter() - clock)
    return taken, *(np.quantile(times, (0.5, 0.99)) / ticks_a_second * 1e6)


if __name__ == "__main__":
    print(*(f"{number:.6f}" for number in measure(int(sys.argv[1]), float(sys.argv[2]))))
