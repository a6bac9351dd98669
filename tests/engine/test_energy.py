"""The energy balance: constant without losses, and with them every joule accounted for, gestures included."""

from dataclasses import replace

import numpy as np
import pytest
from engine.bench import add, classical, fret_place, on_bench, run, undamped
from engine.meter import (
    CONSTRAINT,
    FRAME,
    JUMP_DOWN,
    JUMP_UP,
    LARGEST_ENERGY,
    LARGEST_ERROR,
    LOSS,
    PLUCK,
    metered_steps,
)
from scipy.signal import butter, sosfilt

from ukrt.engine import gestures
from ukrt.engine import layout as at
from ukrt.engine.kernels.energy import string_energy, total_energy
from ukrt.model.strings import residual_compliance

LOW_E, G, HIGH_E = 0, 3, 5


def _pluck(d, i, s, force, frame=10, place=0.85, angle=0.4):
    add(d, i, frame, gestures.PLUCK, s, place, force, angle, 480)


@pytest.mark.parametrize("force, stretch", [(5.0, 0.0), (5.0, None), (30.0, None), (100.0, None)])
def test_undamped_energy_is_constant_for_20_s(force, stretch):
    """Six coupled strings, two of them stopped by three contacts; linear (ES = 0) and with Kirchhoff-Carrier."""
    guitar = undamped() if stretch is None else undamped(axial_stiffness=stretch)
    d, i = on_bench(guitar)
    for s, fret in ((LOW_E, 5), (HIGH_E, 7)):
        add(d, i, 0, gestures.PRESS, s, fret_place(guitar.strings[s], fret), 100)
    for s in (LOW_E, G, HIGH_E):
        _pluck(d, i, s, force)
    ledger, saved = np.zeros(8), np.zeros(at.D_SIZE)
    metered_steps(d, i, 640, ledger, saved)
    start = total_energy(d, i)
    rises = []
    for _ in range(10):
        run(d, i, 1500, 64)
        rises.append(total_energy(d, i) / start - 1.0)
    assert i[at.H_BUSY] == 0
    assert np.abs(rises).max() < 1e-9
    if stretch is None:
        assert -d[at.MU : at.MU + 6].min() > 0.05, "the strings were not stretched: nothing nonlinear was tested"


def _frets(guitar, s, fret):
    return fret_place(guitar.strings[s], fret)


def _scripts():
    """Name, what happens (a list of frame, kind, string, numbers from the guitar)."""
    return {
        "open string": lambda g: [],
        "fretted note": lambda g: [(10, gestures.PRESS, LOW_E, _frets(g, LOW_E, 5), 240)],
        "landing on a sounding string": lambda g: [(3000, gestures.PRESS, LOW_E, _frets(g, LOW_E, 5), 240)],
        "lift": lambda g: [
            (10, gestures.PRESS, LOW_E, _frets(g, LOW_E, 5), 240),
            (6000, gestures.LIFT, LOW_E, 0.0, 144),
        ],
        "slide": lambda g: [
            (10, gestures.PRESS, LOW_E, _frets(g, LOW_E, 5), 240),
            (4000, gestures.MOVE, LOW_E, _frets(g, LOW_E, 7), 4800),
        ],
        "damped": lambda g: [(4000, gestures.DAMP, LOW_E, 1.0, 384), (9000, gestures.UNDAMP, LOW_E, 0.0, 240)],
        "damped and lifted": lambda g: [
            (10, gestures.PRESS, LOW_E, _frets(g, LOW_E, 3), 240),
            (4000, gestures.DAMP, LOW_E, 1.0, 384),
            (8000, gestures.LIFT, LOW_E, 0.0, 144),
            (9000, gestures.UNDAMP, LOW_E, 0.0, 240),
        ],
        "bend": lambda g: [(4000, gestures.TENSION, LOW_E, 2.0 ** (2 / 6), 4800)],
        "slide while bending, neighbours sounding": lambda g: [
            (10, gestures.PRESS, LOW_E, _frets(g, LOW_E, 5), 240),
            (10, gestures.PLUCK, G, 0.85, 5.0, 0.4, 480),
            (4000, gestures.MOVE, LOW_E, _frets(g, LOW_E, 4), 2400),
            (4000, gestures.TENSION, LOW_E, 1.05, 2400),
            (5000, gestures.PRESS, G, _frets(g, G, 2), 240),
        ],
    }


@pytest.mark.parametrize("name", _scripts())
def test_every_sample_balances_and_gestures_give_nothing(name):
    """Each sample's change is work minus loss to rounding; gestures take, and only a bend (by its own work) gives."""
    guitar = classical()
    d, i = on_bench(guitar)
    _pluck(d, i, LOW_E, 5.0)
    for frame, kind, s, *numbers in _scripts()[name](guitar):
        add(d, i, frame, kind, s, *numbers)
    ledger, saved = np.zeros(8), np.zeros(at.D_SIZE)
    metered_steps(d, i, 14000, ledger, saved)
    put_in = ledger[PLUCK] + max(ledger[CONSTRAINT], 0.0)
    assert put_in > 1e-3
    assert ledger[LARGEST_ERROR] < 1e-10 * ledger[LARGEST_ENERGY]
    kept = total_energy(d, i) + ledger[LOSS] - ledger[PLUCK] - ledger[CONSTRAINT]
    if "bend" not in name:
        # New pseudo-modes keep the ports' displacement and velocity; a new frequency weighs the velocity a little anew.
        assert ledger[JUMP_UP] < 1e-7 * put_in
        assert -1e-3 * put_in - _lifted(name, ledger) < kept <= 1e-7 * put_in
    assert abs(kept - ledger[JUMP_UP] + ledger[JUMP_DOWN]) < 1e-9 * put_in


