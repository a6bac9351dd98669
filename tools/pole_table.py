#!/usr/bin/env python3
"""The table of poles: every string, fret and finger, the engine's own motion against the tests' oracle, and the worst.

Enter a sample rate; leave, for the classical preset's body with all six strings, the errors of pitch [cents] and decay
rate [%] of partials 1-5 and 8. Oracle and measuring tools come from the checkout's ``tests``, put on the path here:

    python tools/pole_table.py --rate 48000
"""

import argparse
import json
import pathlib
import sys
import time

from rich.console import Console
from rich.progress import track
from rich.table import Table

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]

from engine.kernel_poles_setup import FRETS, PARTIALS, Note, broken_limits, compare  # noqa: E402


def all_notes(polarization):
    """Six strings, open and at every fret of the list with one and with three contacts."""
    fingers = {fret: (1, 3) if fret else (0,) for fret in FRETS}
    return [Note(s, fret, n, polarization) for n in (0, 1, 3) for s in range(6) for fret in FRETS if n in fingers[fret]]


def as_record(result):
    """A `Comparison` as plain numbers for JSON."""
    note = result.note
    return {
        "string": note.string,
        "fret": note.fret,
        "contacts": note.n_contacts,
        "polarization": note.polarization,
        "partials": list(result.partials),
        "frequencies_hz": result.frequencies_hz.tolist(),
        "decay_rates": result.decay_rates.tolist(),
        "cents": result.cents.tolist(),
        "decay_errors": result.decay_errors.tolist(),
    }


def notes_table(results):
    """Every note in one row: cents, then per cent of the decay rate."""
    table = Table("note", *(f"{n}: cents" for n in PARTIALS), *(f"{n}: %" for n in PARTIALS))
    for result in results:
        by_partial = dict(zip(result.partials, zip(result.cents, result.decay_errors, strict=True), strict=True))
        cells = [by_partial.get(n) for n in PARTIALS]
        cents = [f"{cell[0]:.3f}" if cell else "above the basis" for cell in cells]
        losses = [f"{100 * cell[1]:.2f}" if cell else "" for cell in cells]
        table.add_row(str(result.note), *cents, *losses)
    return table


def worst_table(results):
    """For each number of contacts and each partial the largest errors and the notes they belong to."""
    table = Table("contacts", "partial", "worst cents", "of", "worst decay %", "of")
    for n_contacts in (0, 1, 3):
        for n in PARTIALS:
            rows = [
                (result.cents[k], result.decay_errors[k], str(result.note))
                for result in results
                if result.note.n_contacts == n_contacts
                for k, partial in enumerate(result.partials)
                if partial == n
            ]
            cents, loss = max(rows, key=lambda row: abs(row[0])), max(rows, key=lambda row: abs(row[1]))
            table.add_row(str(n_contacts), str(n), f"{cents[0]:+.4f}", cents[2], f"{100 * loss[1]:+.3f}", loss[2])
    return table


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rate", type=float, default=48000.0, help="sample rate [Hz] (default: 48000)")
    parser.add_argument("--polarization", choices=("Y", "Z"), default="Y", help="Y meets the body, Z does not")
    parser.add_argument("--json", action="store_true", help="print the whole table as JSON instead")
    options = parser.parse_args()
    began, console = time.perf_counter(), Console(stderr=True)
    notes = all_notes(options.polarization)
    results = [compare(note, options.rate) for note in track(notes, "notes", console=console)]
    seconds = time.perf_counter() - began
    broken = [words for result in results for words in broken_limits(result)]
    if options.json:
        rows = [as_record(result) for result in results]
        table = {"sample_rate": options.rate, "seconds": seconds, "notes": rows, "broken_limits": broken}
        print(json.dumps(table, indent=1))
    else:
        out = Console(width=None if sys.stdout.isatty() else 180)
        out.print(notes_table(results))
        out.print(worst_table(results))
        out.print(f"{len(results)} notes at {options.rate:g} Hz in {seconds:.0f} s; limits broken: {len(broken)}")
        for words in broken:
            out.print(words, highlight=False)
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())
