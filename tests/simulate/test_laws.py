"""Laws that any right solver obeys: superposition, reciprocity, and energy that only work brings. Both solvers."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from reference.small_cases import case

from ukrt.experiment.case import ForceRamp, HeldString, Point, Record
from ukrt.model.contacts import held_by_finger
from ukrt.reference import compiled, solver
from ukrt.reference.landing import Landing
from ukrt.reference.system import make_system
from ukrt.simulate.on_engine import simulate as on_engine

SOLVERS = {
    "reference": (solver.simulate, 1e-10),
    "engine": (on_engine, 1e-10),
    "engine, same basis": (partial(on_engine, residual=False), 1e-8),
}
ON_E2 = ForceRamp("E2", 0.9, 0.001, 0.004, 3.0, 2.0)
ON_A2 = ForceRamp("A2", 0.7, 0.003, 0.006, 1.0, -2.0)


def _superposed(run, stretched, scale):
    """The largest difference between two plucks together and each for itself, relative; of three quantities."""
    one = case(bandwidth_hz=4000.0, tension_modulation=stretched, record=Record(displacement=(Point("E2", 0.6),)))
    plucks = [replace(pluck, force_y=scale * pluck.force_y, force_z=scale * pluck.force_z) for pluck in (ON_E2, ON_A2)]
    both, first, second = (run(replace(one, plucks=tuple(some))) for some in (plucks, plucks[:1], plucks[1:]))
    names = "bridge_force", "displacement"
    return max(np.abs(both[n] - first[n] - second[n]).max() / np.abs(both[n]).max() for n in names)


@pytest.mark.parametrize("name", SOLVERS)
def test_linear_strings_superpose_and_stretched_ones_do_not(name):
    """While the engine plucks a string it has one pseudo-mode more, so that with them the system changes in time."""
    run, _ = SOLVERS[name]
    assert _superposed(run, False, 1.0) < (1e-4 if name == "engine" else 1e-8)
    assert _superposed(run, True, 10.0) > 1e-4


@pytest.mark.parametrize("name", SOLVERS)
@pytest.mark.parametrize("other", [("E2", 0.31), ("A2", 0.63)])
def test_reciprocity(name, other):
    """What a pluck at one place does at another, it does the other way round: on one string and across the bridge.

    The engine's own pseudo-modes exist only where it is plucked at the time, so that places are not quite alike.
    """
    run, bound = SOLVERS[name]
    seen = []
    for (string, place), (at, where) in ((("E2", 0.9), other), (other, ("E2", 0.9))):
        record = Record(bridge_force=False, displacement=(Point(at, where),))
        pluck = ForceRamp(string, place, 0.0, 0.004, 3.0)
        seen.append(run(case("three", tension_modulation=False, plucks=(pluck,), record=record))["displacement"])
    size = np.abs(seen[0]).max()
    assert size > 1e-7
    assert np.abs(seen[0] - seen[1]).max() < (1e-3 if name == "engine" else bound) * size


def test_a_landing_brings_the_work_of_its_constraints_and_no_more():
    """Energy after minus before is the integral of lambda d' dt, to second order."""
    one = case(losses=False, bandwidth_hz=5000.0, held=())
    errors = []
    for step in (1e-5, 5e-6):
        guitar, n = one.instrument, round(0.02 / step)
        free, stopped = make_system(guitar, ((), ())), make_system(guitar, one_finger(guitar))
        motion = np.zeros((3, free.count))
        ramp = np.linspace(0.0, 3.0, n)[:, None]
        nothing = np.zeros((n, len(free.A)))
        compiled.run(free, motion, step, ramp, free.shape(0, 0.5, "Y")[None], nothing, range(0))
        start = np.zeros((3, stopped.count))
        start[:, : free.body.stop] = motion
        landing = Landing.none(free, 0.005).onto(stopped, start, {}, 0.0)
        at = step * np.arange(1, n + 1)
        b = landing.accelerations(at, step)
        before = _energy(stopped, start)
        start[2], first = solver.definition.accelerations(
            stopped, start[0], start[1], 0.0 * start[0], landing.accelerations(at[:1] - step, step)[0]
        )
        forces = compiled.run(stopped, start, step, np.zeros((n, 0)), np.zeros((0, stopped.count)), b, range(n))[2]
        moved = np.diff(landing.offsets(np.append(0.0, at)), axis=0)
        forces = np.vstack([first, forces])
        work = np.sum(0.5 * (forces[1:] + forces[:-1]) * moved)
        gained = _energy(stopped, start) - before
        assert abs(work) > 1e-3 * before
        errors.append(abs(gained - work) / before)
    assert errors[0] < 2e-2
    assert errors[1] < 0.4 * errors[0]