def _lifted(name, ledger):
    """What a lifted finger takes with it belongs to the finger, not to the notes."""
    return ledger[JUMP_DOWN] if "lift" in name else 0.0


def test_release_drops_only_what_the_basis_cannot_hold():
    """The energy that leaves at the release is at most the cut modes' share, F^2 / 2 times their compliance."""
    guitar = classical(axial_stiffness=0.0)
    d, i = on_bench(guitar)
    _pluck(d, i, HIGH_E, 5.0, place=0.85, angle=0.0)
    ledger, saved = np.zeros(8), np.zeros(at.D_SIZE)
    metered_steps(d, i, 3000, ledger, saved)
    string = guitar.strings[HIGH_E]
    static, _ = residual_compliance(string, guitar.basis.bandwidth_hz, np.array([string.length, 0.85 * string.length]))
    at_pluck = static[1, 1] - static[0, 1] ** 2 / static[0, 0]
    assert 0.0 < ledger[JUMP_DOWN] <= 0.5 * 5.0**2 * at_pluck
    assert ledger[JUMP_DOWN] < 4e-3 * ledger[PLUCK]


def test_slow_bend_keeps_the_action_of_the_string():
    """Energy follows frequency when the tension of a lossless string is raised slowly: two semitones, 2^(2/12)."""
    guitar = undamped(axial_stiffness=0.0)
    guitar = replace(guitar, strings=guitar.strings[:1], body=replace(guitar.body, **dict.fromkeys(_BODY, ())))
    d, i = on_bench(guitar)
    _pluck(d, i, 0, 2.0)
    run(d, i, 20, 64)
    ledger, saved = np.zeros(8), np.zeros(at.D_SIZE)
    metered_steps(d, i, 2000, ledger, saved)
    start = string_energy(d, i, 0)
    add(d, i, int(ledger[FRAME]), gestures.TENSION, 0, 2.0 ** (2 / 6), 9600)
    metered_steps(d, i, 12000, ledger, saved)
    assert string_energy(d, i, 0) / start == pytest.approx(2.0 ** (2 / 12), rel=2e-3)


def test_slow_slide_keeps_the_action_of_the_string():
    """Fret 5 to 7 in 100 ms on a lossless string: energy rises as frequency does, by real work of the finger."""
    guitar = undamped(axial_stiffness=0.0)
    guitar = replace(guitar, strings=guitar.strings[:1], body=replace(guitar.body, **dict.fromkeys(_BODY, ())))
    d, i = on_bench(guitar)
    add(d, i, 0, gestures.PRESS, 0, _frets(guitar, 0, 5), 240)
    _pluck(d, i, 0, 2.0, angle=0.0)
    ledger, saved = np.zeros(8), np.zeros(at.D_SIZE)
    metered_steps(d, i, 2000, ledger, saved)
    start, work = total_energy(d, i), ledger[CONSTRAINT]
    add(d, i, int(ledger[FRAME]), gestures.MOVE, 0, _frets(guitar, 0, 7), 4800)
    metered_steps(d, i, 6000, ledger, saved)
    assert total_energy(d, i) - start == pytest.approx(ledger[CONSTRAINT] - work, rel=1e-6)
    assert total_energy(d, i) / start == pytest.approx(2.0 ** (2 / 12), rel=0.02)


_BODY = ("frequencies_hz", "damping_ratios", "modal_masses", "shapes_bass", "shapes_treble")


def test_a_lifted_finger_lets_go_gently():
    """Above 8 kHz, where the string has fallen silent, the bridge hears a finger torn off, but not one that lets go."""
    guitar = classical()
    above = butter(4, 8000.0, "high", fs=48000.0, output="sos")
    loud = {}
    for ramp in (0, 1, 144):
        d, i = on_bench(guitar)
        add(d, i, 0, gestures.PRESS, LOW_E, _frets(guitar, LOW_E, 5), 240)
        _pluck(d, i, LOW_E, 5.0)
        if ramp:
            add(d, i, 12000, gestures.LIFT, LOW_E, 0.0, ramp)
        ledger, saved, force = np.zeros(8), np.zeros(at.D_SIZE), np.zeros(12600)
        for k in range(len(force)):
            metered_steps(d, i, 1, ledger, saved)
            force[k] = -d[at.LAM_Y + LOW_E]
        loud[ramp] = np.sqrt(np.mean(sosfilt(above, force)[12000:] ** 2))
    assert loud[1] > 10.0 * loud[0], "a finger torn off should be heard"
    assert loud[144] < 2.0 * loud[0]
