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

from prove import cells, delay, dense, flood, guitar, probe
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
    _add_latency(commands.add_parser("latency", help="proof 2"))
    _add_midi(commands.add_parser("midi", help="proof 4"))
    _add_dense(commands.add_parser("dense", help="proof 6"))
    worker = commands.add_parser("play-worker", help="used by the others")
    worker.add_argument("--stress", choices=STRESSES, default="none")
    worker.add_argument("arguments", nargs="*")
    commands.add_parser("probe-worker", help="used by the others")
    for one in commands.choices.values():
        one.add_argument("--json", metavar="FILE", help="write all numbers to this file")
    return parser.parse_args(arguments)


def _add_latency(one):
    one.add_argument("--ways", type=_ways, default=list(delay.WAYS), help="such as jack (default: jack,portaudio)")
    one.add_argument("--blocks", type=_numbers, default=[128], help="periods of the server (default: 128)")
    one.add_argument("--events", type=int, default=1000, help="notes for each way and period (default: 1000)")
    one.add_argument("--stress", choices=STRESSES, default="none", help="in the guitar's main process (default: none)")


def _add_midi(one):
    one.add_argument("--ways", type=_ways, default=list(delay.WAYS), help="such as jack (default: jack,portaudio)")
    one.add_argument("--stresses", type=_stresses, default=list(STRESSES), help="such as none,gc")
    one.add_argument("--block", type=int, default=64, help="period of the server (default: 64)")
    one.add_argument("--rate", type=int, default=1000, help="messages a second (default: 1000)")
    one.add_argument("--seconds", type=float, default=60.0, help="of each steady stream (default: 60)")


def _add_dense(one):
    one.add_argument("--ways", type=_ways, default=list(delay.WAYS), help="such as jack (default: jack,portaudio)")
    one.add_argument("--block", type=int, default=64, help="period of the server (default: 64)")
    one.add_argument("--seconds", type=float, default=600.0, help="of playing, each way (default: 600)")
    one.add_argument("--every", type=float, default=2.0, help="seconds between two looks at the memory (default: 2)")


def _ways(text):
    return _words(text, delay.WAYS)


def _words(text, legal):
    names = text.split(",")
    if not set(names) <= set(legal):
        raise argparse.ArgumentTypeError(f"{text!r} is not a list out of {','.join(legal)}")
    return names


def _numbers(text):
    return [int(part) for part in text.split(",")]


def _stresses(text):
    return _words(text, STRESSES)


def prove_xruns(options, console):
    """Proof 1."""
    results = cells.run(options, console.print)
    console.print(cells.table(results))
    return {"cells": results, "verdict": cells.verdict(results)}


def prove_latency(options, console):
    """Proof 2."""
    results = delay.run(options, console.print)
    verdict = [
        {name: one[name] for name in ("way", "block", "stress", "sent", "measured")}
        | {name: {k: v for k, v in (one[name] or {}).items() if k != "counts"} for name in ("event", "cycle")}
        for one in results
    ]
    return {"results": results, "verdict": verdict}


def prove_midi(options, console):
    """Proof 4."""
    results = flood.run(options, console.print)
    return {"results": results, "verdict": flood.verdict(results)}


def prove_dense(options, console):
    """Proof 6."""
    results = dense.run(options, console.print)
    return {"results": results, "verdict": dense.verdict(results)}


PROOFS = {"xruns": prove_xruns, "latency": prove_latency, "midi": prove_midi, "dense": prove_dense}
WORKERS = {"cells-worker": cells.work, "play-worker": guitar.work, "probe-worker": probe.work}


def _compile():
    """Load all compiled code once here, so that no process has to compile while it is measured."""
    import ukrt
    from ukrt.engine.kernels import idle

    ukrt.Synth().process(64)
    assert idle.count_blocks.address


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
        _compile()
        result = PROOFS[options.command](options, console)
    except (ProofError, UkrtError, OSError) as error:
        sys.exit(f"prove_live: {error}")
    console.print_json(json.dumps(result["verdict"]))
    if options.json:
        head = {"command": options.command, "began": began, "seconds": time.time() - began}
        pathlib.Path(options.json).write_text(json.dumps(head | result, indent=1) + "\n")


if __name__ == "__main__":
    main()
