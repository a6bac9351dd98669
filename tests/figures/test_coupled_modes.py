"""Modes of a finger on a string against closed forms of two degrees of freedom, and against each other."""

from dataclasses import replace

import numpy as np
import pytest

from ukrt.experiment.case import Case, HeldString
from ukrt.figures.cases import paper_guitar, with_contacts
from ukrt.figures.coupled_modes import coupled_modes
from ukrt.figures.stopped_string import READINGS, oscillator, partials, stopped_case
from ukrt.model.parameters import Basis, Contact
from ukrt.model.strings import string_modes

PLACE = 0.37  # of L


def three_mode_case(contact):
    """A string so short that three modes lie within the basis, held by one contact, on a rigid bridge."""
    guitar = with_contacts(paper_guitar(), contact)
    string = replace(guitar.strings[0], length=0.15)
    guitar = replace(guitar, strings=(string, *guitar.strings[1:]), basis=Basis(1000.0))
    return Case("few", 1.0, guitar, strings=("E2",), bridge="rigid", held=(HeldString("E2", PLACE),))


def two_degrees(case, mass, stiffness):
    """Squared frequencies by hand: q1 - q2 + q3 = 0 at the bridge leaves q1 and q2, the finger moves u q1 + v q2."""
    string = case.instrument.strings[0]
    modes = string_modes(string, 1000.0)
    assert modes.count == 3
    m, (k1, k2, k3) = modes.mass[0], modes.mass * modes.omega**2
    s1, s2, s3 = modes.shape(PLACE * string.length)
    u, v = s1 - s3, s2 + s3
    m11, m12, m22 = 2 * m + mass * u * u, -m + mass * u * v, 2 * m + mass * v * v
    k11, k12, k22 = k1 + k3 + stiffness * u * u, -k3 + stiffness * u * v, k2 + k3 + stiffness * v * v
    a, c = m11 * m22 - m12**2, k11 * k22 - k12**2
    b = m11 * k22 + m22 * k11 - 2 * m12 * k12
    root = np.sqrt(b * b - 4 * a * c)
    return np.array([(b - root) / (2 * a), (b + root) / (2 * a)])


@pytest.mark.parametrize("stiffness", [1e3, 1e5, 1e7])
def test_finger_and_string_move_as_two_degrees_of_freedom_do(stiffness):
    case = replace(three_mode_case(oscillator(stiffness, 0.0)), losses=False)
    found = coupled_modes(case).poles
    assert found.imag**2 == pytest.approx(two_degrees(case, 5e-3, stiffness), rel=1e-9)
    assert np.abs(found.real).max() < 1e-6 * found.imag.min()


def test_a_damper_adds_half_the_trace_of_its_loss_to_the_decay_of_all_modes():
    # M^-1 C of the free coordinates has the trace c n^T M^-1 n, by hand: 1 / (m + the string's mass at the contact).
    free, damped = (coupled_modes(stopped_case("x", [oscillator(1e5, c)])) for c in (0.0, 7.0))
    string = damped.first_string
    phi, end = string.shape(READINGS["0.1857 m"] * 0.65), string.shape(0.65)
    yielding = phi @ phi - (phi @ end) ** 2 / (end @ end)  # of the modes, the bridge held
    moving = string.mass[0] / yielding
    added = np.sum(free.poles.real) - np.sum(damped.poles.real)
    assert added == pytest.approx(7.0 / (2.0 * (5e-3 + moving)), rel=1e-6)


def test_an_endlessly_stiff_light_finger_is_a_rigid_contact():
    stiff = coupled_modes(stopped_case("x", [Contact(0.0, 1e-5, 0.0, 1e8)]))
    rigid = coupled_modes(stopped_case("x", [Contact(0.0, rigid=True)]))
    assert stiff.frequencies[:20] == pytest.approx(rigid.frequencies[:20], rel=1e-4)
    assert np.argmax(stiff.likeness(rigid)[:20, :20], axis=0).tolist() == list(range(20))


def test_partials_of_the_stopped_length_are_found_among_those_behind_the_finger():
    case = stopped_case("x", [Contact(0.0, rigid=True)], 0.3)
    modes = coupled_modes(case)
    hz = modes.frequencies[partials(case, modes, 6)]
    string = case.instrument.strings[0]
    assert hz / np.arange(1, 7) == pytest.approx(string.wave_speed / (2 * 0.7 * 0.65), rel=6e-3)
    assert modes.share_between(0.0, 0.3 * 0.65)[partials(case, modes, 3)].max() < 0.05


def test_the_finger_has_nearly_all_of_its_mode_where_the_string_is_far_from_resonance():
    heavy = coupled_modes(stopped_case("x", [Contact(0.0, 0.5, 0.0, 1e5)]))
    own = np.argmax(heavy.finger_share)
    assert heavy.finger_share[own] > 0.99
    assert heavy.frequencies[own] == pytest.approx(np.sqrt(1e5 / 0.5) / (2 * np.pi), rel=5e-3)
