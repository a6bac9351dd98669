"""The overload watch on made-up loads: what sheds, what does not, how it comes back."""

import numpy as np
import pytest

from ukrt.engine import stage_layout as at
from ukrt.engine.kernels.overload import watch_load

RATE, BLOCK, BUDGET = 48000.0, 128, 0.9


def _stage(block=BLOCK, budget=BUDGET):
    si, sd = np.zeros(at.SI_SIZE, np.int64), np.zeros(at.SD_SIZE)
    si[at.G_STAMP_BLOCK], sd[at.M_RATE], sd[at.M_SHED_BUDGET] = block, RATE, budget
    return si, sd


def _watch(stage, loads):
    """Level wanted after each block."""
    wanted = []
    for load in loads:
        watch_load(*stage, load)
        wanted.append(int(stage[0][at.G_SHED_WANTED]))
    return wanted


def _seconds(seconds, block=BLOCK):
    return int(seconds * RATE / block)


def test_one_late_block_sheds_nothing():
    quiet = [0.3] * 7
    assert max(_watch(_stage(), ([5.0, *quiet]) * 200)) == 0


@pytest.mark.parametrize("gap, level", [(0, 1), (6, 1), (7, 0)])
def test_two_late_blocks_of_eight_shed(gap, level):
    assert _watch(_stage(), [0.95] + [0.5] * gap + [0.95])[-1] == level


@pytest.mark.parametrize("block", [64, 128, 1024])
def test_steady_overload_climbs_in_steps_of_50_ms_to_the_third_level(block):
    wanted = np.array(_watch(_stage(block), [1.2] * _seconds(1.0, block)))
    rises = np.flatnonzero(np.diff(wanted, prepend=0)) * block / RATE
    assert wanted[-1] == 3 and len(rises) == 3
    assert np.diff(rises).min() >= 0.05 - 1e-9
    assert rises[-1] < 0.05 + 8 * block / RATE * 3 + 0.1


def test_it_comes_back_one_level_after_each_two_seconds_of_rest():
    stage = _stage()
    _watch(stage, [1.2] * _seconds(0.5))
    wanted = np.array(_watch(stage, [0.4] * _seconds(7.0)))
    falls = np.flatnonzero(np.diff(wanted)) * BLOCK / RATE
    assert wanted[0] == 3 and wanted[-1] == 0
    assert falls == pytest.approx([2.0, 4.0, 6.0], abs=0.02)


def test_it_stays_where_the_load_is_neither_high_nor_low():
    stage = _stage()
    _watch(stage, [1.2] * 2)
    assert set(_watch(stage, [0.7] * _seconds(10.0))) == {1}
    assert set(_watch(stage, ([0.3] * _seconds(1.9) + [0.6]) * 4)) == {1}


def test_without_a_budget_it_does_nothing_at_all():
    si, sd = _stage(budget=0.0)
    si[at.G_SHED_WANTED] = 2  # as a take says that is played again
    before = si.copy()
    _watch((si, sd), [9.0] * 100)
    assert np.array_equal(si, before)


@pytest.mark.parametrize("load", [float("nan"), 0.0])
def test_a_load_that_was_not_measured_sheds_nothing(load):
    assert max(_watch(_stage(), [load] * 1000)) == 0
