"""The oracle's admittances proven by closed forms, reciprocity, their own poles, and energy."""

import numpy as np
import pytest

from .admittance import OnBridge, OnString, admittance, admittance_residues, bridge_forces
from .constants import BODY, STRINGS, ContactData, StringData, make_guitar
from .continuous import body_modes, make_system, poles, string_modes
from .partials import string_partials
from .test_oracle import UNEVEN, dense_poles, fretted, tail_compliance

IDEAL = StringData("ideal", 0.65, 71.6, 6.24e-3, 0.0, 0.0, 0.0, 0.0, 0.3)
S = 2j * np.pi * np.array([55.0, 131.3, 410.0, 1009.0, 2222.2]) + np.array([4.0, -3.0, 10.0, 40.0, -20.0])


def wavenumber(string, s):
    return -1j * s / np.sqrt(string.tension / string.linear_density)


def missing(system, n):
    """Static compliance at the bridge of an ideal string's modes beyond the oracle's [m/N]."""
    return tail_compliance(system.strings[n], string_modes(system.strings[n], system.cut_hz)[0].size)


def test_string_between_rigid_ends():
    """sin k x sin k (L - x') / (T k sin k L) between two points, with L shorter by the compliance beyond 400 kHz."""
    system = make_system(make_guitar([IDEAL], None))
    k, x, y = wavenumber(IDEAL, S), 0.17, 0.52
    length = 0.65 - IDEAL.tension * missing(system, 0)
    for place in (x, y):
        closed = np.sin(k * place) * np.sin(k * (length - y)) / (IDEAL.tension * k * np.sin(k * length))
        if place == y:  # sin^2 of the modes that are not there averages to half of what it is at the bridge
            closed = closed - 0.5 * missing(system, 0)
        assert np.allclose(admittance(system, OnString(0, place), OnString(0, y), S), S * closed, rtol=1e-4)


def test_impedances_add_at_the_bridge():
    """Where all strings meet one point of the body its impedance is the body's plus T k cot(k L) / s of each."""
    strings = [StringData("a", 0.65, 71.6, 6.24e-3, 0, 0, 0, 0, 0.5), StringData("b", 0.6, 60.0, 9e-4, 0, 0, 0, 0, 0.5)]
    omega2, loss, mass, _ = body_modes(BODY, (0.5,))
    body = np.sum(1.0 / (mass * (S[:, None] ** 2 + loss * S[:, None] + omega2)), axis=1)
    stiffness, system = 1.0 / body, make_system(make_guitar(strings, BODY))
    for string in strings:
        k, n = wavenumber(string, S), strings.index(string)
        stiffness += 1.0 / (np.tan(k * string.length) / (string.tension * k) - missing(system, n))
    found = admittance(system, OnBridge(0.5), OnBridge(0.5), S)
    assert np.allclose(found, S / stiffness, rtol=1e-7)
    alone = make_system(make_guitar([], BODY))
    assert np.allclose(admittance(alone, OnBridge(0.5), OnBridge(0.5), S), S * body, rtol=1e-12)


def guitar_system(**options):
    return make_system(make_guitar(STRINGS, UNEVEN), {0: fretted(5, 3), 4: fretted(2, 1)}, **options)


def test_reciprocity():
    """Swap pluck and pick-up, on strings, between them and across the bridge: the same to round-off."""
    system = guitar_system()
    points = [OnString(0, 0.6), OnString(0, 0.1), OnString(5, 0.33), OnBridge(0.0), OnBridge(0.7)]
    for n, a in enumerate(points):
        for b in points[:n]:
            there, back = admittance(system, a, b, S), admittance(system, b, a, S)
            assert np.max(np.abs(there / back - 1.0)) < 1e-7, (a, b)


