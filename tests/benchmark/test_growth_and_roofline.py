"""What is made of measured times: straight lines, rooflines, comparisons; on numbers whose answers are known."""

import json

import numpy as np
import pytest

from ukrt.benchmark import loops, parts
from ukrt.benchmark.compare import ReportError, compare_reports, read_report
from ukrt.benchmark.growth import MEASUREMENTS, QUANTITIES, Growth, plot_growth
from ukrt.engine import layout as at


def test_a_line_is_found_and_what_bends_is_seen():
    amounts = np.array([1.0, 2.0, 4.0, 8.0])
    straight = Growth("modes", "", amounts, 30.0 + 5.0 * amounts)
    assert straight.line == pytest.approx((5.0, 30.0))
    assert straight.deviation < 1e-12
    bent = Growth("modes", "", amounts, 30.0 + 5.0 * amounts**2)
    assert bent.deviation > 0.3


def test_every_quantity_is_measured_at_several_amounts_in_order():
    assert sum(len(amounts) for _, _, amounts, _ in QUANTITIES) == MEASUREMENTS
    for _, _, amounts, _ in QUANTITIES:
        assert len(amounts) >= 4 and list(amounts) == sorted(set(amounts))


def test_the_roof_is_the_slower_of_arithmetic_and_memory():
    by_arithmetic = parts.Roofline(flops=1000.0, bytes=10.0, peak_flops=1e10, peak_bytes=1e10, measured_ns=200.0)
    assert by_arithmetic.least_ns == pytest.approx(100.0) and by_arithmetic.share == pytest.approx(0.5)
    by_memory = parts.Roofline(flops=10.0, bytes=1000.0, peak_flops=1e10, peak_bytes=1e10, measured_ns=400.0)
    assert by_memory.least_ns == pytest.approx(100.0) and by_memory.share == pytest.approx(0.25)


def test_the_loop_of_multiply_adds_does_as_many_as_it_says():
    """x s + y with x = 1, y = 1 counts its own passes."""
    d = parts._aligned(16 + 8 * loops.CHAINS)
    d[:] = 1.0
    loops.multiply_add(d, 1000)
    assert np.all(d[16:] == 1000.0)


def test_the_stream_reads_and_writes_every_number():
    d = parts._aligned(loops.STREAM)
    d[:] = np.arange(loops.STREAM)
    loops.stream(d, 1)
    swapped = np.arange(loops.STREAM).reshape(-1, 2, 8)[:, ::-1].reshape(-1)
    assert np.array_equal(d, swapped)


def test_a_report_is_compared_with_an_older_one(tmp_path):
    old = {"cases": [{"name": "whole", "times_real_time": 20.0}, {"name": "gone", "times_real_time": 1.0}]}
    new = {"cases": [{"name": "whole", "times_real_time": 30.0}, {"name": "new", "times_real_time": 1.0}]}
    same = {"preset": "x", "rate_hz": 48000, "block_frames": 128, "response_s": 0.5, "machine": {"processor": "p"}}
    rows, differing = compare_reports(old | same, new | same)
    assert rows == [("whole", 20.0, 30.0, 1.5)] and differing == []
    _, differing = compare_reports(old | same | {"rate_hz": 44100}, new | same | {"machine": {"processor": "q"}})
    assert differing == ["rate_hz was 44100 and is 48000", "the processor was p and is q"]
    path = tmp_path / "old.json"
    path.write_text(json.dumps(old))
    assert read_report(path) == old


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (None, "No such file"),
        ("{", "no JSON"),
        ("[]", "no list of cases"),
        ('{"cases": [{"name": "whole", "times_real_time": 0}]}', "no list of cases"),
    ],
)
def test_a_file_that_is_no_report_is_refused(tmp_path, text, words):
    path = tmp_path / "old.json"
    if text is not None:
        path.write_text(text)
    with pytest.raises(ReportError, match=words) as error:
        read_report(path)
    assert str(path) in str(error.value)


def test_growth_is_drawn(tmp_path):
    pytest.importorskip("matplotlib")
    growths = [Growth(name, unit, np.arange(1.0, 4.0), np.arange(3.0)) for name, unit, _, _ in QUANTITIES]
    plot_growth(growths, tmp_path / "growth.png", "a guitar")
    assert (tmp_path / "growth.png").read_bytes().startswith(b"\x89PNG")


def test_a_tile_has_the_flops_that_its_sweep_does():
    """Counted from the formula at the head of sweep.py, one mode of two polarizations at a time."""
    bench = object.__new__(parts._Bench)
    bench.tiles, bench.pseudo_tiles, bench.extra = np.array([3, 2]), np.array([1, 2]), np.array([0, 3])
    modes = at.TILE * 2
    per_mode = [  # x + mu (D x), columns; a x + b x; D x; sums over columns of x* and D x, two of the tension
        2 + 2 * c + 3 + 1 + (2 * 2 * c + 2 * 2) for c in (1, 4)
    ]
    per_pseudo_mode = [2 * c + 3 + 2 * c for c in (1, 4)]
    flops, moved = bench.work()
    assert flops == modes * (3 * per_mode[0] + 2 * per_mode[1] + per_pseudo_mode[0] + 2 * per_pseudo_mode[1])
    numbers = [4 * modes + at.TILE * (3 + c) for c in (1, 4)]  # x and x* read and written; a, b, D, columns read
    pseudo = [4 * modes + at.TILE * (2 + c) for c in (1, 4)]
    assert moved == 8 * (3 * numbers[0] + 2 * numbers[1] + pseudo[0] + 2 * pseudo[1])
