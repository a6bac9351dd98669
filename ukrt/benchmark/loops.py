"""Compiled loops that measure: parts of the engine by themselves, and what the processor can do at its best.

The parts are the engine's own kernels on an instance's arrays, repeated; nothing of what they compute is used.
"""

from ukrt.engine import layout as at
from ukrt.engine.kernels.convolve import convolve_chunk
from ukrt.engine.kernels.hands import perform
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.player import player_message
from ukrt.engine.kernels.ramps import begin_sample, end_sample
from ukrt.engine.kernels.simd import ZERO, Loop, vector_kernel
from ukrt.engine.kernels.solve import solve_constraints
from ukrt.engine.kernels.sweep import make_sweep, sweep_string

CHAINS = 16  # sums that do not wait for each other: more than latency times width of any processor's units
STREAM = 2048  # doubles that are read and written: 16 KiB, half of the smallest first-level cache
_linear0, _linear3 = make_sweep(0, tension=False), make_sweep(3, tension=False)


@kernel
def sweep_strings(d, i, n, extra):
    """``n`` samples of the sweeps of all strings that have ``extra`` columns."""
    for _ in range(n):
        for s in range(i[at.H_STRINGS]):
            own = at.STRING_I + s * at.STRING_I_SIZE
            if i[own + at.SI_EXTRA] == extra:
                sweep_string(d, i, s)


@kernel
def sweep_linear(d, i, n, extra):
    """The same for ``extra`` 0 or 3, without what tension modulation needs."""
    for _ in range(n):
        for s in range(i[at.H_STRINGS]):
            own = at.STRING_I + s * at.STRING_I_SIZE
            first, end = i[own + at.SI_TILE], i[own + at.SI_END]
            pseudo = first + i[own + at.SI_TILES] - at.PSEUDO_TILES
            if i[own + at.SI_EXTRA] == extra and extra == 0:
                _linear0(d, first, pseudo, end, s)
            elif i[own + at.SI_EXTRA] == extra and extra == 3:
                _linear3(d, first, pseudo, end, s)


@kernel
def solve_samples(d, i, n, _):
    """``n`` samples of the constraint solve, the body's modes included."""
    for _ in range(n):
        solve_constraints(d, i[at.H_STRINGS], i[at.H_PORTS], i[at.H_BODY])


@kernel
def convolve_frames(v, vi, d, frame, n):
    """``n`` frames of the convolver from ``frame`` on, a multiple of CHUNK at a time."""
    for k in range(n // at.CHUNK):
        convolve_chunk(v, vi, frame + k * at.CHUNK, at.CHUNK, d, at.BRIDGE, d, at.PRESSURE)


@kernel
def play_message(d, i, frame, status, data1, data2):
    """One message for the player."""
    player_message(d, i, frame, status, data1, data2)


@kernel
def make_gesture(d, i, samples, kind, s, p0, p1):
    """A hand begins something and goes on for ``samples`` samples: what is done beside the sweeps and the solver."""
    perform(d, i, kind, s, p0, p1, 0.0, 0.0)
    for _ in range(samples):
        begin_sample(d, i)
        end_sample(d, i)


@vector_kernel(1)
def _multiply_add(v, passes):
    x, y = v.load(v.index(0)), v.load(v.index(8))
    loop = Loop(v, v.index(0), passes, [ZERO] * CHAINS)
    for k, value in enumerate(loop.close([v.fma(x, value, y) for value in loop.carried])):
        v.store(value, v.index(16 + 8 * k))


@kernel
def multiply_add(d, passes):
    """``passes`` times CHAINS multiply-adds of eight doubles; ``d`` holds 16 + 8 CHAINS doubles."""
    _multiply_add(d, passes)


@vector_kernel(0)
def _copy(v):
    loop = Loop(v, v.index(0), v.index(STREAM // 16), [ZERO])
    place = v.builder.mul(loop.index, v.index(16))
    first, second = v.load(v.at(place)), v.load(v.at(place, 8))
    v.store(second, v.at(place))
    v.store(first, v.at(place, 8))
    loop.close([ZERO])


@kernel
def stream(d, passes):
    """Read and write STREAM doubles ``passes`` times, as a sweep goes through its modes."""
    for _ in range(passes):
        _copy(d)
