"""The reference against closed forms: Verlet's own frequency, partials of a string, energy, time reversal."""

from dataclasses import replace

import numpy as np
import pytest
from reference.small_cases import case, fig_6
from scipy.linalg import null_space

from ukrt.errors import ParameterError
from ukrt.experiment.case import ForceRamp, HeldString, Record
from ukrt.model.strings import ideal_open_hz
from ukrt.reference import compiled, definition
from ukrt.reference.solver import simulate
from ukrt.reference.system import make_system

STEP = 1e-5
E4_HELD = (HeldString("E4", 0.2509),)
RUNS = {"numpy": definition.run, "compiled": compiled.run}


def _free_run(system, motion, n_steps, form="compiled", keep=1):
    """Steps without anything from outside."""
    nothing = np.zeros((n_steps, 0)), np.zeros((0, system.count)), np.zeros((n_steps, len(system.A)))
    return RUNS[form](system, motion, STEP, *nothing, range(keep - 1, n_steps, keep))


def _at_rest(system, q):
    """Motion that begins at displacement ``q`` without speed."""
    nothing = np.zeros(0), np.zeros(len(system.A))
    acceleration, _ = definition.accelerations(system, q, 0.0 * q, 0.0 * q, nothing[1])
    return np.array([q, 0.0 * q, acceleration])


def _eigenmodes(system):
    """Angular frequencies [rad/s] and shapes (columns) of the constrained system, in its null space: no time steps."""
    root = np.sqrt(system.mass)
    free = null_space(system.A / root)
    square, inside = np.linalg.eigh(free.T @ np.diag(system.stiffness / system.mass) @ free)
    return np.sqrt(np.maximum(square, 0.0)), (free @ inside) / root[:, None]


@pytest.mark.parametrize("form", RUNS)
@pytest.mark.parametrize("number", [0, 3, 40])
def test_an_eigenmode_of_the_coupled_system_has_verlets_exact_frequency(form, number):
    """x_k = cos(k phi) with phi = 2 asin(omega dt / 2): strings, body and finger together are one free mode here."""
    one = case(bandwidth_hz=3000.0, losses=False, tension_modulation=False)
    system = make_system(one.instrument, one.held_points(0.0))
    omega, shapes = _eigenmodes(system)
    shape = shapes[:, number]
    kept_q, _, _ = _free_run(system, _at_rest(system, shape), 1500, form)
    phase = 2.0 * np.arcsin(0.5 * omega[number] * STEP) * np.arange(1, 1501)
    assert np.abs(kept_q - np.cos(phase)[:, None] * shape).max() < 1e-8 * np.abs(shape).max()


def test_partials_between_rigid_ends():
    """A flexible string on a rigid bridge has n c_T / 2 L; the cut basis leaves it sharp, by ever less."""
    excess = []
    for bandwidth in (5000.0, 10000.0):
        one = case(bandwidth_hz=bandwidth, bridge="rigid", strings=("E2",), held=(), losses=False)
        string = replace(one.instrument.strings[0], bending_stiffness=0.0)
        system = make_system(replace(one.instrument, strings=(string,)), ((),))
        hertz = _eigenmodes(system)[0][:16:2] / (2.0 * np.pi)  # Y and Z are alike
        excess.append(1200.0 * np.log2(hertz / (np.arange(1, 9) * ideal_open_hz(string))))
    assert (np.array(excess) > 0.0).all()
    assert (excess[1] < 0.6 * excess[0]).all()
    assert excess[1].max() < 8.0


def _total(result):
    energy = result.column("energies", "total")
    return energy[int(0.013 * len(energy) / result.case.duration) :]  # after the pluck


