"""``ukrt bench``: how many times faster than real time this machine computes the guitar, and which part costs what.

All strings ring and are plucked again each second; nothing sleeps. Blocks are timed one by one on one core.
"""

import contextlib
import dataclasses
import itertools
import json
import os
import platform
import time

from .common import (
    add_block_option,
    add_command,
    add_guitar_options,
    add_rate_option,
    add_tuning_options,
    load_guitar,
    make_engine,
    number,
)

_EPILOG = """\
examples:
  ukrt bench
  ukrt bench --block 64 --seconds 60
  ukrt bench --json > bench.json
"""
# Chords as frets from the bass side; on a guitar each note has only one place that leaves a string to the others. Where
# there are more strings than six they begin again.
G_MAJOR = (3, 2, 0, 0, 0, 3)
F_BARRE = (1, 3, 3, 2, 1, 1)
OPEN = (0, 0, 0, 0, 0, 0)
VELOCITY = 100
RESPONSE_SECONDS = 0.5
RUNS = 5


@dataclasses.dataclass(frozen=True)
class Case:
    """One thing to measure."""

    name: str
    words: str
    chord: tuple = G_MAJOR
    contacts: int = 3
    tension_modulation: bool = True
    signal: str = "pressure"


CASES = (
    Case("whole", "whole engine, G major, half the strings stopped, by three contacts each"),
    Case("barre", "the same with an F major barre, all strings stopped", F_BARRE),
    Case("open", "the same with open strings, no contact", OPEN),
    Case("one-contact", "whole with one contact on each stopped string", contacts=1),
    Case("linear", "whole without tension modulation (Kirchhoff-Carrier)", tension_modulation=False),
    Case("bridge-force", "whole without convolution", signal="bridge-force"),
)


def add_parser(commands):
    """Add the subcommand to the parser."""
    parser = add_command(commands, "bench", "measure how fast this machine computes the guitar", _EPILOG)
    add_guitar_options(parser)
    add_tuning_options(parser)
    add_rate_option(parser, 48000, "default: %(default)s")
    add_block_option(parser, 128, "default: %(default)s")
    parser.add_argument(
        "--seconds",
        type=number("s", 1, 600),
        default=10.0,
        metavar="S",
        help=f"sound computed in each of {RUNS} runs of each case (default: %(default)g)",
    )
    parser.add_argument("--json", action="store_true", help="print JSON instead of tables")
    parser.set_defaults(run=run)


def run(args):
    """Measure all cases and print them."""
    guitar = load_guitar(args)
    with one_core() as core:
        results = measure(CASES, guitar, args.rate, args.block, args.seconds)
    report = {
        "preset": guitar.name,
        "rate_hz": args.rate,
        "block_frames": args.block,
        "period_ms": 1e3 * args.block / args.rate,
        "response_s": RESPONSE_SECONDS,
        "seconds": args.seconds,
        "runs": RUNS,
        "machine": {"processor": _processor(), "core": core, "python": platform.python_version()},
        "cases": results,
        "parts_percent": _parts({r["name"]: r["block_us"]["p50"] for r in results}),
    }
    if args.json:
        print(json.dumps(report, indent=2))
    else:
        _print(report)
    return 0


@contextlib.contextmanager
def one_core():
    """Keep this process on the core that has least to do, where the system can; gives the core's number or None."""
    if not hasattr(os, "sched_setaffinity"):
        yield None
        return
    before = os.sched_getaffinity(0)
    first = _idle_ticks()
    time.sleep(0.3)
    last = _idle_ticks()
    core = max(before, key=lambda number: (last.get(number, 0) - first.get(number, 0), number))
    os.sched_setaffinity(0, {core})
    try:
        yield core
    finally:
        os.sched_setaffinity(0, before)


def measure(cases, guitar, rate, block, seconds):
    """Run all cases in turns, so that what else the machine does falls on all of them alike.

    Returns
    -------
    list of dict
        For each case the times real time (median and all runs) and quantiles of the blocks' times [us].
    """
    import numpy as np

    from ..model.fingerboard import fingerboard

    engines = [
        make_engine(_variant(c, guitar), rate, signal=c.signal, impulse_response=_response(c, guitar, rate))
        for c in cases
    ]
    open_keys = fingerboard(guitar).open_keys
    chords = [[key + fret for key, fret in zip(open_keys, itertools.cycle(c.chord), strict=False)] for c in cases]
    n_blocks = max(1, int(round(seconds * rate / block)))
    outs = [np.zeros((block, engine.channels)) for engine in engines]
    for chord, engine, out in zip(chords, engines, outs, strict=True):
        _play(engine, chord, out, int(round(rate / block)))  # a second to warm up
    times = np.zeros((len(cases), RUNS, n_blocks))  # ns
    for turn in range(RUNS):
        for k, (chord, engine, out) in enumerate(zip(chords, engines, outs, strict=True)):
            times[k, turn] = _play(engine, chord, out, n_blocks)
    results = []
    for k, (case, engine) in enumerate(zip(cases, engines, strict=True)):
        speeds = n_blocks * block / rate / (times[k].sum(axis=1) * 1e-9)
        quantiles = np.quantile(times[k] * 1e-3, (0.5, 0.99, 0.999, 1.0))
        plucked = {note["string"] for note in engine.note_log() if note["string"] is not None}
        results.append(
            {
                "name": case.name,
                "words": case.words,
                "strings_plucked": len(plucked),
                "times_real_time": float(np.median(speeds)),
                "times_real_time_runs": [float(s) for s in speeds],
                "block_us": dict(zip(("p50", "p99", "p99.9", "max"), map(float, quantiles), strict=True)),
            }
        )
        engine.close()
    return results


