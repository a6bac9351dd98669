"""What a run on the engine keeps, and what it refuses."""

from dataclasses import replace

import numpy as np
import pytest
from reference.small_cases import EVERYTHING, case, guitar

from ukrt.errors import ParameterError
from ukrt.experiment.case import ForceRamp, HeldString, Point, Record
from ukrt.model.body import bridge_shapes
from ukrt.simulate.on_engine import simulate


def test_energy_is_constant_and_constraints_hold():
    """Without losses the scheme's energy is constant to rounding once the pluck is over; stretched strings included."""
    result = simulate(case("three", losses=False, duration=0.1, plucks=(ForceRamp("E2", 0.9, 0.0, 0.01, 20.0, 10.0),)))
    total = result.column("energies", "total")[500:]
    assert np.ptp(total) < 1e-11 * total.mean()
    assert result.column("energies", "stretch").max() > 1e-3 * total.mean()
    assert result.facts["largest_drift_m"] < 1e-14
    assert len(result["drift"]) == len(result.times) == 4801


def test_the_bridge_is_where_the_body_is():
    """A string's end at 1.0 L, pseudo-modes included, and the body's modes at its place on the bridge."""
    points = tuple(Point(name, 1.0) for name in ("E2", "A2"))
    one = case("three", record=replace(EVERYTHING, displacement=points))
    result = simulate(one)
    count = len(one.instrument.body.frequencies_hz)
    body = result["amplitudes"][:, -count:] @ bridge_shapes(one.instrument).T
    np.testing.assert_allclose(result["displacement"], body, rtol=0.0, atol=1e-12 * np.abs(body).max())


def test_a_string_does_not_move_where_it_is_held_rigidly():
    one = case("rigid", record=Record(displacement=(Point("E2", 0.2509), Point("E2", 0.2509, "Z"), Point("E2", 0.26))))
    moved = np.abs(simulate(one)["displacement"]).max(axis=0)
    assert moved[:2].max() < 1e-10 * moved[2]


def test_what_is_kept_changes_nothing():
    one = case(held=(HeldString("E2", 0.2509, 0.005, 0.013),), record=replace(EVERYTHING, rate_hz=48000.0))
    whole, some = simulate(one), simulate(replace(one, record=replace(EVERYTHING, rate_hz=16000.0)))
    np.testing.assert_allclose(some.times, whole.times[::3], rtol=1e-14)
    for name in whole.quantities:
        assert np.array_equal(some[name], whole[name][::3]), name


def test_nothing_moves_before_the_pluck():
    one = case(plucks=(ForceRamp("E2", 0.9, 0.010, 0.005, 3.0),))
    result = simulate(one)
    before = result.times < 0.010 - 1e-9
    assert np.abs(result["displacement"][before]).max() == 0.0
    assert np.abs(result["displacement"][~before]).max() > 0.0


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"plucks": (ForceRamp("E2", 0.9, 0.0, 0.01, 1.0), ForceRamp("E2", 0.5, 0.009, 0.01, 1.0))}, "plucks.1.start"),
        ({"plucks": (ForceRamp("E2", 0.5, 0.009, 0.01, 1.0), ForceRamp("E2", 0.9, 0.0, 0.01, 1.0))}, "plucks.0.start"),
        ({"guitar": guitar("three"), "held": (HeldString("E2", 0.0135),)}, "held.0.place"),
        ({"guitar": guitar(bandwidth_hz=20000.0), "strings": (), "sample_rate": 44100.0, "held": ()}, None),
    ],
)
def test_what_the_engine_cannot_do(changes, words):
    one = case(**changes)
    if words is None:  # the limit itself is legal
        simulate(one)
        return
    with pytest.raises(ParameterError, match=words):
        simulate(one)


def test_a_rate_that_does_not_carry_the_basis_is_refused_by_the_cases_key(monkeypatch):
    from ukrt.engine import discretize

    monkeypatch.setattr(discretize, "RATES", (8000.0, 192000.0))
    with pytest.raises(ParameterError, match=r"guitar\.basis\.bandwidth_hz"):
        simulate(_at(case(), 16000.0))


def _at(one, rate):
    object.__setattr__(one, "sample_rate", rate)  # below what a case allows
    return one


def test_plucks_one_after_the_other_and_on_several_strings_are_fine():
    plucks = (
        ForceRamp("E2", 0.9, 0.0, 0.005, 1.0),
        ForceRamp("A2", 0.9, 0.002, 0.005, 1.0),
        ForceRamp("E2", 0.5, 0.0051, 0.005, 1.0),
    )
    assert np.abs(simulate(case(plucks=plucks, held=()))["displacement"]).max() > 1e-5
