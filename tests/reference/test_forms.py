"""The compiled form makes the same steps as the definition."""

from dataclasses import replace

import numpy as np
import pytest
from reference.small_cases import case

from ukrt.experiment.case import ForceRamp, HeldString
from ukrt.reference.solver import simulate

FEATURES = {
    "rigid contacts, linear": {"finger": "rigid", "tension_modulation": False},
    "oscillators, stretched strings": {"finger": "three"},
    "a damper": {"finger": "damper"},
    "landing and lifting": {"held": (HeldString("E2", 0.2509, 0.004, 0.015), HeldString("A2", 0.3, 0.0, 0.007))},
    "no losses, rigid bridge": {"losses": False, "bridge": "rigid"},
    "plucks at once": {"plucks": (ForceRamp("E2", 0.9, 0.0, 0.004, 30.0, 20.0), ForceRamp("E2", 0.4, 0.0, 0.01, 1.0))},
}


@pytest.mark.parametrize("words", FEATURES)
@pytest.mark.parametrize("damping_velocity", ["predicted", "half-step"])
def test_both_forms_are_equal(words, damping_velocity):
    one = case(bandwidth_hz=4000.0, **FEATURES[words])
    plain, quick = (simulate(one, form, damping_velocity) for form in ("numpy", "compiled"))
    for name in set(plain.quantities) - {"drift"}:
        size = np.abs(plain[name]).max()
        assert size > 0.0
        assert np.abs(plain[name] - quick[name]).max() < 1e-9 * size, name


def test_what_is_kept_changes_nothing():
    """Every third step is the same as every third of all steps, gestures included; so it is with the definition."""
    one = case(bandwidth_hz=2000.0, duration=0.008, held=(HeldString("E2", 0.2509, 0.0041, 0.0061),))
    sparse = replace(one, record=replace(one.record, rate_hz=1e5 / 3.0))
    for form in ("numpy", "compiled"):
        whole, third = simulate(one, form), simulate(sparse, form)
        assert len(third.times) == 800 // 3 + 1
        np.testing.assert_allclose(third.times, whole.times[::3], rtol=1e-12)
        for name in whole.quantities:
            np.testing.assert_allclose(third[name], whole[name][::3], rtol=0.0, atol=1e-12, err_msg=name)
