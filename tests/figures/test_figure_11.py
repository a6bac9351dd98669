"""Fig. 11: what the paper's scheme lets past rigid contacts is what a sum of coupled modes lets past."""

import numpy as np
import pytest
from short_runs import check_whole, number_called, short

from ukrt.figures import figure_11
from ukrt.figures.modal_sum import deviation_by_modes
from ukrt.figures.runs import Run
from ukrt.figures.stopped_string import CHOSEN, READINGS

GRID = np.linspace(0.0, 0.65, 131)


@pytest.mark.parametrize("count", [1, 5])
def test_time_stepping_and_a_sum_of_modes_agree_along_the_string(count):
    run, results = Run(), []
    _, case = figure_11._deviation(
        lambda one: results.append(run(one)) or results[0], count, GRID, READINGS[CHOSEN], duration=0.3
    )
    (result,) = results
    stepped = np.std(result["displacement"][result.times >= 0.01], axis=0)  # the sum begins where the pluck ends
    summed = deviation_by_modes(case, GRID, figure_11.BASIS_HZ)
    assert summed == pytest.approx(stepped, rel=0.01, abs=2e-4 * stepped.max())
    assert figure_11.leakage(GRID, summed, case) == pytest.approx(figure_11.leakage(GRID, stepped, case), abs=0.1)


def test_leakage_of_equal_motion_on_both_sides_is_nil_decibels():
    _, case = figure_11._deviation(Run(), 2, GRID[:2], READINGS[CHOSEN], duration=1e-3)
    assert figure_11.leakage(GRID, np.full(len(GRID), 2e-4), case) == pytest.approx(0.0, abs=1e-12)


def test_the_figure_is_whole(monkeypatch):
    monkeypatch.setattr(figure_11, "WIDTHS", (0.020,))
    monkeypatch.setattr(figure_11, "WIDER_HZ", 12e3)
    data = figure_11.make(short(0.1))
    check_whole(figure_11, data)
    assert number_called(data, "between 0.16 and 0.20 m").agrees
    zeros = np.interp(
        data.arrays["contact_places"].values, data.arrays["place"].values, data.arrays["deviation"].values[:, 3]
    )
    assert zeros.max() < 1e-3 * data.arrays["deviation"].values.max()