@pytest.mark.parametrize("stretched", [False, True])
def test_undamped_energy_is_bounded_and_second_order(stretched):
    one = case(bandwidth_hz=5000.0, duration=0.2, losses=False, tension_modulation=stretched)
    spreads = []
    for step in (STEP, STEP / 2.0):
        energy = _total(simulate(replace(one, step=step)))
        spreads.append(np.ptp(energy) / energy.mean())
        first, last = np.array_split(energy, 8)[0], np.array_split(energy, 8)[-1]
        assert abs(last.mean() - first.mean()) < 0.5 * np.ptp(energy), "it drifts"
    assert spreads[0] < 0.01
    assert 3.0 < spreads[0] / spreads[1] < 5.0


@pytest.mark.parametrize("force", [3.0, 40.0])
@pytest.mark.parametrize("stretched", [False, True])
def test_time_runs_backwards(stretched, force):
    """Without losses the scheme is its own inverse under v -> -v, stretched strings included."""
    one = case(bandwidth_hz=5000.0, losses=False, tension_modulation=stretched)
    system = make_system(one.instrument, one.held_points(0.0))
    shape = system.shape(0, 0.5, "Y") + 0.5 * system.shape(0, 0.5, "Z")
    motion = _at_rest(system, np.zeros(system.count))
    pushes = np.linspace(0.0, force, 1000)[:, None]
    RUNS["compiled"](system, motion, STEP, pushes, shape[None], np.zeros((1000, len(system.A))), range(0))
    motion[2], _ = definition.accelerations(system, motion[0], motion[1], 0.0 * shape, np.zeros(len(system.A)))
    start = motion.copy()
    _free_run(system, motion, 3700)
    assert np.abs(motion[0] - start[0]).max() > 0.1 * np.abs(start[0]).max()
    motion[1] *= -1.0
    _free_run(system, motion, 3700)
    assert np.abs(motion[0] - start[0]).max() < 1e-9 * np.abs(start[0]).max()
    assert np.abs(motion[1] + start[1]).max() < 1e-9 * np.abs(start[1]).max()


def _displacements(damping_velocity):
    """A heavily damped case at steps of 80 us, 40 us, ... 5 us, at the same instants."""
    one = case("three", bandwidth_hz=2000.0, duration=0.03, plucks=(ForceRamp("E2", 0.9, 0.0, 0.004, 3.0, 2.0),))
    heavy = replace(one.guitar, body=replace(one.guitar.body, damping_ratios=(0.05,) * 10))
    runs = []
    for k in range(5):
        result = simulate(replace(one, guitar=heavy, step=8e-5 / 2**k), damping_velocity=damping_velocity)
        runs.append(result["displacement"][:: 2**k])
    return runs


def _orders(errors):
    sizes = np.array([np.sqrt(np.mean(np.square(error))) for error in errors])
    return np.log2(sizes[:-1] / sizes[1:])


def test_order_of_the_step_with_losses():
    """Second order with the predicted velocity; what the half-step velocity does differently is first order."""
    predicted, late = _displacements("predicted"), _displacements("half-step")
    limit = (4.0 * predicted[-1] - predicted[-2]) / 3.0
    np.testing.assert_allclose(_orders([run - limit for run in predicted[1:4]]), 2.0, atol=0.2)
    np.testing.assert_allclose(_orders([a - b for a, b in zip(predicted, late, strict=True)])[1:], 1.0, atol=0.2)


def test_constraints_hold_over_the_first_second_of_fig_6():
    """The paper: below 2.0e-13 m."""
    assert simulate(fig_6(record=Record())).facts["largest_drift_m"] < 2e-13


@pytest.mark.parametrize(
    "changes",
    [
        {"step": 5e-5},
        {"finger": "soft", "strings": ("E4",), "plucks": (ForceRamp("E4", 0.9, 0.0, 0.004, 1.0),), "held": E4_HELD},
    ],
    ids=["fastest mode", "damper"],
)
def test_a_step_that_is_too_long_is_refused(changes):
    one = case(**{"record": Record(), **changes})
    with pytest.raises(ParameterError, match="step is"):
        simulate(one)
    simulate(replace(one, step=1e-6))
