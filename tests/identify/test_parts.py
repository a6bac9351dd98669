"""The parts of the identification by themselves: poles from exact decays, tracks, strengths, shapes, hanging masses."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from identify.bridge_responses import admittance, as_measurement, impulse_responses, measure, table_i

from ukrt.errors import ParameterError
from ukrt.identify import axial_stiffness
from ukrt.identify.realization import Poles, realize
from ukrt.identify.residues import fit_complex_strengths, fit_strengths, make_band
from ukrt.identify.shapes import real_shapes
from ukrt.identify.stabilization import mac, stable_tracks, track_poles


def test_realization_is_exact_at_the_order_of_the_system():
    poles = np.array([-10 + 400j, -20 + 900j, -5 + 1500j])
    shapes = np.array([[1.0, 0.5], [1.0, -0.7], [0.2, 1.0]])
    t = np.arange(400) / 1000.0
    markov = 2 * np.einsum("nt,ni,nj->tij", np.exp(poles[:, None] * t), shapes, shapes).real
    (found,) = realize(markov, 1000.0, [6])
    order = np.argsort(found.values.imag)
    assert found.values[order] == pytest.approx(poles, rel=1e-9)
    assert mac(found.shapes[order], shapes) == pytest.approx(1.0, abs=1e-9)


def test_realization_of_one_order_does_not_depend_on_the_others():
    markov = np.random.default_rng(0).standard_normal((300, 2, 2))
    alone, among = realize(markov, 1000.0, [8])[0], realize(markov, 1000.0, [4, 8, 20])[1]
    assert among.order == 8
    assert np.sort_complex(among.values) == pytest.approx(np.sort_complex(alone.values), rel=1e-6)


def test_mac():
    shape = np.array([1.0 + 1j, 2.0, -0.3])
    assert mac(shape, 3j * shape) == pytest.approx(1.0)
    assert mac(np.array([1.0, 1.0]), np.array([1.0, -1.0])) == pytest.approx(0.0)


def test_tracks_tell_what_repeats_from_what_wanders():
    rng, sweep = np.random.default_rng(0), []
    for n in range(20):
        steady = -10 + 1000j + 0.1 * rng.standard_normal()
        wandering = -10 + 1j * rng.uniform(1200, 6000)
        undamped_backwards = 5 + 800j
        poles = np.array([wandering, steady, undamped_backwards])
        sweep.append(Poles(2 * n, poles, np.array([[1.0, 1.0], [1.0, 0.5], [1.0, 0.0]], complex)))
    (track,) = stable_tracks(track_poles(sweep), len(sweep))
    assert len(track.orders) == 20
    assert track.median == pytest.approx(-10 + 1000j, abs=0.1)


def test_a_change_of_shape_ends_a_track():
    def order(n):
        shape = [1.0, 1.0] if n < 10 else [1.0, -1.0]
        return Poles(2 * n, np.array([-10 + 1000j]), np.array([shape], complex))

    assert [len(track.orders) for track in track_poles([order(n) for n in range(20)])] == [10, 10]


@pytest.mark.parametrize("quantity", ["displacement", "velocity"])
def test_strengths_are_exact_for_exact_poles(quantity):
    modes = table_i()
    omega = 2 * np.pi * modes.hz
    poles = omega * (-modes.zeta + 1j * np.sqrt(1 - modes.zeta**2))
    measurement = as_measurement(impulse_responses(modes, quantity, 8000, 0.3), quantity=quantity, rate=8000)
    band = make_band(measurement, 40.0, 1000.0)  # a record that ends while modes still ring
    wanted = np.stack(
        [modes.shapes[:, i] * modes.shapes[:, j] / modes.mass for i, j in ((0, 0), (0, 1), (1, 1))], axis=1
    )
    found = fit_strengths(band, poles)
    assert found.values == pytest.approx(wanted, rel=1e-6)
    assert found.fitted == pytest.approx(band.values, abs=1e-9 * np.abs(band.values).max())
    assert fit_complex_strengths(band, poles)[0] == pytest.approx(wanted, rel=1e-5)


def test_spectra_are_admittances():
    modes = table_i()
    frequencies, values = measure(modes, decibels=300.0).spectra()
    inside = (frequencies > 50) & (frequencies < 900)
    for n, (drive, response) in enumerate(((0, 0), (0, 1), (1, 1))):
        exact = admittance(modes, frequencies[inside], drive, response)
        # a sample at t = 0 counts whole in the sum and half in the integral: the difference is a constant
        pulse = np.sum(modes.shapes[:, drive] * modes.shapes[:, response] / modes.mass) / 2 / 48000
        assert values[inside, n] == pytest.approx(exact + pulse, abs=2e-4 * np.abs(exact).max())


@given(st.floats(-1, 1), st.floats(-1, 1), st.floats(0.05, 5))
def test_real_shapes_undo_their_products(bass, treble, mass):
    top = bass if abs(bass) >= abs(treble) else treble
    if abs(top) < 0.1 or min(abs(bass), abs(treble)) < 1e-3:
        return
    shape = np.array([bass, treble]) / top
    whole = np.array([[shape[0] ** 2, shape[0] * shape[1], shape[1] ** 2]]) / mass
    for names, columns in (
        (("bass-bass", "bass-treble", "treble-treble"), [0, 1, 2]),
        (("treble-bass", "bass-bass"), [1, 0]),
        (("treble-treble", "bass-treble"), [2, 1]),
    ):
        found = real_shapes(whole[:, columns], names)
        assert found.masses[0] == pytest.approx(mass, rel=1e-6)
        assert found.ends[0] == pytest.approx(shape, rel=1e-6)


def test_no_mass_for_a_driving_point_that_moves_the_wrong_way():
    for names, values in (
        (("bass-bass",), [[-1.0]]),
        (("bass-bass", "bass-treble", "treble-treble"), [[-1.0, -1.0, -1.0]]),
    ):
        assert np.isnan(real_shapes(np.array(values), names).masses[0])


def exact_frequency(stiffness, length, mass, string_mass):
    """Of a bar with a load, from x tan x = m / M by bisection; omega = (x / L) sqrt(ES L / m)."""
    low, high = 0.0, math.pi / 2
    for _ in range(200):
        x = (low + high) / 2
        low, high = (x, high) if x * math.tan(x) < string_mass / mass else (low, x)
    return low / length * math.sqrt(stiffness * length / string_mass) / (2 * math.pi)


def test_axial_stiffness_of_a_hanging_mass():
    frequency = math.sqrt(3200.0 / (0.65 * 0.5)) / (2 * math.pi)
    assert axial_stiffness(frequency, 0.65, 0.5).newtons == pytest.approx(3200.0, rel=1e-12)
    for string_mass in (0.004, 0.05):
        frequency = exact_frequency(3200.0, 0.65, 0.5, string_mass)
        ratio = string_mass / 0.5
        corrected = axial_stiffness(frequency, 0.65, 0.5, string_mass=string_mass).newtons
        assert 0.5 * ratio**2 / 45 < 1.0 - corrected / 3200.0 < ratio**2 / 45
        assert axial_stiffness(frequency, 0.65, 0.5).newtons == pytest.approx(3200.0 / (1 + ratio / 3), rel=ratio**2)


def test_uncertainty_of_axial_stiffness_is_that_of_many_trials():
    rng, means = np.random.default_rng(0), np.array([15.8, 0.65, 0.5, 0.03])
    own = np.array([0.05, 0.003, 0.004, 0.006])
    trials = [
        axial_stiffness(*one[:3], string_mass=one[3]).newtons for one in means + own * rng.standard_normal((4000, 4))
    ]
    names = ("frequency_error", "length_error", "mass_error", "string_mass_error")
    found = axial_stiffness(*means[:3], string_mass=means[3], **dict(zip(names, own, strict=True)))
    assert found.uncertainty == pytest.approx(np.std(trials), rel=0.05)
    assert axial_stiffness(*means[:3]).uncertainty == 0.0


@pytest.mark.parametrize(
    "key,value", [("mass", 0.0), ("frequency_hz", -1.0), ("length", math.nan), ("string_mass", -1e-3)]
)
def test_axial_stiffness_refuses(key, value):
    with pytest.raises(ParameterError, match=key):
        axial_stiffness(**({"frequency_hz": 10.0, "length": 0.65, "mass": 0.5} | {key: value}))
