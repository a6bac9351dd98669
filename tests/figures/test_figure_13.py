"""Fig. 13 cut short: six notes on the whole guitar, and a pressure that is the force through the impulse response."""

import numpy as np
import pytest
from short_runs import check_whole, number_called, short

from ukrt.figures import figure_13


@pytest.fixture(scope="module")
def data():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(figure_13, "APART", 0.03)
        return figure_13.make(short(0.6), duration=0.6)


def test_the_figure_is_whole(data):
    check_whole(figure_13, data)
    pressure, force = (data.sounds[f"figure_13_{name}"][1] for name in ("pressure", "bridge_force"))
    assert pressure.shape == (len(force), 2) and force.ndim == 1
    assert len(force) == pytest.approx(0.6 * 48000, abs=2)


def test_three_strings_are_stopped_by_five_contacts_each(data):
    (case,) = data.cases
    assert [len(points) for points in case.held_points(0.0)] == [5, 5, 0, 0, 0, 5]
    assert case.tension_modulation and case.losses and case.bridge == "body"


def test_the_notes_are_those_of_g_major(data):
    names = [f"fundamental of {name} " for name in figure_13.FRETS]
    hz = np.array([number_called(data, name).value for name in names])
    semitones = 12 * np.log2(hz / 440.0) + 69
    assert np.round(semitones).astype(int).tolist() == [43, 47, 50, 55, 59, 67]


def test_the_pressure_is_the_force_through_the_impulse_response(data):
    assert number_called(data, "|H| at the partials").value < 2.5
    assert number_called(data, "strongest less weakest").agrees
