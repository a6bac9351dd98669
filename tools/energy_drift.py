#!/usr/bin/env python3
"""Fig. 6 for a minute: how constant the total energy is, and how well constraints hold, in both solvers.

python tools/energy_drift.py --seconds 60
"""

import argparse
import os
import pathlib
import sys

os.environ.setdefault("OMP_NUM_THREADS", "1")
ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]

import numpy as np  # noqa: E402
from reference.small_cases import fig_6  # noqa: E402
from rich.console import Console  # noqa: E402
from rich.progress import Progress  # noqa: E402
from rich.table import Table  # noqa: E402

from ukrt.experiment.case import Record  # noqa: E402
from ukrt.simulate.run import SOLVERS, simulate  # noqa: E402

KEPT_HZ = 4000.0


def measured(result):
    """Words and numbers about the total energy after the pluck, seen second by second."""
    total = result.column("energies", "total")[result.times > 0.011]
    seconds = [part.mean() for part in np.array_split(total, max(2, int(result.case.duration)))]
    return (
        f"{1e3 * total.mean():.5f} mJ",
        f"{np.ptp(total) / total.mean():.1e}",
        f"{seconds[-1] / seconds[0] - 1.0:+.1e}",
        f"{result['drift'][result.times <= 1.0].max():.1e} m",
        f"{result.facts['largest_drift_m']:.1e} m",
        f"{result.facts['seconds_taken']:.1f} s",
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=60.0, help="how long (default: %(default)g)")
    options = parser.parse_args()
    one = fig_6(duration=options.seconds, record=Record(rate_hz=KEPT_HZ, bridge_force=False, energies=True))
    heads = "total energy", "it varies by", "last second over first", "drift in 1 s", "drift", "time taken"
    table = Table("solver", *heads, title=f"Fig. 6 over {options.seconds:g} s")
    with Progress(console=Console(stderr=True), transient=True) as bar:
        for solver in SOLVERS:
            task = bar.add_task(solver, total=1.0)
            result = simulate(one, solver, lambda share, task=task: bar.update(task, completed=share))
            step = f"{result.facts['step_s']:.3g} s"
            table.add_row(f"{solver}, {step}", *measured(result))
    Console(width=None if sys.stdout.isatty() else 140).print(table)


if __name__ == "__main__":
    main()
