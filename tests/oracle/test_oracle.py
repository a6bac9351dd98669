"""The oracle proven by other routes: closed forms of strings, dense eigenvalues of truncated systems, convergence."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg
import scipy.optimize
import scipy.special

from .constants import BODY, STRINGS, ContactData, StringData, make_body, make_guitar
from .continuous import body_modes, characteristic, decay, frequency, make_system, poles, receptances, string_modes
from .contour import poles_between
from .loudness import bridge_residues, loudest_partials, span_share
from .partials import body_poles, string_like, string_partials

STIFF = {"mass": 5e-3, "damping": 1.0, "stiffness": 1e6}
SOFT = {"mass": 5e-3, "damping": 10.0, "stiffness": 1e4}
IDEAL = StringData("ideal", 0.65, 71.6, 6.24e-3, 0.0, 0.0, 0.0, 0.0, 0.3)
UNEVEN = make_body((1, 0.7, -0.4, 1, 0.3, -1, 1, 0.2, 1, 0.9), (0.6, 1, 1, -0.8, 1, 0.5, -0.1, 1, -0.9, 1))


def fretted(fret, n_contacts, length=0.65):
    """One stiff contact at the geometric fret, then soft ones every 4 mm towards the nut."""
    place = length * (1.0 - 2.0 ** (-fret / 12.0))
    contacts = [ContactData(place - 4e-3 * f, **(SOFT if f else STIFF)) for f in range(n_contacts)]
    return tuple(contacts)


def cents(a, b):
    return 1200.0 * np.log2(frequency(a) / frequency(b))


def tail_compliance(string, n_modes):
    """Static compliance at the bridge of an ideal string's modes above n_modes [m/N], summed exactly (trigamma)."""
    return 2.0 * string.length / (np.pi**2 * string.tension) * scipy.special.polygamma(1, n_modes + 0.5)


def test_ideal_string_receptances_are_the_closed_ones():
    """Sum over modes against sin(k x) sin'(..)/(T k cos k L) of an ideal string, free at the bridge."""
    contact = ContactData(0.2, 1e-3, 0.1, 1e5)
    system = make_system(make_guitar([IDEAL], None), {0: (contact,)})
    s = 2j * np.pi * np.array([31.0, 100.3, 777.7, 3001.0]) - np.array([0.5, 3.0, 20.0, 400.0])
    matrix = receptances(system, s)[0]
    n = string_modes(IDEAL, system.cut_hz)[0].size
    k = -1j * s / np.sqrt(IDEAL.tension / IDEAL.linear_density)
    scale = IDEAL.tension * k * np.cos(k * IDEAL.length)
    assert np.allclose(matrix[:, 0, 0] + tail_compliance(IDEAL, n), np.sin(k * IDEAL.length) / scale, rtol=1e-7)
    assert np.allclose(matrix[:, 0, 1], np.sin(k * 0.2) / scale, rtol=1e-6)
    own = np.sin(k * 0.2) * np.cos(k * 0.45) / scale + 1.0 / (1e-3 * s**2 + 0.1 * s + 1e5)
    tail = tail_compliance(IDEAL, n) / 2.0  # sin^2 averages to half of what it is at the bridge
    assert np.allclose(matrix[:, 1, 1] + tail, own, rtol=1e-4)


def test_rigid_bridge_gives_n_c_over_2l():
    """f_n = n c / 2L, exactly so once the cut modes' compliance is taken as the shorter string that it is."""
    system = make_system(make_guitar([IDEAL], None))
    found = string_partials(system, 0, 12)
    n = string_modes(IDEAL, system.cut_hz)[0].size
    speed = np.sqrt(IDEAL.tension / IDEAL.linear_density)
    harmonic = np.arange(1, 13) * speed / 2.0
    assert np.allclose(frequency(found), harmonic / IDEAL.length, rtol=1e-4)
    shorter = IDEAL.length - IDEAL.tension * tail_compliance(IDEAL, n)
    assert np.allclose(frequency(found), harmonic / shorter, rtol=3e-9)
    assert np.all(np.abs(decay(found)) < 1e-6)


def test_bending_makes_the_bridge_a_clamped_end():
    """E2 on a rigid bridge against the pinned-clamped stiff string: tan(a L) / a = tanh(b L) / b."""
    string = STRINGS[0]
    t, b = string.tension, string.bending_stiffness

    def residual(omega):
        root = np.sqrt(t**2 + 4.0 * b * string.linear_density * omega**2)
        low, high = np.sqrt((root - t) / (2 * b)), np.sqrt((root + t) / (2 * b))
        return np.tan(low * string.length) / low - np.tanh(high * string.length) / high

    exact = scipy.optimize.brentq(residual, 2 * np.pi * 82.3, 2 * np.pi * 83.0) / (2 * np.pi)
    found = frequency(string_partials(make_system(make_guitar([string], None)), 0, 1))[0]
    assert exact - 82.40 > 0.1
    assert found == pytest.approx(exact, rel=2.5e-4)  # Eq. 48 is the root's first order: its layer is 1/6 thinner


