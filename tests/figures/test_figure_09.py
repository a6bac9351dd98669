"""Fig. 9 cut short: the finger's own peak stands where the eigenvalue problem has it."""

import pytest
from short_runs import check_whole, number_called, short

from ukrt.figures import figure_09
from ukrt.figures.stopped_string import CHOSEN, READINGS


@pytest.fixture(scope="module")
def data():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(figure_09, "READINGS", {CHOSEN: READINGS[CHOSEN]})
        patch.setattr(figure_09, "WIDER_HZ", 12e3)
        return figure_09.make(short(1.0))


def test_the_figure_is_whole(data):
    figure = check_whole(figure_09, data)
    assert len(figure.axes) == 3


def test_the_fingers_own_peak_moves_with_the_stiffness(data):
    peaks = [number_called(data, "own peak", f"k = {k:g} N/m") for k in figure_09.STIFFNESSES]
    assert all(one.agrees for one in peaks)
    for softer, stiffer in zip(peaks, peaks[1:], strict=False):
        assert stiffer.value / softer.value == pytest.approx(10**0.5, rel=0.15)


def test_a_stiffer_contact_is_nearer_to_a_rigid_one(data):
    spread = [number_called(data, "detuning", f"k = {k:g} N/m").value for k in figure_09.STIFFNESSES]
    assert spread[0] > spread[1] > 10 * spread[2]
    assert number_called(data, "change of the spectrum", "from 10000 ").value > 2.0
