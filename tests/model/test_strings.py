"""Strings as modes: Eqs. 19, 48, 49 by hand, statics of a flexible string in closed form, tension modulation against
the integral that it stands for."""

from dataclasses import replace

import numpy as np
import pytest

from ukrt.model.modes import compliance_moments, receptance, static_compliance
from ukrt.model.poles import string_poles
from ukrt.model.presets import load_preset
from ukrt.model.strings import (
    ideal_open_hz,
    mode_count,
    residual_compliance,
    residual_moments,
    retuned,
    string_modes,
    string_modes_range,
)

NO_BODY = {"body": "{frequencies_hz=[], damping_ratios=[], modal_masses=[], shapes_bass=[], shapes_treble=[]}"}


@pytest.fixture(scope="module")
def strings():
    return load_preset("paper").strings


def test_first_mode_of_e2_by_hand(strings):
    modes = string_modes(strings[0], 10e3)
    p = np.pi / 1.3
    omega = np.sqrt(71.6 / 6.24e-3) * p * (1 + 57e-6 * p**2 / (2 * 71.6))
    assert modes.p[0] == pytest.approx(p, rel=1e-15)
    assert modes.omega[0] == pytest.approx(omega, rel=1e-15)
    assert omega / (2 * np.pi) == pytest.approx(41.2, abs=0.01)  # "41 Hz" in the paper, Sec. IV B
    zeta = 0.5 * (71.6 * (2e-5 + 1.2 / omega) + 0.02 * 57e-6 * p**2) / (71.6 + 57e-6 * p**2)
    assert modes.zeta[0] == pytest.approx(zeta, rel=1e-14)
    assert modes.mass[0] == pytest.approx(6.24e-3 * 0.65 / 2, rel=1e-15)


def test_modes_are_all_up_to_the_bandwidth_and_none_above(strings):
    for string in strings:
        for hz in (50.0, 1e3, 9999.9, 20e3, 400e3):
            count = mode_count(string, hz)
            everything = string_modes(string, 2 * hz + 500.0).omega / (2 * np.pi)
            assert count == np.count_nonzero(everything <= hz)


def test_ranges_join_without_gap_or_overlap(strings):
    for string in strings:
        joined = np.concatenate([string_modes(string, 7e3).omega, string_modes_range(string, 7e3, 90e3).omega])
        np.testing.assert_array_equal(joined, string_modes(string, 90e3).omega)


def test_open_frequencies_are_those_of_the_source(strings):
    found = [ideal_open_hz(string) for string in strings]
    np.testing.assert_allclose(found, [82.40, 110.06, 146.99, 195.78, 246.50, 330.86], atol=0.006)


def test_strings_agree_with_the_published_table(shared_data, strings):
    rows = np.genfromtxt(shared_data / "strings.csv", delimiter=",", skip_header=1)[:, 1:]
    scale = np.array([1, 1e-3, 1e-6, 1e-5, 1, 1e-2])
    names = ("tension", "linear_density", "bending_stiffness", "loss_internal", "loss_air", "loss_bending")
    found = [[getattr(string, name) for name in names] for string in strings]
    np.testing.assert_allclose(found, rows * scale, rtol=1e-12)


def test_a_rigid_bridge_acts_as_a_clamped_end(strings):
    """The basis has no slope at the bridge, so the string seems shorter there (about sqrt(B/T)): 82.52 Hz for E2.

    To first order the length that is left is what statics shows: tension times the compliance of the end.
    """
    guitar = load_preset("paper", NO_BODY)
    pole = string_poles(guitar, [s.tension for s in strings], 0, None, 1)[0]
    string = strings[0]
    modes = string_modes(string, 400e3)
    left = string.tension * static_compliance(modes, modes.shape([0.65]))[0, 0]
    assert string.length - left == pytest.approx(np.sqrt(string.bending_stiffness / string.tension), rel=0.1)
    assert pole.imag / (2 * np.pi) == pytest.approx(string.wave_speed / (2 * left), rel=1e-5)
    assert pole.imag / (2 * np.pi) == pytest.approx(82.52, abs=0.005)