def dense_poles(strings, contacts, body, n_modes):
    """All poles with Im > 0 of the truncated system, its constraints eliminated in their null space (scipy.linalg)."""
    mass, loss, stiffness = [], [], []
    blocks, body_shapes, columns = [], None, []
    for string in strings:
        p, omega, two_sigma, m = string_modes(string, 1e9, n_modes)
        mass += [m] * n_modes
        loss += list(m * two_sigma)
        stiffness += list(m * omega**2)
        blocks.append(p)
    if body is not None:
        omega2, two_sigma, m, body_shapes = body_modes(body, tuple(s.bridge_position for s in strings))
        mass, loss, stiffness = mass + list(m), loss + list(m * two_sigma), stiffness + list(m * omega2)
    fingers = [(s, c) for s, group in enumerate(contacts) for c in group]
    for _, c in fingers:
        if not c.rigid:
            columns.append(len(mass))
            mass.append(c.mass)
            loss.append(c.damping)
            stiffness.append(c.stiffness)
        else:
            columns.append(None)
    rows = np.zeros((len(strings) + len(fingers), len(mass)))
    for s, string in enumerate(strings):
        rows[s, s * n_modes : (s + 1) * n_modes] = np.sin(blocks[s] * string.length)
        if body is not None:
            start = len(strings) * n_modes
            rows[s, start : start + body_shapes.shape[1]] = -body_shapes[s]
    for row, ((s, c), column) in enumerate(zip(fingers, columns, strict=True), len(strings)):
        rows[row, s * n_modes : (s + 1) * n_modes] = np.sin(blocks[s] * c.place)
        if column is not None:
            rows[row, column] = -1.0
    scale = 1.0 / np.sqrt(np.array(mass))
    free = scipy.linalg.null_space(rows * scale)
    damping = free.T @ (np.array(loss) * scale**2 * free.T).T
    spring = free.T @ (np.array(stiffness) * scale**2 * free.T).T
    n = free.shape[1]
    unit = 3000.0  # rad/s, balances the companion matrix
    companion = np.block([[np.zeros((n, n)), unit * np.eye(n)], [-spring / unit, -damping]])
    values = np.linalg.eigvals(companion)
    return values[values.imag > 1.0]


CASES = {
    "one string, body, one contact": ((0,), {0: fretted(5, 1)}, UNEVEN),
    "two strings, body, three contacts and an open string": ((2, 5), {2: fretted(7, 3)}, UNEVEN),
    "rigid bridge, rigid contact": ((3,), {3: (ContactData(0.24, rigid=True),)}, None),
    "three strings, body, light finger in mid-string": ((0, 4, 5), {5: (ContactData(0.31, 1e-3, 0.3, 500.0),)}, BODY),
}


@pytest.mark.parametrize("case", CASES)
def test_truncated_system_equals_dense_eigenvalues(case):
    """60 modes a string: every pole from 60 to 1500 Hz, the oracle's contour search against dense eigenvalues."""
    indices, contacts, body = CASES[case]
    system = make_system(make_guitar(STRINGS, body), contacts, indices, n_modes=60)
    dense = dense_poles(system.strings, system.contacts, system.body, 60)
    window = dense[(frequency(dense) > 60.0) & (frequency(dense) < 1500.0) & (decay(dense) < 150.0)]
    window = window[np.argsort(window.imag)]
    found = poles_between(system, 60.0, 1500.0)
    assert window.size > 5
    assert found.size == window.size
    assert np.max(np.abs(found - window) / np.abs(window)) < 1e-9
    assert np.all(np.abs(cents(found, window)) < 1e-6)
    assert np.all(np.abs(decay(found) / decay(window) - 1.0) < 1e-5)


def test_labelled_partials_are_among_dense_eigenvalues():
    system = make_system(make_guitar(STRINGS, UNEVEN), {1: fretted(3, 2)}, (0, 1), n_modes=80)
    dense = dense_poles(system.strings, system.contacts, system.body, 80)
    for found in (string_partials(system, 0, 8), string_partials(system, 1, 8), body_poles(system)):
        nearest = dense[np.argmin(np.abs(found[:, None] - dense), axis=1)]
        assert np.unique(nearest).size == found.size
        assert np.max(np.abs(found - nearest) / np.abs(found)) < 1e-9


def test_derivative_of_the_characteristic():
    """N(s) against the complex difference of log(det D times the denominators); D' against that of D."""
    system = make_system(make_guitar(), {0: fretted(5, 3), 4: fretted(2, 1)}, n_modes=30)
    s, h = np.array([-3.0 + 700.0j]), 1e-3
    slope = receptances(system, s)[1]
    difference = (receptances(system, s + h)[0] - receptances(system, s - h)[0]) / (2 * h)
    assert np.allclose(slope, difference, rtol=1e-6, atol=1e-9 * np.abs(slope).max())
    dense = dense_poles(system.strings, system.contacts, system.body, 30)
    whole = np.sum(1.0 / (s - dense)) + np.sum(1.0 / (s - dense.conj()))
    real = characteristic(system, s)[0] - whole  # what is left: the few real poles of heavily damped oscillators
    assert abs(real) < 2e-3 * abs(whole)


