"""The closed forms beside the figures, against each other, limits that are known, and the solver."""

from dataclasses import replace

import numpy as np
import pytest

from ukrt.figures.cases import paper_guitar
from ukrt.figures.figure_02 import impulse_response, transfer_function
from ukrt.figures.figure_06 import after_release, oblique_case
from ukrt.figures.figure_08 import pluck_case
from ukrt.figures.plucked import (
    first_order_shift,
    held_fundamental,
    ramp_work,
    static_tension_rise,
    static_work,
)
from ukrt.figures.runs import Run

E2 = paper_guitar().strings[0]
SPAN, PLACE = (0.2509 * E2.length, E2.length), 0.9 * E2.length


def test_a_slow_ramp_does_the_work_of_a_slow_force():
    slow = static_work(E2, SPAN, PLACE, 2.0)
    assert ramp_work(E2, SPAN, PLACE, 2.0, 10.0) == pytest.approx(slow, rel=1e-3)


def test_a_sudden_ramp_works_against_the_wave_impedance():
    """Before any wave is back, the string gives way with v = F / (2 Z): the work is the integral of F^2 / (2 Z)."""
    force, duration = 2.0, 2e-4
    expected = force**2 * duration / 3.0 / (2.0 * E2.wave_impedance)
    assert ramp_work(E2, SPAN, PLACE, force, duration) == pytest.approx(expected, rel=1e-3)


def test_runs_of_a_flexible_string_converge_to_the_closed_form():
    """Rigid bridge, stiff fret: what is missing falls as one over the bandwidth."""
    guitar = paper_guitar()
    flexible = replace(guitar, strings=(replace(E2, bending_stiffness=0.0),))
    expected, missing = ramp_work(E2, SPAN, PLACE, np.sqrt(5.0), 0.01), []
    for bandwidth_hz in (10e3, 20e3):
        wide = replace(flexible, basis=replace(guitar.basis, bandwidth_hz=bandwidth_hz))
        result = Run()(replace(oblique_case("short", False, wide, 0.02), bridge="rigid"))
        total = result.column("energies", "total")[after_release(result)]
        missing.append(1.0 - np.mean(total) / expected)
    assert 0.0 < missing[1] < 0.6 * missing[0] < 0.02
    assert abs(2.0 * missing[1] - missing[0]) < 3e-3


def test_the_largest_tension_is_that_of_the_string_bent_slowly():
    result = Run()(pluck_case(5.0, duration=0.1))
    rise = np.max(result["tension"][:, 0]) - E2.tension
    assert rise == pytest.approx(static_tension_rise(E2, 0.9, 5.0), rel=0.05)


@pytest.mark.parametrize("bandwidth_hz", [5e3, 10e3, 40e3])
def test_a_held_flexible_string_nears_its_own_fundamental_from_above(bandwidth_hz):
    flexible = replace(E2, bending_stiffness=0.0)
    ideal = E2.wave_speed / (2.0 * E2.length)
    above, nearer = (held_fundamental(flexible, hz) - ideal for hz in (bandwidth_hz, 2.0 * bandwidth_hz))
    assert above > 0.0
    assert nearer == pytest.approx(above / 2.0, rel=0.05)  # the compliance that is missing falls as 1 / bandwidth


def test_a_stiff_string_is_clamped_at_the_bridge():
    """A string shorter by the length sqrt(B / T0) in which a clamped end bends."""
    ideal = E2.wave_speed / (2.0 * E2.length)
    bend = np.sqrt(E2.bending_stiffness / E2.tension)
    assert held_fundamental(E2, 1e6) == pytest.approx(ideal * E2.length / (E2.length - bend), abs=0.01)


def test_first_order_shift_of_one_mode_is_that_of_the_duffing_oscillator():
    """Plucked where V1 / V is known: the share of mode 1 in the middle is 8 / pi^2, and of modes that sum to V."""
    mean, share = 0.5 * static_tension_rise(E2, 0.5, 1.0), 8.0 / np.pi**2
    expected = E2.wave_speed / (2.0 * E2.length) * mean * (1.0 + 0.5 * share) / (2.0 * E2.tension)
    assert first_order_shift(E2, 0.5, 1.0) == pytest.approx(expected)
    p, n = 0.37, np.arange(1, 200001)
    static = np.sin(n * np.pi * p) ** 2 / n**2  # (n q_n)^2 of the bent string
    shift = first_order_shift(E2, p, 1.0) / (E2.wave_speed / (2.0 * E2.length)) * 2.0 * E2.tension
    mean = 0.5 * static_tension_rise(E2, p, 1.0)
    assert shift / mean - 1.0 == pytest.approx(0.5 * static[0] / np.sum(static), rel=1e-4)


def test_the_transfer_function_is_the_transform_of_the_impulse_response():
    body, rate = paper_guitar().body, 40e3
    times = np.arange(0.0, 4.0, 1.0 / rate)
    response = impulse_response(body, times)
    response[0] *= 0.5  # trapezoidal rule
    frequencies = np.fft.rfftfreq(len(times), 1.0 / rate)
    heard = (frequencies > 50.0) & (frequencies < 950.0)
    found = np.fft.rfft(response)[heard] / rate
    expected = transfer_function(body, frequencies[heard])
    assert np.max(np.abs(found - expected)) < 2e-3 * np.max(np.abs(expected))
