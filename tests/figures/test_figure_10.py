"""Fig. 10 cut short: partials decay as the eigenvalue problem says, and more damping widens the band."""

import pytest
from short_runs import check_whole, number_called, short

from ukrt.figures import figure_10
from ukrt.figures.stopped_string import CHOSEN, READINGS


@pytest.fixture(scope="module")
def data():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(figure_10, "READINGS", {CHOSEN: READINGS[CHOSEN]})
        return figure_10.make(short(2.0))


def test_the_figure_is_whole(data):
    assert len(check_whole(figure_10, data).axes) == 2


@pytest.mark.parametrize("c", ["c = 1 N s/m", "c = 10 N s/m"])
def test_decays_agree_with_the_eigenvalue_problem_and_the_closed_form(data, c):
    assert number_called(data, "decay rate of partial 4", c).agrees
    assert number_called(data, "all modes together", c).agrees


def test_more_damping_is_a_wider_band_and_a_shorter_note(data):
    for words in ("width of the band", "spent 90 %", "ripple"):
        assert number_called(data, words, "c = 10 N s/m").agrees
    widths = [number_called(data, "half-power width", f"c = {c:g} N s/m").value for c in figure_10.DAMPINGS]
    assert widths[1] > 8 * widths[0]
