"""Fig. 12 cut short: the stiff contact tunes, the soft ones damp the middle partials."""

import pytest
from short_runs import check_whole, number_called, short

from ukrt.figures import figure_12
from ukrt.figures.stopped_string import CHOSEN, READINGS


def test_contacts_reach_over_the_fingers_width():
    contacts = figure_12.stiff_and_soft(5)
    assert [one.stiffness for one in contacts] == [1e6, 1e4, 1e4, 1e4, 1e4]
    assert [one.offset for one in contacts] == pytest.approx([0.0, -0.00375, -0.0075, -0.01125, -0.015])


def test_the_figure_is_whole_and_five_contacts_damp_more_than_three(monkeypatch):
    monkeypatch.setattr(figure_12, "READINGS", {CHOSEN: READINGS[CHOSEN]})
    data = figure_12.make(short(1.0))
    check_whole(figure_12, data)
    assert set(data.sounds) == {"figure_12_3_contacts", "figure_12_5_contacts"}
    three, five = (number_called(data, f"decay rate of partial 7, F = {count}") for count in (3, 5))
    assert five.value > 5 * three.value
    assert all(number_called(data, "tuning", f"F = {count}").agrees for count in (3, 5))
