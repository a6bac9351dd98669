"""A second kind of oracle: spectra of short plucks by either solver against admittances in the frequency domain.

Records are weighted with exp(-damping t), which makes them finite without a window: their spectra are the oracle's
transfer functions on the line Re s = damping, where no pole is near, times the transform of the push.
"""

from dataclasses import replace

import numpy as np
import pytest
from oracle import OnBridge, OnString, admittance, bridge_forces

from ukrt.engine import gestures
from ukrt.engine import layout as at
from ukrt.engine.discretize import fill_instance, make_arrays
from ukrt.engine.kernels.advance import advance
from ukrt.engine.kernels.hands import perform
from ukrt.reference.system import make_system

from .compare import note_system
from .engine_records import forces_y
from .notes import TEST_PLUCK, Note, note_place, pluck_place, setting, tuned_and_held
from .reference_records import one_direction, push_steps, respond

DAMPING = 16.0  # 1/s: after 1.5 s exp(-24) = 4e-11 is left; a partial's peak is some 5 Hz wide
SECONDS = 1.5
BOUNDS = ((1000.0, 0.02), (2000.0, 0.2), (4000.0, 1.0))  # dB up to these frequencies [Hz]; twice what was measured
NOTES = (Note(0, 0, 0), Note(2, 7, 3), Note(5, 19, 1))


def line(low, high, count=40):
    """Points of the Laplace plane above DAMPING, evenly spaced in log frequency [rad/s]."""
    return DAMPING + 2j * np.pi * np.geomspace(low, high, count)


def transform(record, times, s):
    """Sum of record exp(-s t) over the samples: (points,)."""
    parts = [np.exp(-np.outer(block, times)) @ record for block in np.array_split(s, 24)]
    return np.concatenate(parts)


def decibels(found, truth):
    return 20.0 * np.log10(np.abs(found / truth))


@pytest.mark.parametrize("note", [replace(note, alone=True) for note in NOTES[1:]], ids=str)
def test_reference_admittance_at_the_bridge(note):
    """Driving-point admittance at the bridge: the oracle with the same basis and step to 1e-6, all modes to 1 dB."""
    guitar, intonation, placed = setting(note)
    tuned, held = tuned_and_held(guitar, intonation, placed)
    system, step = one_direction(make_system(tuned, held), "Y"), 1e-5
    forces, moved = respond(system, system.shape(0, tuned.strings[0].length, "Y"), step, SECONDS)
    times, s = step * np.arange(1, len(moved) + 1), line(60.0, 6000.0)
    pushed = TEST_PLUCK * sum(np.exp(-s * step * k) for k in range(1, push_steps(step) + 1))
    found = s * transform(moved, times, s) / pushed
    oracle, end = note_system(guitar, intonation, placed), OnString(0, tuned.strings[0].length)
    same = admittance(replace(oracle, cut_hz=guitar.basis.bandwidth_hz, step=step), end, end, s)
    assert np.max(np.abs(found / same - 1.0)) < 1e-6
    truth = admittance(oracle, OnBridge(tuned.strings[0].bridge_position), end, s)
    assert np.max(np.abs(decibels(found, truth))) < 1.0
    force = -transform(forces[:, 0], times, s) / pushed
    same = bridge_forces(replace(oracle, cut_hz=guitar.basis.bandwidth_hz, step=step), end, s)[:, 0]
    assert np.max(np.abs(force / same - 1.0)) < 1e-6


def plucked_forces(guitar, intonation, note, place, sample_rate):
    """The engine's bridge force of the note's string and of the others from the first sample of a pluck on."""
    d, i = make_arrays()
    fill_instance(d, i, guitar, intonation, sample_rate)
    if note.fret:
        perform(d, i, gestures.PRESS, note.string, note_place(intonation, note), 1.0, 0.0, 0.0)
        advance(d, i, at.CHUNK)
    perform(d, i, gestures.PLUCK, note.string, place, TEST_PLUCK, 0.0, 2.0)
    return forces_y(d, i, int(SECONDS * sample_rate), note.string)


@pytest.mark.parametrize("note", NOTES, ids=str)
def test_engine_transfer_to_the_bridge(note):
    """From a point of the string to the forces of this string and of all others on the body, six strings there.

    What is left is the engine's error on the line: poles 1e-3 cents off, or above 1.5 kHz the response between them.
    """
    guitar, intonation, placed = setting(note)
    rate, s = 48000.0, line(60.0, 4000.0, 120)
    place = pluck_place(guitar, intonation, note, 0.23)
    record = plucked_forces(guitar, intonation, placed, place, rate)
    turn = np.exp(-s / rate)
    pushed = TEST_PLUCK * (1.0 / 12.0 + 0.5 * turn + 5.0 / 12.0 * turn**2)  # the ramp, averaged with the hat
    times = np.arange(len(record)) / rate
    point = OnString(note.string, place * guitar.strings[note.string].length)
    truth = bridge_forces(note_system(guitar, intonation, placed), point, s)
    rest = truth.sum(axis=1) - truth[:, note.string]
    for channel, expected in ((0, truth[:, note.string]), (1, rest)):
        error = np.abs(decibels(transform(record[:, channel], times, s) / pushed, expected))
        for highest_hz, bound in BOUNDS:
            assert np.max(error[s.imag < 2.0 * np.pi * highest_hz]) < bound, highest_hz
