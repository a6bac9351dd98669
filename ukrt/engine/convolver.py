"""The arrays of a streaming convolver at rest: responses enter, what `kernels.convolve` runs on leaves."""

import numpy as np

from ukrt.engine.kernels import convolve_layout as layout
from ukrt.engine.kernels.convolve_layout import BLOCK
from ukrt.engine.kernels.fft_tables import fft_angles, fft_table


def convolver_size(n_taps):
    """Lengths of the two arrays of a convolver of ``n_taps`` taps: (len_v, len_vi)."""
    plan = layout.make_plan(n_taps)
    return plan.len_v, len(plan.integers)


def convolver_prepare(ir, v, vi):
    """Fill a convolver's arrays from its responses, at rest.

    Parameters
    ----------
    ir : ndarray (n_taps, 2, 2) [Pa/N per sample]
        Taps of: input (bass end, treble end), output (left, right).
    v : ndarray (len_v,) float64, its data on a 64-byte boundary
    vi : ndarray (len_vi,) int64
    """
    ir = np.asarray(ir, dtype=np.float64)
    plan = layout.make_plan(len(ir))
    if v.ctypes.data % 64 or len(v) < plan.len_v or len(vi) < len(plan.integers):
        raise ValueError(f"a convolver of {len(ir)} taps needs {plan.len_v} doubles from a 64-byte boundary")
    v[: plan.len_v] = 0.0
    vi[: len(plan.integers)] = plan.integers
    head = np.zeros((BLOCK, 2, 2))
    head[: min(BLOCK, len(ir))] = ir[:BLOCK]
    v[plan.head : plan.head + 4 * BLOCK] = head.transpose(1, 2, 0).ravel()
    for level in plan.levels:
        table = fft_table(level.size)
        v[level.table : level.table + len(table)] = table
        taps = np.zeros((level.partitions, level.size, 2, 2))
        part = ir[level.start : level.start + taps.shape[0] * level.size]
        taps.reshape(-1, 2, 2)[: len(part)] = part
        v[level.spectra : level.spectra + 2 * taps.size] = _spectra(taps, level.size)


def _spectra(taps, size):
    """Spectra of partitions (n, size, 2, 2) as the products want them: by tile, partition, input, output, part."""
    turn = np.exp(0.5j * np.pi / size * np.arange(size))
    bins = np.rint((fft_angles(size) - 0.5 * np.pi / size) * size / (2 * np.pi)).astype(int) % size
    result = np.empty((size // 8, len(taps), 2, 2, 2, 8))
    for number, partition in enumerate(taps):
        spectrum = np.fft.ifft(partition * turn[:, None, None], axis=0)[bins]  # with the 1/size of our inverse
        tiles = spectrum.reshape(-1, 8, 2, 2).transpose(0, 2, 3, 1)
        result[:, number, :, :, 0], result[:, number, :, :, 1] = tiles.real, tiles.imag
    return result.ravel()