def test_cut_frequency_has_converged():
    """Modes to 200 kHz against 400 kHz: the change is small, shrinks with the cut, and losses do not care."""
    for s in (0, 5):
        systems = [make_system(make_guitar(), strings=[s], cut_hz=cut) for cut in (100e3, 200e3, 400e3)]
        by_cut = [string_partials(system, 0, 5) for system in systems]
        first = np.abs(cents(by_cut[0], by_cut[1]))
        second = np.abs(cents(by_cut[1], by_cut[2]))
        assert np.all(second < 0.2)
        assert np.all(second < 0.6 * first)
        assert np.all(np.abs(decay(by_cut[1]) / decay(by_cut[2]) - 1.0) < 3e-3)


def test_every_pole_is_found_and_labels_are_a_subset():
    """Six strings on the body: the window's poles are exactly the strings' partials and the body's modes in it."""
    system = make_system(make_guitar())
    labelled = np.concatenate([body_poles(system)] + [string_partials(system, s, 3) for s in range(6)])
    inside = labelled[(frequency(labelled) > 70.0) & (frequency(labelled) < 280.0)]
    found = poles_between(system, 70.0, 280.0)
    assert found.size == inside.size == 11
    assert np.max(np.abs(np.sort_complex(1j * found) - np.sort_complex(1j * inside))) < 1e-6


def test_string_like_takes_the_slower_of_an_exchanged_pair():
    """A string tuned through body mode 2 (182.6 Hz): the chosen pole never decays faster than its partner."""
    exchanged = []
    for pitch in (176.0, 180.0, 182.0, 183.0, 185.0, 190.0):
        string = replace(STRINGS[2], tension=STRINGS[2].tension * (pitch / 147.0) ** 2)
        system = make_system(make_guitar([string], BODY))
        pole, swapped = string_like(system, 0, 1, reach_hz=30.0)
        near = poles_between(system, 160.0, 205.0)
        assert near.size == 2
        assert decay(pole[0]) == pytest.approx(np.min(decay(near)), rel=1e-9)
        exchanged.append(swapped[0])
    assert not all(exchanged)


def test_residues_of_a_released_force():
    """A force at x, let go: partial n of the bridge force starts at 2/(n pi) (-1)^n sin(n pi x/L) of it."""
    string = StringData("light", 0.65, 71.6, 6.24e-3, 0.0, 0.0, 1.0, 0.0, 0.0)
    system = make_system(make_guitar([string], None), n_modes=4000)
    found = string_partials(system, 0, 12)
    n = np.arange(1, 13)
    for place in (0.9, 0.5, 0.3):
        share = 2.0 * bridge_residues(system, found, 0, place * 0.65) / -found
        closed = 2.0 / (n * np.pi) * (-1.0) ** n * np.sin(n * np.pi * place)
        assert np.allclose(share.real, closed, atol=2e-4)


def test_three_contacts_keep_the_note_on_the_bridge_side():
    for s, fret in ((0, 5), (2, 7), (5, 12)):
        system = make_system(make_guitar(), {s: fretted(fret, 3)}, [s])
        assert span_share(system, string_partials(system, 0, 1)[0], 0) > 0.95


def test_loudest_pole_is_the_sounding_span_s():
    """E2 at fret 12, one contact, both spans in unison: the loudest pole of each partial is on the bridge side."""
    system = make_system(make_guitar(), {0: fretted(12, 1)}, [0])
    loud = loudest_partials(system, 0, 4, 0.585)
    assert np.all(np.array([span_share(system, pole, 0) for pole in loud]) > 0.5)
    clear = make_system(make_guitar(), {2: fretted(5, 3)}, [2])
    assert np.allclose(loudest_partials(clear, 0, 3, 0.585), string_partials(clear, 0, 3), rtol=1e-10)


def test_polarization_z_sees_no_body():
    system = make_system(make_guitar(), strings=[0], polarization="Z")
    rigid = make_system(make_guitar(STRINGS, None), strings=[0])
    assert np.array_equal(string_partials(system, 0, 4), string_partials(rigid, 0, 4))
    coupled = make_system(make_guitar(), strings=[0])
    assert abs(cents(string_partials(coupled, 0, 1), string_partials(rigid, 0, 1))[0]) > 1.0


def test_bad_contacts_and_lost_guesses_are_refused():
    with pytest.raises(ValueError, match="differ"):
        make_system(make_guitar(), {0: (ContactData(0.1), ContactData(0.1))})
    with pytest.raises(ValueError, match="legal"):
        make_system(make_guitar(), polarization="X")
    with pytest.raises(RuntimeError, match="guess"):
        poles(make_system(make_guitar(), strings=[0]), [1j * 5000.0], max_steps=1)
