#!/usr/bin/env python3
"""Convergence of both solvers with the basis and with the step: poles of a few telling notes against the tests' oracle.

Each note's string is alone on the body, so that no other string's poles come between. For the reference the two errors
are kept apart: what the basis leaves out (the oracle cut alike, in continuous time) and what velocity-Verlet does
(measured poles against the oracle cut alike), beside its closed form (omega dt)^2 / 24.

    python tools/convergence_table.py --jobs 2 --plot convergence.png
"""

import argparse
import json
import pathlib
import sys

from rich.console import Console

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]

from accuracy import Note, Scheme  # noqa: E402
from accuracy_tables import options as kinds  # noqa: E402
from accuracy_tables.convergence import basis_table, draw, engine_table, step_table  # noqa: E402
from accuracy_tables.record import as_record  # noqa: E402
from accuracy_tables.work import compare_all  # noqa: E402

NOTES = (
    Note(0, 0, 0, alone=True),
    Note(5, 0, 0, alone=True),
    Note(5, 19, 1, alone=True),
    Note(2, 7, 3, alone=True),
)
BASES = (5e3, 7e3, 10e3, 14e3, 20e3)  # Hz
STEPS = (2e-5, 1e-5, 5e-6, 2.5e-6)  # s, of the reference; Verlet's limit for 10 kHz is 3.2e-5 s
RATES = (44100.0, 48000.0, 88200.0, 96000.0, 192000.0)  # Hz, of the engine


def schemes():
    """Every scheme that is run, each once."""
    found = [Scheme("reference", basis_hz=basis) for basis in BASES]
    found += [Scheme("reference", step=step) for step in STEPS]
    found += [Scheme("engine", rate, basis_hz=basis) for rate in (48000.0, 96000.0) for basis in BASES]
    found += [Scheme("engine", rate) for rate in RATES]
    return list(dict.fromkeys(found))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--jobs", type=kinds.jobs, default=1, help="processes (default: 1)")
    parser.add_argument("--json", type=kinds.file("json"), metavar="FILE.json", help="write all numbers to this file")
    parser.add_argument("--plot", type=kinds.picture, metavar="FILE.png", help="draw errors over basis and step")
    options = parser.parse_args()
    results = compare_all([(note, scheme) for note in NOTES for scheme in schemes()], options.jobs, theory=True)
    out = Console(width=None if sys.stdout.isatty() else 160)
    for table in (basis_table, step_table, engine_table):
        out.print(table(results))
    if options.plot:
        draw(options.plot, results)
    if options.json:
        options.json.write_text(json.dumps([as_record(result) for result in results], indent=1))
    return 0


if __name__ == "__main__":
    sys.exit(main())
