"""Body at the bridge and the dense constrained system: Table I, interpolation over the bridge, rows of Eqs. 21-47."""

import numpy as np
import pytest

from ukrt.model.body import body_modes, bridge_shapes, end_weights
from ukrt.model.constraints import dense_system
from ukrt.model.contacts import HeldPoint, held_by_damper, held_by_finger
from ukrt.model.presets import load_preset
from ukrt.model.strings import string_modes

TABLE_I = """
89.4 1.50 0.40
182.6 1.82 0.08
229.9 0.64 0.20
310.2 0.89 0.47
403.5 0.55 1.06
511.4 0.75 0.58
544.2 0.53 1.82
613.9 0.61 0.69
669.8 0.69 0.38
848.4 0.59 0.81
"""


@pytest.fixture(scope="module")
def paper():
    return load_preset("paper")


def test_body_of_the_paper_is_table_one(paper):
    table = np.array(TABLE_I.split(), float).reshape(-1, 3)
    modes = body_modes(paper.body)
    np.testing.assert_allclose(modes.omega, 2 * np.pi * table[:, 0], rtol=1e-12)
    np.testing.assert_allclose(modes.zeta, table[:, 1] / 100, rtol=1e-12)
    np.testing.assert_allclose(modes.mass, table[:, 2], rtol=1e-12)


@pytest.mark.parametrize("name", ["paper", "classical", "drop-d"])
def test_shapes_are_normalised_over_the_six_bridge_points(name):
    shapes = bridge_shapes(load_preset(name))
    assert shapes.shape == (6, 10)
    np.testing.assert_allclose(np.max(np.abs(shapes), axis=0), 1.0, rtol=1e-12)


def test_shape_ratios_of_the_paper_preset_are_those_of_the_nearest_measured_modes(paper, shared_data):
    hz, _, ratio = np.genfromtxt(shared_data / "bridge_modes_1978_classical.csv", delimiter=",", skip_header=1).T
    body = paper.body
    nearest = [ratio[np.argmin(np.abs(hz - f))] for f in body.frequencies_hz]
    found = np.array(body.shapes_treble) / np.array(body.shapes_bass)
    np.testing.assert_allclose(found, nearest, atol=2e-3)


def test_bridge_points_interpolate_linearly(paper):
    shapes = bridge_shapes(paper)
    np.testing.assert_allclose(shapes[0], paper.body.shapes_bass)
    np.testing.assert_allclose(shapes[-1], paper.body.shapes_treble)
    np.testing.assert_allclose(np.diff(shapes, n=2, axis=0), 0.0, atol=1e-14)
    np.testing.assert_allclose(end_weights(np.linspace(0, 1, 7)).sum(axis=1), 1.0, rtol=1e-15)


def test_rows_are_those_of_the_paper(paper):
    """12 bridge rows, one row a contact and polarization; columns [q_Y, q_Z, q_B, q_FY, q_FZ]."""
    held = [()] * 6
    held[1] = (HeldPoint(0.1, mass=5e-3, damping=1.0, stiffness=1e6), HeldPoint(0.09, rigid=True))
    held[4] = (HeldPoint(0.55, damping=0.3),)
    system = dense_system(paper, held, 1500.0)
    counts = [string_modes(s, 1500.0).count for s in paper.strings]
    assert system.A.shape == (12 + 4, 2 * sum(counts) + 10 + 2)
    assert np.linalg.matrix_rank(system.A) == 16
    shapes = bridge_shapes(paper)
    for n, row in enumerate(system.A[:6]):
        signs = (-1.0) ** np.arange(counts[n])  # sin((2n - 1) pi / 2)
        np.testing.assert_allclose(row[system.strings_y[n]], signs, atol=1e-12)
        np.testing.assert_array_equal(row[system.body], -shapes[n])
        assert np.count_nonzero(row) == counts[n] + 10
    for n, row in enumerate(system.A[6:12]):
        assert np.count_nonzero(row) == counts[n]
        assert np.count_nonzero(row[system.strings_z[n]]) == counts[n]
    oscillator_y, rigid_y, oscillator_z, rigid_z = system.A[12:]
    phi = string_modes(paper.strings[1], 1500.0).shape([0.1, 0.09])
    np.testing.assert_allclose(oscillator_y[system.strings_y[1]], phi[0])
    np.testing.assert_allclose(rigid_z[system.strings_z[1]], phi[1])
    assert oscillator_y[system.fingers_y] == oscillator_z[system.fingers_z] == -1.0
    assert not np.any(rigid_y[system.fingers_y]) and not np.any(rigid_z[system.fingers_z])


def test_a_pure_damper_takes_power_where_it_touches_and_only_there(paper):
    place, damping = 0.55, 0.3
    touch = HeldPoint(place, damping=damping)
    free, damped = (dense_system(paper, [held] + [()] * 5, 1500.0) for held in ((), (touch,)))
    added = damped.damping - free.damping
    np.testing.assert_array_equal(free.A, damped.A)
    velocity = np.random.default_rng(3).normal(size=len(free.mass))
    phi = string_modes(paper.strings[0], 1500.0).shape(place)
    at_place = [phi @ velocity[where[0]] for where in (free.strings_y, free.strings_z)]
    assert velocity @ added @ velocity == pytest.approx(damping * np.sum(np.square(at_place)), rel=1e-12)


def test_held_points_follow_finger_and_damper():
    guitar = load_preset("classical")
    points = held_by_finger(guitar.finger, 0.2)
    np.testing.assert_allclose([p.place for p in points], [0.2, 0.196, 0.192])
    assert [p.stiffness for p in points] == [1e6, 1e4, 1e4]
    assert all(p.has_mode and not p.is_damper for p in points)
    string = guitar.strings[0]
    for point, place in zip(held_by_damper(guitar.damper, string), guitar.damper.places, strict=True):
        assert point.is_damper
        assert point.place == place * string.length
        impedance = np.sqrt(string.tension * string.linear_density)
        assert point.damping == pytest.approx(guitar.damper.damping_ratio * impedance)


def test_receptance_of_held_points():
    s = -3.0 + 700j
    assert HeldPoint(0.1, rigid=True).receptance(s) == 0.0
    assert HeldPoint(0.1, damping=2.0).receptance(s) == pytest.approx(1 / (2 * s))
    assert HeldPoint(0.1, 5e-3, 1.0, 1e6).receptance(s) == pytest.approx(1 / (5e-3 * s**2 + s + 1e6))
