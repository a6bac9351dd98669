#!/usr/bin/env python3
"""Waveforms of the engine beside the reference's, same basis: how the difference shrinks with the step.

Six strings on the body, E2 stopped at 0.2509 L, plucked obliquely; linear with 5 N, stretched with 1, 5 and 20 N. What
is compared with is the reference in the limit of its step: Richardson from 1/960000 s and half of that, its order
being 2.

    python tools/compare_waveforms.py --plot waveforms.png
"""

import argparse
import os
import pathlib
import sys
from dataclasses import replace

os.environ.setdefault("OMP_NUM_THREADS", "1")
ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]

from reference.small_cases import EVERYTHING, case  # noqa: E402
from rich.console import Console  # noqa: E402
from rich.table import Table  # noqa: E402
from simulate.waveforms import COMMON_HZ, engine_at, limit_of, orders, reference_at  # noqa: E402

from ukrt.experiment.case import ForceRamp  # noqa: E402

ENGINE_HZ = (48e3, 96e3, 192e3)
PAPER_HZ, FINE_HZ = 96e3, 960e3  # steps of the paper's size, 1.04e-5 s, and a tenth of it, at instants both share
SHOWN = ("displacement", "displacement, smoothed", "bridge_force", "bridge_force, smoothed", "tension", "energies")


def plucked(force, stretched, seconds):
    """The experiment with a pluck of ``force`` [N] in Y and half of it in Z."""
    pluck = ForceRamp("E2", 0.9, 0.0, 0.010, force, 0.5 * force)
    record = replace(EVERYTHING, amplitudes=False)
    changes = {"strings": (), "plucks": (pluck,), "tension_modulation": stretched, "duration": seconds}
    return case(record=record, **changes)


def compare(one, residual):
    """Rows of words and differences from the limit (dicts); and the waveforms of limit and engine."""
    fine, finer = (reference_at(one, rate) for rate in (FINE_HZ, 2.0 * FINE_HZ))
    limit = limit_of(fine, finer)
    runs = [engine_at(one, rate, residual) for rate in ENGINE_HZ]
    errors = [run.difference(limit) for run in runs]
    rows = [(f"engine at {rate / 1e3:g} kHz", found) for rate, found in zip(ENGINE_HZ, errors, strict=True)]
    rows.append(("reference, 1.04e-5 s", reference_at(one, PAPER_HZ).difference(limit)))
    rows.append(("reference, 1.04e-6 s", fine.difference(limit)))
    return rows, orders(errors), limit, runs


def add_to(table, words, rows, order):
    """One case as rows of the table."""
    for label, found in rows:
        table.add_row(words, label, *(f"{found[name]:.1e}" if found[name] else "-" for name in SHOWN))
        words = ""
    cells = [" ".join(f"{value:.2f}" for value in order[name]) if rows[0][1][name] else "-" for name in SHOWN]
    table.add_row("", "order of the engine", *cells, end_section=True)


def draw(path, drawn):
    """Displacement of each case: the limit, and what the engine differs by at each rate."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot as plt

    figure, axes = plt.subplots(len(drawn), 2, figsize=(11, 2.4 * len(drawn)), sharex=True, layout="constrained")
    for (left, right), (words, limit, runs) in zip(axes, drawn, strict=True):
        theirs = limit.arrays["displacement"][:, 0]
        milliseconds = [1e3 * k / COMMON_HZ for k in range(len(theirs))]
        left.plot(milliseconds, 1e3 * theirs, lw=0.7)
        left.set(ylabel="Y at 0.6 L [mm]", title=words)
        for rate, run in zip(ENGINE_HZ, runs, strict=True):
            ours = run.arrays["displacement"][:, 0]
            right.semilogy(milliseconds, 1e3 * abs(ours - theirs) + 1e-12, lw=0.5, label=f"{rate / 1e3:g} kHz")
        right.set(ylabel="engine's difference [mm]", ylim=(1e-8, 1.0))
    axes[0, 1].legend()
    for axis in axes[-1]:
        axis.set(xlabel="time [ms]")
    figure.savefig(path, dpi=110)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=0.1, help="compared time [s] (default: %(default)s)")
    parser.add_argument("--residual", action="store_true", help="the engine with its pseudo-modes, as it plays")
    parser.add_argument("--plot", metavar="FILE", help="draw the waveforms too (needs the extra plot)")
    options = parser.parse_args()
    table = Table(
        "case", "solver", *SHOWN, title="relative rms differences from the reference in the limit of its step"
    )
    drawn = []
    for force, stretched in ((5.0, False), (1.0, True), (5.0, True), (20.0, True)):
        words = f"{force:g} N, {'stretched' if stretched else 'linear'}"
        rows, order, limit, runs = compare(plucked(force, stretched, options.seconds), options.residual)
        add_to(table, words, rows, order)
        drawn.append((words, limit, runs))
    Console(width=None if sys.stdout.isatty() else 170).print(table)
    if options.plot:
        draw(options.plot, drawn)


if __name__ == "__main__":
    main()