def one_finger(guitar):
    """The guitar's finger on its first string at 0.2509 L."""
    return held_by_finger(guitar.finger, 0.2509 * guitar.strings[0].length), ()


def _energy(system, motion):
    energy = 0.5 * np.sum(system.stiffness * motion[0] ** 2 + system.mass * motion[1] ** 2)
    for modes, y, z in zip(system.modes, system.strings_y, system.strings_z, strict=True):
        rise = modes.tension_rise(motion[0, y], motion[0, z])
        energy += 0.5 * rise**2 * modes.length / modes.axial_stiffness
    return energy


@pytest.mark.parametrize("name", SOLVERS)
def test_a_lifted_finger_takes_what_it_holds_and_nothing_comes(name):
    """Without losses: afterwards strings and body have what they had, and it stays so."""
    run, _ = SOLVERS[name]
    one = case(losses=False, bandwidth_hz=5000.0, duration=0.03, held=(HeldString("E2", 0.2509, 0.0, 0.02),))
    result = run(one)
    total, fingers = result.column("energies", "total"), result.column("energies", "fingers Y")
    fingers = fingers + result.column("energies", "fingers Z")
    lift = round(0.02 * result.rate_hz)
    assert fingers[lift + 1 :].max() == 0.0 < fingers[lift - 5]
    before, after = total[lift - 20 : lift - 1], total[lift + 2 :]
    assert after.max() < before.max() * (1.0 + 2e-3)
    assert after.min() > (before - fingers[lift - 20 : lift - 1]).min() * (1.0 - 1e-2)


@pytest.mark.parametrize("name", SOLVERS)
def test_a_finger_that_lands_on_a_string_at_rest_changes_nothing(name):
    run, _ = SOLVERS[name]
    one = case(held=(HeldString("E2", 0.2509, 0.0, 0.0195),))
    late = replace(one, held=(HeldString("E2", 0.2509, 0.001, 0.0195),))
    first, second = run(one), run(late)
    for quantity in ("displacement", "bridge_force", "energies"):
        size = np.abs(first[quantity]).max()
        np.testing.assert_allclose(second[quantity], first[quantity], rtol=0.0, atol=1e-9 * size, err_msg=quantity)


@pytest.mark.parametrize("name", SOLVERS)
def test_a_landing_goes_on_while_another_string_is_let_go(name):
    """Constraints hold all the time, the one that is being landed and those after it."""
    run, _ = SOLVERS[name]
    one = case("three", duration=0.03, held=(HeldString("E2", 0.2509, 0.015), HeldString("A2", 0.4, 0.0, 0.0173)))
    result = run(one)
    assert result.facts["largest_drift_m"] < 1e-12
    assert np.abs(result.column("displacement", "E2 Y 0.6 L")).max() > 1e-4


@pytest.mark.parametrize("name", SOLVERS)
def test_a_finger_that_goes_on_at_its_place_stays(name):
    run, _ = SOLVERS[name]
    whole = case(duration=0.03, held=(HeldString("E2", 0.2509),))
    parts = replace(whole, held=(HeldString("E2", 0.2509, 0.0, 0.017), HeldString("E2", 0.2509, 0.017, 1.0)))
    first, second = run(whole), run(parts)
    for quantity in ("displacement", "energies"):
        size = np.abs(first[quantity]).max()
        np.testing.assert_allclose(second[quantity], first[quantity], rtol=0.0, atol=1e-9 * size, err_msg=quantity)
