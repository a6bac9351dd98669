"""Energy never grows by itself: any legal guitar, any fingering, plucks up to 100 N, all six kinds of sample rate."""

import numpy as np
import pytest
from engine.bench import largest_growth
from engine.random_guitar import even_in_log, random_instance

from ukrt.engine import gestures
from ukrt.engine import layout as at
from ukrt.engine.kernels.hands import perform

ROUNDS, BLOCKS, BLOCK = 5, 60, 32


def _random_hands(rng, guitar, d, i):
    """On every string perhaps a new fingering, perhaps a pluck."""
    for s, string in enumerate(guitar.strings):
        frames, choice = float(rng.integers(1, 300)), rng.random()
        if choice < 0.3:
            perform(d, i, gestures.PRESS, s, float(rng.uniform(0.05, 0.9)) * string.length, frames, 0.0, 0.0)
        elif choice < 0.4:
            perform(d, i, gestures.LIFT, s, 0.0, frames, 0.0, 0.0)
        elif choice < 0.5:
            perform(d, i, gestures.DAMP, s, float(rng.random()), frames, 0.0, 0.0)
        elif choice < 0.6:
            perform(d, i, gestures.UNDAMP, s, 0.0, frames, 0.0, 0.0)
        elif choice < 0.7:
            perform(d, i, gestures.TENSION, s, float(rng.uniform(0.7, 1.4)), frames, 0.0, 0.0)
        if rng.random() < 0.7:
            force, angle = even_in_log(rng, 0.1, 100.0), float(rng.uniform(-3.0, 3.0))
            ramp = float(rng.integers(2, 600))
            perform(d, i, gestures.PLUCK, s, float(rng.uniform(0.02, 0.98)), force, angle, ramp)


@pytest.mark.parametrize("seed", range(24))
def test_energy_of_any_legal_guitar_never_grows_unforced(seed):
    rng = np.random.default_rng(seed)
    guitar, d, i, _ = random_instance(rng)
    scale = np.zeros(1)
    for _ in range(ROUNDS):
        _random_hands(rng, guitar, d, i)
        assert largest_growth(d, i, BLOCKS, BLOCK, scale) < 1e-9
    assert scale[0] > 0.0, "nothing was plucked: the test saw nothing"
    bridge = d[at.BRIDGE : at.BRIDGE + 2 * at.CHUNK]
    assert np.isfinite(bridge).all()
