"""Compiled functions as Python calls them: from machine code that is kept, or else from the compiler.

Enter arrays and numbers; what the kernels of the same names do is done. Whoever imports this has not loaded the
compiler yet: it is loaded with the first call, and only if nothing is kept for these sources and this processor.
"""

import ctypes
import functools
import importlib

import numpy as np

_KERNELS = "ukrt.engine.kernels."
_WORD, _DOUBLE = ctypes.c_int64, ctypes.c_double
# Name -> module, type of the result, types of the arguments; what the engine calls by its address has no types here.
_ENTRIES = {
    "callback": ("callback",),
    "play": ("play",),
    "take_over": ("take_over",),
    "ticks_now": ("doors", _WORD),
    "lane_push": ("doors", _WORD, _WORD, _WORD, _WORD, _WORD),
    "limiter_gain": ("doors", _DOUBLE, _DOUBLE),
    "total_energy": ("doors", _DOUBLE, _WORD, _WORD),
    "player_reset": ("doors", None, _WORD, _WORD),
    "tune_string": ("doors", None, _WORD, _WORD, _WORD),
    "refit_string": ("doors", None, _WORD, _WORD, _WORD),
    "flow": ("doors", None, _DOUBLE, _DOUBLE, _DOUBLE, _WORD),
    "convolver_reset": ("doors", None, _WORD, _WORD, _WORD, _WORD),
}
_given = None  # a file to be used, whatever is kept


def use(path):
    """Load machine code from this file (Path) alone; only before anything has been called."""
    global _given
    _given = path


@functools.cache
def address(name):
    """Address of a C function (int)."""
    return _addresses()[name]


@functools.cache
def _addresses():
    from ukrt.engine import machine_code

    if _given:
        return machine_code.read(_given)
    path = machine_code.kept_file()
    found = machine_code.read(path)
    if found is None or found.keys() != _ENTRIES.keys():
        made = {
            name: getattr(importlib.import_module(_KERNELS + module), name) for name, (module, *_) in _ENTRIES.items()
        }
        machine_code.write(path, made)
        found = {name: function.address for name, function in made.items()}
    return found


@functools.cache
def _function(name):
    _, result, *arguments = _ENTRIES[name]
    return ctypes.CFUNCTYPE(result, *arguments)(address(name))


def _data(array):
    return array.__array_interface__["data"][0]  # ten times quicker than array.ctypes


def ticks_now():
    """A counter that runs steadily (int), 0 where there is none."""
    return _function("ticks_now")()


def lane_push(si, lane, frame, word):
    """See `kernels.queue.lane_push`."""
    return bool(_function("lane_push")(_data(si), lane, frame, word))


def limiter_gain(peak):
    """See `kernels.card.limiter_gain`."""
    return _function("limiter_gain")(peak)


def total_energy(d, i):
    """See `kernels.energy.total_energy`."""
    return _function("total_energy")(_data(d), _data(i))


def player_reset(d, i):
    """See `kernels.player.player_reset`."""
    _function("player_reset")(_data(d), _data(i))


def tune_string(d, i, s):
    """See `kernels.modes.tune_string`."""
    _function("tune_string")(_data(d), _data(i), s)


def refit_string(d, i, s):
    """See `kernels.ports.refit_string`."""
    _function("refit_string")(_data(d), _data(i), s)


def flow(omega, zeta, dt):
    """See `kernels.modes.flow`."""
    out = np.empty(2)
    _function("flow")(omega, zeta, dt, _data(out))
    return tuple(out)


def convolver_reset(v, vi):
    """See `kernels.convolve.convolver_reset`."""
    _function("convolver_reset")(_data(v), len(v), _data(vi), len(vi))
