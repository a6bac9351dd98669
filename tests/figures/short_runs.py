"""Runs of figures' cases cut short, and what holds for any figure."""

from dataclasses import replace

import numpy as np
from matplotlib.figure import Figure

from ukrt.figures.runs import Run


def short(duration):
    """A run that ends each case after ``duration`` [s]."""
    run = Run()

    def cut(case):
        return run(replace(case, duration=min(duration, case.duration)))

    cut.solver = run.solver
    return cut


def check_whole(module, data):
    """Numbers are finite and said, arrays are real, cases are there, the picture can be drawn; returns it."""
    assert data.cases and data.numbers
    for number in data.numbers:
        assert np.isfinite(number.value), number.what
        assert number.agrees in (True, False, None), number.what
    assert len({number.what for number in data.numbers}) == len(data.numbers)
    for name, one in data.arrays.items():
        assert np.isfinite(one.values).all() and one.unit, name
        assert not one.columns or len(one.columns) == one.values.shape[1], name
    for rate_hz, samples in data.sounds.values():
        assert rate_hz == 48000 and 0.5 < np.max(np.abs(samples)) <= 1.0
    figure = Figure()
    module.draw(data, figure)
    figure.draw_without_rendering()
    return figure


def number_called(data, *words):
    """The number whose name holds all of these words."""
    (found,) = [one for one in data.numbers if all(word in one.what for word in words)]
    return found
