#!/usr/bin/env python3
"""How far identification can be trusted: synthetic responses with known modes enter, tables of errors leave.

Table I of the paper, and bodies of 60 modes to 3 kHz (`sixty_modes` of the tests, with their closed-form responses), at
48 kHz, 2 s, with white noise below the rms of the first second:

    python tools/identify_limits.py --guitars 20 --noise 40
"""

import argparse
import pathlib
import sys
import time

import numpy as np
from rich.console import Console
from rich.progress import track
from rich.table import Table

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]

from identify.bridge_responses import errors, measure, pair_modes, sixty_modes, table_i  # noqa: E402

from ukrt.identify import identify  # noqa: E402

SECONDS = 2.0  # of a record
LEGAL = (0.0005, 0.03, 0.05)  # of frequency, damping and mass: what is asked of Table I
BANDS_HZ = (0, 700, 1000, 1250, 1500, 1750, 2000, 2250, 2500, 2750, 3000)
GAPS = (0.0, 0.5, 1.0, 1.5, 2.0, 3.0, 5.0, np.inf)  # to the nearest mode, in half-power bandwidths


def table_one(count, noise):
    """The worst error of each mode of Table I over seeds."""
    modes, began = table_i(), time.perf_counter()
    seeds = track(range(count), "Table I", console=ERR)
    found = [identify(measure(modes, seed, decibels=noise, seconds=SECONDS)) for seed in seeds]
    seconds = (time.perf_counter() - began) / count
    worst = np.max(np.abs([errors(one, modes) for one in found]), axis=0)
    shapes = np.max([np.abs(one.shapes - modes.shapes).max(axis=1) for one in found if len(one.shapes) == 10], axis=0)
    table = Table("f / Hz", "f: %", "zeta: %", "m: %", "shape", title=f"Table I, worst of {count} seeds")
    for n, hz in enumerate(modes.hz):
        table.add_row(f"{hz:g}", *(f"{100 * value:.4f}" for value in worst[:, n]), f"{shapes[n]:.5f}")
    counts = sorted({len(one.frequencies_hz) for one in found})
    return table, f"modes found: {counts}; {seconds:.2f} s each, with the making of the response"


def sixty(count, noise):
    """Per true mode of many bodies: frequency, distance to the nearest one in bandwidths, three errors, three errors
    over their uncertainties, half-power bandwidth [Hz] (rows, 9); spurious modes' frequencies; seconds each."""
    rows, spurious, began = [], [], 0.0
    for seed in track(range(count), "60 modes", console=ERR):
        modes = sixty_modes(seed)
        measurement = measure(modes, seed, decibels=noise, seconds=SECONDS)
        start = time.perf_counter()
        found = identify(measurement, max_hz=3000.0)
        began += time.perf_counter() - start
        partner, off = pair_modes(found.frequencies_hz, modes), errors(found, modes)
        order = np.argsort(modes.hz)
        gap = np.full(len(order), np.inf)
        steps = np.diff(modes.hz[order])
        gap[order] = np.minimum(np.r_[np.inf, steps], np.r_[steps, np.inf])
        sizes = (modes.hz, modes.zeta, modes.mass)
        names = ("frequencies_hz", "damping_ratios", "modal_masses")
        scores = [e * v / found.uncertainties[name][partner] for e, v, name in zip(off, sizes, names, strict=True)]
        rows.append(
            np.stack([modes.hz, gap / (2.0 * modes.half_widths_hz), *off, *scores, 2.0 * modes.half_widths_hz], axis=1)
        )
        spurious += np.delete(found.frequencies_hz, partner[partner >= 0]).tolist()
    return np.concatenate(rows), np.array(spurious), began / count


def by_class(rows, values, edges, title, name, spurious=None, guitars=1):
    """One row for each class of modes: how many were found, and their errors at quantiles; by frequency, also spurious
    modes and the modal overlap, bandwidth times modes per hertz."""
    heads = [f"{what} {q}" for what in ("f: %", "zeta: %", "m: %") for q in ("50", "90")]
    extra = ["spurious", "overlap"] if spurious is not None else []
    table = Table(name, "modes", "found", *heads, "within 0.05/3/5 %", "error/uncertainty 90", *extra, title=title)
    for low, high in zip(edges, edges[1:], strict=False):
        inside = rows[(values >= low) & (values < high)]
        if not len(inside):
            continue
        off, seen = np.abs(inside[:, 2:5]), np.isfinite(inside[:, 2])
        cells = (
            [f"{100 * np.percentile(off[seen, k], q):.3f}" for k in range(3) for q in (50, 90)]
            if seen.any()
            else [""] * 6
        )
        good = np.mean(np.all(off <= LEGAL, axis=1))
        scores = "/".join(f"{np.percentile(np.abs(inside[seen, k]), 90):.1f}" for k in (5, 6, 7)) if seen.any() else ""
        ghosts = 0 if spurious is None else np.sum((spurious >= low) & (spurious < high))
        overlap = np.sum(inside[:, 8]) / guitars / (high - low)
        last = [] if spurious is None else [str(ghosts), f"{overlap:.2f}"]
        table.add_row(
            f"{low:g} to {high:g}",
            str(len(inside)),
            f"{100 * seen.mean():.0f} %",
            *cells,
            f"{100 * good:.0f} %",
            scores,
            *last,
        )
    return table


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--guitars", type=int, default=20, help="bodies of 60 modes (default: 20)")
    parser.add_argument("--seeds", type=int, default=20, help="of the noise on Table I (default: 20)")
    parser.add_argument("--noise", type=float, default=40.0, help="dB below the rms of the first second (default: 40)")
    options = parser.parse_args()
    out = Console(width=None if sys.stdout.isatty() else 180)
    table, words = table_one(options.seeds, options.noise)
    out.print(table)
    out.print(words)
    rows, spurious, seconds = sixty(options.guitars, options.noise)
    out.print(by_class(rows, rows[:, 0], BANDS_HZ, "60 modes to 3 kHz, by frequency", "Hz", spurious, options.guitars))
    out.print(by_class(rows, rows[:, 1], GAPS, "by the distance to the nearest mode", "half-power bandwidths"))
    out.print(f"{options.guitars} bodies, {seconds:.1f} s each")


ERR = Console(stderr=True)

if __name__ == "__main__":
    main()
