"""The reference solver is the paper's scheme and nothing else: its poles, measured in its own motion, are those of the
same basis in continuous time moved by velocity-Verlet's closed form, and they converge to the oracle's."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg
from accuracy import Note, Scheme, compare, nearest_poles
from accuracy.notes import linear_guitar, setting, tuned_and_held
from accuracy.reference_records import one_direction, reference_record, respond

from ukrt.model.contacts import HeldPoint
from ukrt.model.parameters import Body, Contact, Finger
from ukrt.model.strings import REFERENCE_HZ, string_modes_range
from ukrt.reference.system import make_system


def lossless(guitar):
    """The guitar without losses, its finger one oscillator and one rigid point behind it."""
    strings = tuple(replace(one, loss_internal=0.0, loss_air=0.0, loss_bending=0.0) for one in guitar.strings)
    body = replace(guitar.body, damping_ratios=(0.0,) * len(guitar.body.damping_ratios))
    finger = Finger((Contact(0.0, mass=5e-3, stiffness=1e6), Contact(-0.01, rigid=True)))
    return replace(guitar, strings=strings, body=body, finger=finger)


@pytest.mark.parametrize(("fret", "step"), [(0, 1e-5), (7, 1e-5), (7, 2e-5)])
def test_poles_are_dense_eigenvalues_moved_by_the_closed_form(fret, step):
    """Lossless A2: omega from the eigenproblem in the null space of A, then 2 / dt asin(omega dt / 2); decay nil."""
    guitar, intonation, placed = setting(Note(1, fret, 1 if fret else 0, alone=True))
    guitar = lossless(guitar)
    tuned, held = tuned_and_held(guitar, intonation, placed)
    system = one_direction(make_system(tuned, held), "Y")
    root = 1.0 / np.sqrt(system.mass)
    free = scipy.linalg.null_space(system.A * root)
    omega = np.sqrt(scipy.linalg.eigvalsh(free.T @ ((system.stiffness / system.mass)[:, None] * free)))
    chosen = omega[(omega > 2 * np.pi * 70.0) & (omega < 2 * np.pi * 1500.0)]
    record, rate = reference_record(guitar, intonation, placed, step)
    expected = 2.0 / step * np.arcsin(0.5 * step * chosen)
    found = nearest_poles(record, rate, 1j * expected)
    assert len(chosen) >= 15
    assert np.max(np.abs(1200.0 * np.log2(2.0 * np.pi * found[:, 0] / expected))) < 1e-5
    assert np.max(np.abs(found[:, 1])) < 1e-5


NOTES = (Note(3, 5, 1), Note(5, 19, 1, alone=True), Note(2, 7, 5, alone=True), Note(3, 2, 3, "Z", alone=True))


@pytest.mark.parametrize("note", NOTES, ids=str)
def test_poles_are_those_of_the_oracle_cut_and_stepped_alike(note):
    """With losses, fingers, body: sums over the same basis with differences for derivatives foretell all."""
    result = compare(note, Scheme("reference"), theory=True)
    assert np.max(np.abs(result.theory.own[0])) < 1e-4
    assert np.max(np.abs(result.theory.own[1])) < 1e-4
    assert np.max(np.abs(result.theory.followed[0])) > 1.0  # and yet this is what the paper's discretisation is off by


def test_verlet_is_sharp_and_of_second_order():
    """E4 open: the same basis moved by the closed form; errors of pitch and decay fall fourfold with half the step."""
    note = Note(5, 0, 0, alone=True)
    results = [compare(note, Scheme("reference", step=step), theory=True) for step in (2e-5, 1e-5)]
    moved = [result.theory.step[0] for result in results]
    for result, cents in zip(results, moved, strict=True):
        half = 0.5 * result.scheme.step * 2.0 * np.pi * result.frequencies_hz * 2.0 ** (result.theory.cut[0] / 1200.0)
        assert np.allclose(cents, 1200.0 * np.log2(np.arcsin(half) / half), rtol=2e-3)
    assert np.allclose(moved[0] / moved[1], 4.0, rtol=0.02)
    lost = [result.theory.step[1] for result in results]
    assert np.allclose(lost[0] / lost[1], 4.0, rtol=0.05)


def test_truncation_is_a_shorter_string():
    """E4 open: cut modes of compliance C make the string T C shorter; in the limit of all modes it is the oracle's."""
    note, bases = Note(5, 0, 0, alone=True), (5e3, 10e3, 20e3)
    string = tuned_and_held(*setting(note))[0].strings[0]
    results = [compare(note, Scheme("reference", step=5e-6, basis_hz=basis), theory=True) for basis in bases]
    for result in results:
        modes = string_modes_range(string, result.scheme.basis_hz, REFERENCE_HZ)
        omega = 2.0 * np.pi * result.frequencies_hz[:5, None]
        shorter = string.tension * np.sum(1.0 / (modes.mass * (modes.omega**2 - omega**2)), axis=1)
        assert np.allclose(result.theory.cut[0][:5], 1200.0 / np.log(2.0) * shorter / string.length, rtol=0.02)
    whole = [np.max(np.abs(result.cents[:5])) for result in results]
    assert whole[0] > 2.0 * whole[1] > 4.0 * whole[2]


def test_a_body_that_is_not_there_and_a_rigid_finger():
    """On a rigid bridge the two directions are alike."""
    guitar, _ = linear_guitar(1)
    guitar = replace(guitar, body=Body((), (), (), (), ()), strings=guitar.strings[3:4])
    whole = make_system(guitar, [(HeldPoint(0.24, rigid=True),)])
    records = []
    for polarization in ("Y", "Z"):
        system = one_direction(whole, polarization)
        records.append(respond(system, system.shape(0, 0.5, "Y"), 1e-5, 0.05)[0])
    assert np.max(np.abs(records[0])) > 0.01
    assert np.allclose(records[0], records[1], rtol=0.0, atol=1e-9)
