"""Units: fixed points of MIDI and decibels, and that every conversion undoes its inverse."""

import numpy as np
import pytest

from ukrt import units


def test_fixed_points():
    assert units.midi_to_hz(69) == 440.0
    assert units.midi_to_hz(69, a4_hz=415.0) == 415.0
    assert units.midi_to_hz(40) == pytest.approx(82.4069, abs=1e-4)  # E2 in equal temperament
    assert units.cents_to_ratio(1200) == 2.0
    assert units.db_to_gain(20) == 10.0
    assert units.gain_to_db(0.0) == -np.inf


def test_inverses_on_arrays():
    notes = np.linspace(0, 127, 50)
    np.testing.assert_allclose(units.hz_to_midi(units.midi_to_hz(notes, 432.0), 432.0), notes, atol=1e-10)
    np.testing.assert_allclose(units.ratio_to_cents(units.cents_to_ratio(notes)), notes, atol=1e-9)
    np.testing.assert_allclose(units.gain_to_db(units.db_to_gain(notes)), notes, atol=1e-10)


def test_scalars_stay_plain_numbers():
    assert type(units.midi_to_hz(69)) is float
    assert type(units.db_to_gain(np.float64(3.0))) is float
