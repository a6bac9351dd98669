"""Time ukrt beside its peers: the same piece, CPU time, in turns on one core.

    tools/bench_peers --install             as root: peers from Debian, then measure
    tools/bench_peers --only "ukrt,STK"     systems whose name contains one of these (and ukrt's engine)
    tools/bench_peers --json > peers.json

The piece is made by a seeded generator (tools/peers/piece.py): 60 s, 495 notes, up to six at once, all of which a hand
can play. Peers that cannot be installed, do not run or give no sound are named and left out. Without root and apt-get
install them yourself: the packages are named where they are missing.
"""

import argparse
import json
import os
import platform
import sys
import tempfile
import time

from rich.console import Console

from ukrt.benchmark.machine import describe_machine, one_core

from . import convolvers, csound, faust, fluidsynth, install, measure, paper, stk, supercollider, tables, ukrt_itself
from .peer import FLAGS, PeerError, Work

MODULES = (ukrt_itself, fluidsynth, stk, faust, supercollider, csound, paper)
PEERS = tuple(peer for module in MODULES for peer in module.PEERS)
SHORT_S = 1.0
LONG_S = 60.0


def parse(arguments):
    """The options (argparse.Namespace)."""
    head, _, rest = __doc__.partition("\n\n")
    parser = argparse.ArgumentParser(prog="tools/bench_peers", description=head, epilog=rest)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("--install", action="store_true", help="install what is missing by apt-get (as root)")
    parser.add_argument("--only", metavar="NAMES", help="parts of names, with commas between them")
    parser.add_argument("--list", action="store_true", help="print names and Debian packages, and end")
    parser.add_argument("--runs", type=_count, default=5, metavar="N", help="turns (default: %(default)s)")
    parser.add_argument("--folder", metavar="FOLDER", help="keep the piece, programs and sounds in this folder")
    parser.add_argument("--json", action="store_true", help="print JSON instead of tables")
    return parser.parse_args(arguments)


def _count(text):
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number from 1 on")
    return int(text)


def chosen(systems, only):
    """Those systems whose names contain one of the parts in ``only``; all where there is none."""
    parts = [part.strip().lower() for part in (only or "").split(",") if part.strip()]
    return [one for one in systems if not parts or any(part in one.name.lower() for part in parts)]


def prepared(peers, work, not_installed, say):
    """Those peers that are ready (dict of str to Ready), and why the others are not (dict of str to str)."""
    ready, left_out = {}, {}
    for peer in peers:
        say(f"preparing {peer.name}")
        try:
            ready[peer.name] = peer.prepare(work)
        except PeerError as error:
            why = [not_installed[name] for name in peer.packages if name in not_installed] or [str(error)]
            left_out[peer.name] = f"{why[0]} (Debian: {', '.join(peer.packages)})" if peer.packages else why[0]
    return ready, left_out


def compare(options, folder, say):
    """Everything that is asked for, as one dict."""
    peers, convolving = chosen(PEERS, options.only), chosen(convolvers.CONVOLVERS, options.only)
    if peers and PEERS[0] not in peers:
        peers.insert(0, PEERS[0])  # the ratios want it
    packages = [name for one in (*peers, *convolving) for name in one.packages]
    not_installed = install.install(packages, say) if options.install else {}
    work, began = Work(folder), time.strftime("%Y-%m-%d")
    ready, left_out = prepared(peers, work, not_installed, say)
    with one_core() as core:
        results, failed = measure.in_turns(ready, (SHORT_S, LONG_S), options.runs, work, say)
        convolved, not_convolved = convolvers.in_turns(convolving, options.runs, work, say)
    return {
        "date": began,
        "machine": describe_machine(core) | {"system": platform.platform(), "load": os.getloadavg()},
        "runs": options.runs,
        "seconds": {"short": SHORT_S, "long": LONG_S},
        "systems": tables.speed_rows(peers, ready, results),
        "convolvers": convolved,
        "notes": [one.note for name, one in ready.items() if one.note and name in results],
        "left_out": left_out | failed | not_convolved,
    }


def show(report, console):
    """Print the tables."""
    machine = report["machine"]
    load = f"load average {machine['load'][0]:.1f} at the end"
    console.print(f"{report['date']}, core {machine['core']} of {machine['processor']}, {load}\n", highlight=False)
    if report["systems"]:
        console.print(tables.speed_table(report["systems"]))
    if report["convolvers"]:
        console.print(tables.convolver_table(report["convolvers"], convolvers.TAPS))
    for line in (*report["notes"], *tables.left_out_lines(report["left_out"])):
        console.print(line, highlight=False, soft_wrap=True)
    words = tables.FAIRNESS.format(runs=report["runs"], flags=" ".join(FLAGS), **report["seconds"])
    console.print("\n" + words, highlight=False, markup=False, soft_wrap=True)


def main(arguments=None):
    """Measure and print."""
    options = parse(arguments)
    console, errors = Console(width=None if sys.stdout.isatty() else 140), Console(stderr=True, highlight=False)
    if options.list:
        for one in (*PEERS, *convolvers.CONVOLVERS):
            print(f"{one.name}: {', '.join(one.packages) or 'nothing'}")
        return

    def say(words):
        errors.print(f"bench_peers: {words}", markup=False, soft_wrap=True)

    with tempfile.TemporaryDirectory() as temporary:
        folder = options.folder or temporary
        os.makedirs(folder, exist_ok=True)
        report = compare(options, folder, say)
    if options.json:
        print(json.dumps(report, indent=1))
    else:
        show(report, console)


if __name__ == "__main__":
    main()
