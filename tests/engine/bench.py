"""An instance on the bench: arrays filled from a guitar, gestures at frames, nothing of players and hosts around it."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np

from ukrt.engine import layout as at
from ukrt.engine.discretize import fill_instance, make_arrays
from ukrt.engine.kernels.advance import advance
from ukrt.engine.kernels.energy import total_energy
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.timeline import timeline_add
from ukrt.model.presets import load_preset

LOSSLESS = {"loss_internal": 0.0, "loss_air": 0.0, "loss_bending": 0.0}


def classical(**strings):
    """The default guitar, its strings changed by keywords."""
    guitar = load_preset("classical")
    return replace(guitar, strings=tuple(replace(string, **strings) for string in guitar.strings))


def undamped(**strings):
    """The default guitar without any loss in strings, body and fingers."""
    guitar = classical(**LOSSLESS, **strings)
    body = replace(guitar.body, damping_ratios=(0.0,) * len(guitar.body.frequencies_hz))
    contacts = tuple(replace(contact, damping=0.0) for contact in guitar.finger.contacts)
    return replace(guitar, body=body, finger=replace(guitar.finger, contacts=contacts))


def on_bench(guitar, sample_rate=48000.0):
    """Fresh arrays (d, i) of ``guitar`` at its own tensions."""
    d, i = make_arrays()
    tensions = SimpleNamespace(tensions=[string.tension for string in guitar.strings])
    fill_instance(d, i, guitar, tensions, sample_rate)
    return d, i


def add(d, i, frame, kind, s, *numbers):
    """Put a gesture on the timeline."""
    values = [float(number) for number in numbers] + [0.0] * (5 - len(numbers))
    assert timeline_add(d, i, frame, kind, s, *values) == 1


def fret_place(string, fret):
    """Where the fret of equal temperament stands [m]."""
    return string.length * (1.0 - 2.0 ** (-fret / 12.0))


@kernel
def run(d, i, n_blocks, block):
    """Advance by ``n_blocks`` blocks of at most 64 samples."""
    for _ in range(n_blocks):
        advance(d, i, block)


@kernel
def largest_growth(d, i, n_blocks, block, scale):
    """Advance; the largest growth over a block without gesture, over the largest energy (``scale[0]``)."""
    growth, last = 0.0, total_energy(d, i)
    for _ in range(n_blocks):
        busy = i[at.H_BUSY]
        advance(d, i, block)
        energy = total_energy(d, i)
        if not np.isfinite(energy):
            return np.inf
        if busy == 0 and i[at.H_BUSY] == 0 and scale[0] > 0.0:
            growth = max(growth, (energy - last) / scale[0])
        scale[0] = max(scale[0], energy)
        last = energy
    return growth
