"""What the passes of `fft` need and mean, made in Python: radices, twiddles, the order in which values come out.

Enter a number of samples; leave tables. The compiler is not needed for it.
"""

import math

import numpy as np

SMALLEST = 64
NODE = 8  # doubles a node of the table takes: four twiddles, of which a radix of 2 or 4 uses the first one or two
LEAF = np.pi * np.array([0.0, 1.0, 0.5, 1.5, 0.25, 1.25, 0.75, 1.75])  # angles u - t/r of the factors, as they come out


def fft_radices(n):
    """Radices of the passes of a transform of ``n`` samples (tuple of int) without the last, which is always 8."""
    bits = int(n).bit_length() - 1
    if n < SMALLEST or n != 1 << bits:
        raise ValueError(f"an FFT takes a power of two of at least {SMALLEST} samples, not {n}")
    first = (bits - 4) % 3 + 1
    return (1 << first,) + (8,) * ((bits - first - 3) // 3)


def fft_table_size(n):
    """Length of the twiddle table for ``n`` samples [doubles]."""
    sizes = np.cumprod((1, *fft_radices(n)))
    return int(NODE * sizes.sum())


def _passes(n):
    """Yield (radix, angles t of the nodes the pass divides) for every pass, the last included."""
    angles = np.array([math.pi / 2])
    for radix in (*fft_radices(n), 8):
        yield radix, angles
        angles = (angles[:, None] / radix + LEAF[:radix]).ravel()


def _twiddles(angles):
    """The four twiddles of nodes at ``angles`` (n,): ndarray (n, 8) [1], real and imaginary part in turn."""
    turned = np.stack([angles / 2, angles / 4, angles / 8, angles / 8 + np.pi / 4], axis=1)
    return np.stack([np.cos(turned), np.sin(turned)], axis=2).reshape(-1, NODE)


def fft_table(n):
    """The twiddle table of a transform of ``n`` samples (ndarray (fft_table_size(n),) [1])."""
    *early, (_, before), (_, last) = list(_passes(n))
    tables = [_twiddles(angles).ravel() for _, angles in early]
    by_lane = _twiddles(last).reshape(-1, 8, NODE).transpose(0, 2, 1)  # eight nodes side by side in the lanes
    leaves = np.concatenate([_twiddles(before), by_lane.reshape(-1, 8 * NODE)], axis=1)
    return np.concatenate([*tables, leaves.ravel()])


def fft_angles(n):
    """The angle u of every output: X[j] = sum x[k] exp(i u[j] k) (ndarray (n,) [rad])."""
    *_, (_, last) = list(_passes(n))
    leaves = last.reshape(-1, 1, 8) / 8 + LEAF[None, :, None]
    return leaves.ravel()


def place_of(k):
    """Where point ``k`` of an array of points stands: a cache line is left free after 512 of them.

    Points a power of two apart would share few places in the cache, and compete for them.
    """
    return k + (k >> 9 << 3)
