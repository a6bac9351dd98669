#!/usr/bin/env python3
"""Prove that live playing keeps its promises: each subcommand starts its own JACK server, measures, prints and writes.

    python tools/prove_live.py xruns    compiled, empty and Python callbacks under four stresses, four block sizes
    python tools/prove_live.py latency  from a MIDI event of one JACK client to a recording made by another, 1000 events
    python tools/prove_live.py midi     1000 messages a second for a minute, and bursts of 2000: lost, late, order
    python tools/prove_live.py dense    ten minutes of dense playing: counters, memory

Everything runs on jackd's dummy driver at 48 kHz, with real-time priority where that is allowed.
"""

import argparse
import json
import pathlib
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from prove import cells
from prove.server import ProofError

from ukrt.errors import UkrtError

STRESSES = ("none", "python", "gc", "gil")


def parse(arguments):
    """The options (argparse.Namespace)."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0], epilog=__doc__.split("\n", 1)[1])
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    commands = parser.add_subparsers(dest="command", required=True)
    for name, words in (("xruns", "proof 1"), ("cells-worker", "used by xruns")):
        one = commands.add_parser(name, help=words)
        one.add_argument("--blocks", type=_numbers, default=[32, 64, 128, 256], help="such as 32,64")
        one.add_argument("--stresses", type=_stresses, default=list(STRESSES), help="such as none,gc")
        one.add_argument("--slice-seconds", type=float, default=10.0, help="length of each slice (default: 10)")
        one.add_argument("--turns", type=int, default=6, help="slices of each callback (default: 6)")
        one.add_argument("--driver", choices=("portaudio", "jack"), default="portaudio")
    for one in commands.choices.values():
        one.add_argument("--json", metavar="FILE", help="write all numbers to this file")
    return parser.parse_args(arguments)


def _numbers(text):
    return [int(part) for part in text.split(",")]


def _stresses(text):
    names = text.split(",")
    if not set(names) <= set(STRESSES):
        raise argparse.ArgumentTypeError(f"{text!r} is not a list out of {','.join(STRESSES)}")
    return names


def prove_xruns(options, console):
    """Proof 1."""
    results = cells.run(options, console.print)
    console.print(cells.table(results))
    return {"cells": results, "verdict": cells.verdict(results)}


PROOFS = {"xruns": prove_xruns}
WORKERS = {"cells-worker": cells.work}


def main(arguments=None):
    """Run one proof."""
    options = parse(arguments)
    if options.command in WORKERS:
        WORKERS[options.command](options)
        return
    from rich.console import Console

    console, began = Console(highlight=False, soft_wrap=True), time.time()
    if not console.is_terminal:
        console.width = 120
    try:
        result = PROOFS[options.command](options, console)
    except (ProofError, UkrtError, OSError) as error:
        sys.exit(f"prove_live: {error}")
    console.print_json(json.dumps(result["verdict"]))
    if options.json:
        head = {"command": options.command, "began": began, "seconds": time.time() - began}
        pathlib.Path(options.json).write_text(json.dumps(head | result, indent=1) + "\n")


if __name__ == "__main__":
    main()
