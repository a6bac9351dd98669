"""Random guitars over the whole legal range of every parameter, for tests of stability."""

from dataclasses import replace

import numpy as np
from engine.bench import on_bench

from ukrt.errors import ParameterError
from ukrt.model.parameters import Basis, Body, Contact, String
from ukrt.model.presets import load_preset

RATES = (44100.0, 48000.0, 88200.0, 96000.0, 192000.0)


def even_in_log(rng, low, high):
    """A number between ``low`` and ``high``, each decade as likely as any other."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def _or_zero(rng, low, high):
    return 0.0 if rng.random() < 0.3 else even_in_log(rng, low, high)


def _string(rng):
    return String(
        name="any",
        note=40,
        length=even_in_log(rng, 0.1, 2.0),
        tension=even_in_log(rng, 1.0, 500.0),
        linear_density=even_in_log(rng, 1e-5, 0.1),
        bending_stiffness=_or_zero(rng, 1e-8, 0.01),
        axial_stiffness=_or_zero(rng, 10.0, 1e6),
        loss_internal=_or_zero(rng, 1e-6, 0.1),
        loss_air=_or_zero(rng, 1e-2, 100.0),
        loss_bending=_or_zero(rng, 1e-4, 1.0),
        bridge_position=float(rng.uniform(0.0, 1.0)),
    )


def _body(rng):
    n = int(rng.integers(0, 65))
    columns = (
        np.exp(rng.uniform(np.log(10.0), np.log(20000.0), n)),
        rng.integers(0, 2, n) * rng.uniform(0.0, 0.5, n),
        np.exp(rng.uniform(np.log(1e-4), np.log(1e4), n)),
        rng.uniform(-10.0, 10.0, n),
        rng.uniform(-10.0, 10.0, n),
    )
    return Body(*(tuple(map(float, column)) for column in columns))


def _contact(rng, offset):
    kind = rng.integers(0, 3)
    if kind == 0:
        return Contact(offset, rigid=True)
    if kind == 1:
        mass, damping = even_in_log(rng, 1e-5, 1.0), _or_zero(rng, 1e-4, 1e4)
        return Contact(offset, mass=mass, damping=damping, stiffness=_or_zero(rng, 1.0, 1e8))
    return Contact(offset, damping=even_in_log(rng, 1e-4, 1e4))


def random_instance(rng):
    """A legal guitar with 1 to 12 strings, its arrays at rest and the sample rate: (guitar, d, i, rate)."""
    guitar = load_preset("classical")
    while True:
        try:
            n_contacts = int(rng.integers(1, 5))
            offsets = -np.cumsum(rng.uniform(0.0011, 0.006, n_contacts))
            places = np.sort(rng.uniform(0.05, 0.95, int(rng.integers(0, 6 - n_contacts))))
            guitar = replace(
                guitar,
                strings=tuple(_string(rng) for _ in range(int(rng.integers(1, 13)))),
                body=_body(rng),
                finger=replace(guitar.finger, contacts=tuple(_contact(rng, float(offset)) for offset in offsets)),
                damper=replace(guitar.damper, places=tuple(places), damping_ratio=even_in_log(rng, 0.01, 100.0)),
                playing=replace(guitar.playing, frets=0),
                basis=Basis(even_in_log(rng, 1000.0, 20000.0)),
            )
            rate = float(rng.choice(RATES))
            return guitar, *on_bench(guitar, rate), rate
        except ParameterError:  # too many modes, or values that do not go together: draw again
            continue
