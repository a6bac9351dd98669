#!/usr/bin/env python3
"""The table of poles: every string, fret and finger, either solver's motion against the tests' oracle, and the worst.

For the classical preset's body with all six strings, linear: errors of pitch [cents] and decay rate [%] of partials 1-5
and 8. Oracle and measuring tools come from the checkout's ``tests``, put on the path here:

    python tools/pole_table.py                                                    # the engine at 48 kHz
    python tools/pole_table.py --rates 44100,48000,96000 --solver both --jobs 4 --plot accuracy.png
"""

import argparse
import json
import pathlib
import sys
import time

from rich.console import Console

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]

from accuracy import CONTACTS, PAPER, Scheme, all_notes  # noqa: E402
from accuracy_tables import options as kinds  # noqa: E402
from accuracy_tables.plot import draw  # noqa: E402
from accuracy_tables.record import as_record  # noqa: E402
from accuracy_tables.tables import beside_table, broken, exceptions, notes_table, worst_table  # noqa: E402
from accuracy_tables.work import compare_all  # noqa: E402

RATES = (44100.0, 48000.0, 88200.0, 96000.0, 192000.0)
LIMITS_AT = 48000.0  # Hz: the rate that the project's limits are stated for


def parse(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--solver", choices=("engine", "reference", "both"), default="engine")
    lists = {  # name: (type, default, help)
        "--rates": (kinds.one_of_each(RATES), "48000", "of the engine [Hz]"),
        "--frets": (kinds.whole_numbers(0, 19), "0-19", "such as 0,5,12"),
        "--contacts": (kinds.one_of_each(CONTACTS), "0,1,3,5", "of the finger; 0: open strings"),
    }
    for name, (kind, default, words) in lists.items():
        parser.add_argument(name, type=kind, default=default, metavar="LIST", help=f"{words} (default: {default})")
    parser.add_argument("--polarization", choices=("Y", "Z"), default="Y", help="Y meets the body, Z does not")
    parser.add_argument("--jobs", type=kinds.jobs, default=1, help="processes (default: 1)")
    parser.add_argument("--short", action="store_true", help="without the row of every note")
    parser.add_argument("--json", type=kinds.file("json"), metavar="FILE.json", help="write all numbers to this file")
    parser.add_argument("--plot", type=kinds.picture, metavar="FILE.png", help="draw the errors over the frets")
    return parser.parse_args(arguments)


def report(options, results, seconds):
    """Print the tables; what is broken and where the engine is not the better one, by name."""
    out = Console(width=None if sys.stdout.isatty() else 200)
    if not options.short:
        out.print(notes_table(results))
    out.print(worst_table(results))
    if options.solver == "both":
        out.print(beside_table(results))
        words = exceptions(results)
        out.print(f"the engine's error is not below the paper's: {len(words)}", *words, sep="\n", highlight=False)
    for scheme, words in broken(results).items():
        about = "limits broken" if scheme.rate == LIMITS_AT else "beyond the limits that are stated for 48 kHz"
        out.print(f"{scheme}: {about}: {len(words)}", *words, sep="\n", highlight=False)
    out.print(f"{len(results)} comparisons in {seconds:.0f} s", highlight=False)


def main():
    options = parse()
    began = time.perf_counter()
    notes = all_notes(options.frets, tuple(int(n) for n in options.contacts), polarization=options.polarization)
    schemes = [Scheme("engine", rate) for rate in options.rates] if options.solver != "reference" else []
    schemes += [PAPER] if options.solver != "engine" else []
    results = compare_all([(note, scheme) for note in notes for scheme in schemes], options.jobs)
    results.sort(key=lambda result: schemes.index(result.scheme))  # stable: notes keep their order
    seconds = time.perf_counter() - began
    if options.plot:
        draw(options.plot, results)
    if options.json:
        words = {str(scheme): found for scheme, found in broken(results).items()}
        rows = [as_record(result) for result in results]
        options.json.write_text(json.dumps({"seconds": seconds, "notes": rows, "beyond_limits": words}, indent=1))
    report(options, results, seconds)
    return 1 if any(words for scheme, words in broken(results).items() if scheme.rate == LIMITS_AT) else 0


if __name__ == "__main__":
    sys.exit(main())
