#!/usr/bin/env python3
"""How long each solver takes for one and the same case, on one core: medians of several runs, taken in turn.

python tools/solver_times.py --seconds 0.5 --runs 5
"""

import argparse
import os
import pathlib
import sys

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ[name] = "1"
ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]

import numpy as np  # noqa: E402
from reference.small_cases import fig_6  # noqa: E402
from rich.console import Console  # noqa: E402
from rich.table import Table  # noqa: E402

from ukrt.experiment.case import Record  # noqa: E402
from ukrt.reference.solver import simulate as reference  # noqa: E402
from ukrt.simulate.on_engine import simulate as engine  # noqa: E402

SOLVERS = {
    "reference, plain NumPy, 1e-5 s": lambda case: reference(case, "numpy"),
    "reference, compiled, 1e-5 s": lambda case: reference(case, "compiled"),
    "engine, 48 kHz": engine,
}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=0.5, help="simulated time (default: %(default)g)")
    parser.add_argument("--runs", type=int, default=5, help="of each solver (default: %(default)s)")
    options = parser.parse_args()
    changes = {"losses": True, "tension_modulation": True, "record": Record(rate_hz=48000.0)}
    one = fig_6(duration=options.seconds, **changes)
    taken = {name: [] for name in SOLVERS}
    for run in SOLVERS.values():  # compiles what is not yet compiled
        run(fig_6(duration=0.01, **changes))
    for _ in range(options.runs):
        for name, run in SOLVERS.items():
            taken[name].append(run(one).facts["seconds_taken"])
    medians = {name: float(np.median(times)) for name, times in taken.items()}
    fastest = min(medians.values())
    table = Table("solver", "median", "from", "to", "times real time", "times the fastest")
    for name, times in taken.items():
        spread = [f"{value:.3f} s" for value in (medians[name], min(times), max(times))]
        table.add_row(name, *spread, f"{options.seconds / medians[name]:.3g}", f"{medians[name] / fastest:.3g}")
    Console(width=None if sys.stdout.isatty() else 120).print(table)


if __name__ == "__main__":
    main()
