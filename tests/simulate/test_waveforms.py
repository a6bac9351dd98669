"""The engine beside the reference, same basis: the same waveforms, ever nearer as the step shrinks.

A wrong sign, unit, label or instant of any quantity would show here; tools/compare_waveforms.py prints the whole table.
"""

from dataclasses import replace

import numpy as np
import pytest
from reference.small_cases import EVERYTHING, case
from simulate.waveforms import engine_at, limit_of, orders, reference_at

from ukrt.experiment.case import ForceRamp, HeldString, Point
from ukrt.reference.solver import simulate as reference
from ukrt.simulate import on_engine
from ukrt.simulate.on_engine import simulate as engine

RATES = (48000.0, 96000.0)
FINE = 384000.0  # and twice that: the reference's rates
AT_48 = {  # relative rms at 48 kHz: measured, and half as much again
    "bridge_force": 5e-3,
    "bridge_force, smoothed": 4e-4,
    "displacement": 1.5e-4,
    "displacement, smoothed": 1.4e-4,
    "energies": 4e-3,
    "tension": 6e-3,
    "amplitudes": 2e-4,
}


def _compared(one):
    limit = limit_of(*(reference_at(one, rate) for rate in (FINE, 2.0 * FINE)))
    return [engine_at(one, rate).difference(limit) for rate in RATES]


@pytest.mark.parametrize(
    ("finger", "stretched"), [("oscillator", False), ("oscillator", True), ("rigid", False), ("damper", True)]
)
def test_every_quantity_agrees_to_second_order(finger, stretched):
    coarse, fine = _compared(case(finger, tension_modulation=stretched, duration=0.05))
    order = orders([coarse, fine])
    for name, bound in AT_48.items():
        if name == "tension" and not stretched:
            continue
        assert coarse[name] < bound, name
        if name in ("energies", "tension") or "smoothed" in name:  # for others the limit would have to be finer
            assert order[name][0] > 1.75, name


@pytest.mark.parametrize(
    "held",
    [
        HeldString("E2", 0.2509, 0.02),
        HeldString("E2", 0.2509, 0.0, 0.03),
        HeldString("E2", 0.2509, 0.0205, 0.0405),
    ],
    ids=["landing", "lifting", "both"],
)
def test_fingers_that_come_and_go_agree_to_first_order(held):
    """The engine knows when a finger touches to within a sample, and the speed there half a sample late."""
    coarse, fine = _compared(case(duration=0.05, held=(held,)))
    order = orders([coarse, fine])
    for name in ("displacement", "energies", "bridge_force, smoothed"):
        assert coarse[name] < 0.05, name
        assert order[name][0] > 0.6, name


def test_the_cut_modes_show_at_the_bridge_only_with_residuals():
    """Without pseudo-modes and with a tenth of what is left of them: the same to 1e-9. With them: another pitch."""
    one = case("three", duration=0.05, tension_modulation=False)
    plain, whole = engine(one, residual=False), engine(one)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(on_engine, "SAME_BASIS", 0.1 * on_engine.SAME_BASIS)
        less = engine(one, residual=False)
    for name in ("bridge_force", "displacement"):
        size = np.abs(plain[name]).max()
        assert np.abs(plain[name] - less[name]).max() < 1e-8 * size
        assert np.abs(plain[name] - whole[name]).max() > 1e-3 * size


def test_results_have_the_same_shape():
    one = case("three", record=replace(EVERYTHING, rate_hz=12000.0, displacement=(Point("A2", 0.2, "Z"),)))
    both = [run(one) for run in (reference, engine)]
    assert list(both[0].quantities) == list(both[1].quantities)
    for name, quantity in both[0].quantities.items():
        other = both[1].quantities[name]
        assert (quantity.unit, quantity.columns) == (other.unit, other.columns), name
        assert (
            quantity.values.shape[1:] == other.values.shape[1:] == ((len(quantity.columns),) if name != "drift" else ())
        )
        assert len(quantity.values) == len(both[0].times)
    assert [result.solver for result in both] == ["reference", "engine"]
    assert both[0].facts["modes"] == both[1].facts["modes"]
    assert 2.0 * 12000.0 > both[1].rate_hz > 11999.0 > both[0].rate_hz


def test_plucks_of_every_direction_agree():
    """The sign of either component, and which way the angle turns."""
    for y, z in ((3.0, -2.0), (-1.0, 2.0), (0.0, -1.0)):
        one = case(plucks=(ForceRamp("E2", 0.9, 0.002, 0.01, y, z),), duration=0.015)
        ours, theirs = engine_at(one, 48000.0), reference_at(one, 192000.0)
        assert ours.difference(theirs)["displacement"] < 3e-3
