"""Arrays and runs that several tests of the convolver share."""

import numpy as np

from ukrt.engine import convolver
from ukrt.engine.kernels import convolve


def aligned(length):
    """Zeros on a 64-byte boundary (ndarray (length,))."""
    room = np.zeros(length + 8)
    start = -room.ctypes.data // 8 % 8
    return room[start : start + length]


def make_convolver(ir):
    """The two arrays of a convolver of ``ir`` (n, 2, 2)."""
    len_v, len_vi = convolver.convolver_size(len(ir))
    v, vi = aligned(len_v), np.zeros(len_vi, dtype=np.int64)
    convolver.convolver_prepare(ir, v, vi)
    return v, vi


def stream(v, vi, x, sizes, frame=0):
    """Convolve x (n, 2), cut into blocks of ``sizes`` (an iterator) as a host would, from ``frame`` on: (n, 2)."""
    y = np.empty_like(x)
    inp, out = aligned(128), aligned(128)
    at = 0
    while at < len(x):
        wanted = min(next(sizes), len(x) - at)
        while wanted:
            n = min(wanted, 64 - (frame + at) % 64)
            inp[:n], inp[64 : 64 + n] = x[at : at + n].T
            convolve.convolve_chunk(v, vi, frame + at, n, inp, 0, out, 0)
            y[at : at + n, 0], y[at : at + n, 1] = out[:n], out[64 : 64 + n]
            at, wanted = at + n, wanted - n
    return y