def _play(engine, chord, out, n_blocks):
    """Compute ``n_blocks`` blocks, the chord plucked again each second; returns each block's time [ns]."""
    times, block, second = [], len(out), int(engine.sample_rate)
    next_pluck = engine.frame
    for _ in range(n_blocks):
        if engine.frame + block > next_pluck:
            for note in chord:
                engine.send(next_pluck, 0x90, note, VELOCITY)
            next_pluck += second
        start = time.perf_counter_ns()
        engine.process_into(out)
        times.append(time.perf_counter_ns() - start)
    return times


def _variant(case, guitar):
    """The guitar with what the case leaves out."""
    finger = dataclasses.replace(guitar.finger, contacts=guitar.finger.contacts[: case.contacts])
    strings = guitar.strings
    if not case.tension_modulation:
        strings = tuple(dataclasses.replace(s, axial_stiffness=0.0) for s in strings)
    return dataclasses.replace(guitar, finger=finger, strings=strings)


def _response(case, guitar, rate):
    """The guitar's impulse response, cut or continued with zeros to the length that is measured."""
    import numpy as np

    from ..radiation.impulse_response import load_impulse_response

    if case.signal != "pressure":
        return None
    response = load_impulse_response(guitar.radiation.impulse_response, rate)
    samples = np.zeros((int(round(RESPONSE_SECONDS * rate)), 2, 2))
    taps = min(len(samples), len(response.samples))
    samples[:taps] = response.samples[:taps]
    return dataclasses.replace(response, samples=samples)


def _parts(cost):
    """Share of each part in a block of the whole engine [%], from pairs of cases that differ only in it.

    Taken from the median block, which other processes on the machine hardly touch.
    """
    whole = cost["whole"]
    shares = {
        "convolution": whole - cost["bridge-force"],
        "tension modulation": whole - cost["linear"],
        "contacts of the three stopped strings": whole - cost["open"],
        "of these, the second and third contact": whole - cost["one-contact"],
        "open strings and body": cost["open"] + cost["bridge-force"] + cost["linear"] - 2 * whole,
    }
    return {name: 100.0 * share / whole for name, share in shares.items()}


def _idle_ticks():
    """Idle time of each core so far (dict of int); empty where the system does not tell."""
    with contextlib.suppress(OSError), open("/proc/stat", encoding="ascii") as lines:
        rows = [line.split() for line in lines if line.startswith("cpu") and line[3].isdigit()]
        return {int(row[0][3:]): int(row[4]) for row in rows}
    return {}


def _processor():
    with contextlib.suppress(OSError), open("/proc/cpuinfo", encoding="utf-8") as lines:
        for line in lines:
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def _print(report):
    from rich import box
    from rich.console import Console
    from rich.table import Table

    console = Console(highlight=False, soft_wrap=True)
    console.print(
        f"{report['preset']} at {report['rate_hz']} Hz, blocks of {report['block_frames']} frames "
        f"({1e3 * report['period_ms']:.0f} us), {report['response_s']:g} s of stereo convolution;\n"
        f"median of {report['runs']} runs of {report['seconds']:g} s on one core of {report['machine']['processor']};\n"
        "times of blocks in us"
    )
    table = Table(box=box.SIMPLE)
    table.add_column("case", no_wrap=True)
    for name in ("x real time", "p50", "p99", "p99.9", "max", "p99.9 of period"):
        table.add_column(name, justify="right", no_wrap=True)
    for case in report["cases"]:
        times = case["block_us"]
        share = f"{0.1 * times['p99.9'] / report['period_ms']:.1f} %"
        table.add_row(case["name"], f"{case['times_real_time']:.1f}", *(f"{t:.0f}" for t in times.values()), share)
    console.print(table)
    for case in report["cases"]:
        console.print(f"  {case['name']:<13} {case['words']}")
    parts = Table(box=box.SIMPLE)
    parts.add_column("part")
    parts.add_column("of a median block", justify="right")
    for name, percent in report["parts_percent"].items():
        parts.add_row(name, f"{percent:.0f} %")
    console.print(parts)
