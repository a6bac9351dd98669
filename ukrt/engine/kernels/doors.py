"""The kernels that Python calls to prepare and to run an instrument, as C functions of numbers and addresses.

C functions ask nothing of Python, so that their machine code can be kept and called without the compiler
(`ukrt.engine.compiled`, where they are called by the kernels' own names). Arrays come as the addresses of their data.
"""

from numba import types

from ukrt.engine import layout as at
from ukrt.engine import stage_layout as stage_at
from ukrt.engine.kernels import card, convolve, energy, modes, player, ports, queue
from ukrt.engine.kernels.jit import entry_point
from ukrt.engine.kernels.machine import doubles_at, integers_at, ticks

_WORD, _DOUBLE, _NOTHING = types.int64, types.float64, types.void


@entry_point(_WORD())
def ticks_now():
    """`machine.ticks`."""
    return ticks()


@entry_point(_WORD(_WORD, _WORD, _WORD, _WORD))
def lane_push(si, lane, frame, word):
    """`queue.lane_push`, 1 or 0."""
    return _WORD(queue.lane_push(integers_at(si, stage_at.SI_SIZE), lane, frame, word))


@entry_point(_DOUBLE(_DOUBLE))
def limiter_gain(peak):
    """`card.limiter_gain`."""
    return card.limiter_gain(peak)


@entry_point(_DOUBLE(_WORD, _WORD))
def total_energy(d, i):
    """`energy.total_energy`."""
    return energy.total_energy(doubles_at(d, at.D_SIZE), integers_at(i, at.I_SIZE))


@entry_point(_NOTHING(_WORD, _WORD))
def player_reset(d, i):
    """`player.player_reset`."""
    player.player_reset(doubles_at(d, at.D_SIZE), integers_at(i, at.I_SIZE))


@entry_point(_NOTHING(_WORD, _WORD, _WORD))
def tune_string(d, i, s):
    """`modes.tune_string`."""
    modes.tune_string(doubles_at(d, at.D_SIZE), integers_at(i, at.I_SIZE), s)


@entry_point(_NOTHING(_WORD, _WORD, _WORD))
def refit_string(d, i, s):
    """`ports.refit_string`."""
    ports.refit_string(doubles_at(d, at.D_SIZE), integers_at(i, at.I_SIZE), s)


@entry_point(_NOTHING(_DOUBLE, _DOUBLE, _DOUBLE, _WORD))
def flow(omega, zeta, dt, ab):
    """`modes.flow` to two doubles."""
    out = doubles_at(ab, 2)
    out[0], out[1] = modes.flow(omega, zeta, dt)


@entry_point(_NOTHING(_WORD, _WORD, _WORD, _WORD))
def convolver_reset(v, len_v, vi, len_vi):
    """`convolve.convolver_reset`."""
    convolve.convolver_reset(doubles_at(v, len_v), integers_at(vi, len_vi))