def test_constraints_hold():
    """The string's end moves as the body does; a rigid contact does not move; nothing depends on which is driven."""
    strings = STRINGS[2:4]
    system = make_system(make_guitar(strings, UNEVEN), {1: (ContactData(0.2, rigid=True),)})
    end, bridge, held = OnString(0, 0.65), OnBridge(strings[0].bridge_position), OnString(1, 0.2)
    driven = OnString(1, 0.5)
    reference = admittance(system, bridge, driven, S)
    assert np.allclose(admittance(system, end, driven, S), reference, rtol=1e-7)
    assert np.allclose(admittance(system, end, end, S), admittance(system, bridge, bridge, S), rtol=1e-6)
    moved = np.abs(admittance(system, held, driven, S))
    assert np.all(moved < 1e-9 * np.abs(admittance(system, driven, driven, S)))


def test_newton_s_law_on_the_body():
    """The body moves by the strings' forces alone: Y at the bridge is the free body's mobility times them."""
    system, driven = guitar_system(), OnString(0, 0.55)
    positions = tuple(string.bridge_position for string in system.strings)
    omega2, loss, mass, shapes = body_modes(system.body, (0.25, *positions))
    inverse = 1.0 / (mass * (S[:, None] ** 2 + loss * S[:, None] + omega2))
    mobility = S[:, None] * np.einsum("n,kn,sn->ks", shapes[0], inverse, shapes[1:])
    moved = np.sum(mobility * bridge_forces(system, driven, S), axis=1)
    assert np.allclose(admittance(system, OnBridge(0.25), driven, S), moved, rtol=1e-8)


def test_driving_points_take_energy():
    """Re Y > 0 on the imaginary axis at any point of a passive system."""
    s = 2j * np.pi * np.linspace(60.0, 3000.0, 701)
    for point in (OnString(0, 0.6), OnString(4, 0.03), OnBridge(0.1)):
        assert np.min(admittance(guitar_system(), point, point, s).real) > 0.0


@pytest.mark.parametrize("points", [(OnBridge(0.4), OnBridge(0.4)), (OnBridge(0.0), OnString(1, 0.5))])
def test_residues_make_up_the_admittance(points):
    """20 modes a string: the sum of residue / (s - pole) over all poles, from dense eigenvalues, is Y / s times s."""
    contacts = {1: (ContactData(0.24, 5e-3, 1.0, 1e5),)}
    system = make_system(make_guitar(STRINGS[:2], UNEVEN), contacts, n_modes=20)
    found = dense_poles(system.strings, system.contacts, system.body, 20)
    residues = admittance_residues(system, *points, found) / found  # of the displacement, which falls as 1 / s^2
    pairs = residues / (S[:, None] - found) + residues.conj() / (S[:, None] - found.conj())
    assert np.allclose(np.sum(pairs, axis=1) * S, admittance(system, *points, S), rtol=1e-6)


def test_a_pole_is_where_the_admittance_is_infinite():
    """(s - p) Y(s) tends to the residue, at poles of the whole system with all its modes."""
    system = guitar_system()
    found = string_partials(system, 0, 3)
    points = OnBridge(0.2), OnString(0, 0.6)
    residues = admittance_residues(system, *points, found)
    near = 1e-5 * (1.0 + 1.0j)
    mean = 0.5 * near * (admittance(system, *points, found + near) - admittance(system, *points, found - near))
    assert np.allclose(mean, residues, rtol=1e-5)


def test_steps_of_verlet_detune_by_the_closed_form():
    """Without losses a step of h turns every omega into 2 / h asin(omega h / 2), whatever the constraints."""
    lossless = [StringData(s.name, s.length, s.tension, s.linear_density, s.bending_stiffness, 0, 0, 0, 0.2)
                for s in STRINGS[:2]]
    body = type(BODY)(BODY.frequencies_hz, (0.0,) * 10, BODY.modal_masses, BODY.shapes_bass, BODY.shapes_treble)
    contacts = {0: (ContactData(0.2, 5e-3, 0.0, 1e6), ContactData(0.19, rigid=True))}
    for step in (1e-5, 4e-5):
        omega = string_partials(make_system(make_guitar(lossless, body), contacts, n_modes=40), 0, 8).imag
        stepped = make_system(make_guitar(lossless, body), contacts, n_modes=40, step=step)
        found = poles(stepped, 1j * omega * (1.0 + (omega * step) ** 2 / 24.0))
        assert np.max(np.abs(found - 2j / step * np.arcsin(0.5 * step * omega))) < 1e-6