def test_residual_of_a_flexible_string_is_what_statics_lacks(strings):
    """Static compliance of a flexible string, pinned at one end, between x and y: min(x, y) / T."""
    string = replace(strings[5], bending_stiffness=0.0)
    places = np.array([0.65, 0.2, 0.35])
    kept = string_modes(string, 10e3)
    static, inertial = residual_compliance(string, 10e3, places, reference_hz=2e9)
    known = np.minimum.outer(places, places) / string.tension - static_compliance(kept, kept.shape(places))
    np.testing.assert_allclose(static, known, atol=1e-5 * known[0, 0])  # what lies above 2 GHz
    # at the bridge the sum over odd squares starts after the kept modes
    odd = 2.0 * np.arange(1, kept.count + 1) - 1.0
    tail = 8 * string.length / (np.pi**2 * string.tension) * (np.pi**2 / 8 - np.sum(1 / odd**2))
    assert static[0, 0] == pytest.approx(tail, rel=1e-5)
    odd_tail = np.pi**4 / 96 - np.sum(1 / odd**4)
    scale = 2 / (string.linear_density * string.length) * (2 * string.length / (np.pi * string.wave_speed)) ** 4
    assert inertial[0, 0] == pytest.approx(scale * odd_tail, rel=1e-7)


def test_moments_continue_the_residual(strings):
    undamped = replace(strings[3], loss_internal=0.0, loss_air=0.0, loss_bending=0.0)
    places = np.array([0.65, 0.3])
    static, inertial = residual_compliance(undamped, 10e3, places)
    moments = residual_moments(undamped, 10e3, places)
    np.testing.assert_allclose(moments[0], static, rtol=1e-14)
    np.testing.assert_allclose(-moments[2], inertial, rtol=1e-14)
    np.testing.assert_array_equal(moments[1::2], 0.0)


@pytest.mark.parametrize("hz", [200.0, 2000.0])
def test_moments_stand_for_damped_modes_far_above(strings, hz):
    modes = string_modes_range(strings[3], 10e3, 400e3)
    phi, s = modes.shape([0.65, 0.3]), np.array([-5.0 + 2j * np.pi * hz])
    series = sum(m * s[0] ** j for j, m in enumerate(compliance_moments(modes, phi, 6)))
    exact = receptance(modes, phi, s)[0]
    assert np.max(np.abs(series - exact)) < 2 * (hz / 10e3) ** 7 * np.max(np.abs(exact)) + 1e-15


def test_tension_rise_is_the_integral_of_the_squared_slope(strings):
    modes = string_modes(strings[0], 2e3)
    rng = np.random.default_rng(1)
    q_y, q_z = rng.normal(size=(2, modes.count)) * 1e-3 / modes.p
    x = np.linspace(0, 0.65, 20001)
    slopes = [(q * modes.p) @ np.cos(np.outer(modes.p, x)) for q in (q_y, q_z)]
    integral = np.trapezoid(slopes[0] ** 2 + slopes[1] ** 2, x)
    rise = modes.tension_rise(q_y, q_z)
    assert rise == pytest.approx(3200.0 / 1.3 * integral, rel=1e-8)
    # Eq. 20: f_n = -(ES pi^4 / 128 L^3) (2n-1)^2 q_n sum (2m-1)^2 (q_Y^2 + q_Z^2)
    odd = 2.0 * np.arange(1, modes.count + 1) - 1.0
    force = -3200.0 * np.pi**4 / (128 * 0.65**3) * odd**2 * q_y * np.sum(odd**2 * (q_y**2 + q_z**2))
    np.testing.assert_allclose(modes.tension_force(q_y, q_z), force, rtol=1e-12)


def test_retuned_moves_a_flexible_string_by_that_many_cents(strings):
    higher = retuned(strings[2], 37.0)
    assert 1200 * np.log2(ideal_open_hz(higher) / ideal_open_hz(strings[2])) == pytest.approx(37.0, abs=1e-9)
