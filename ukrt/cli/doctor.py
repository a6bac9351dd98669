"""``ukrt doctor``: why does it crackle? The machine's limits, the callback's load and losses, what to do about them.

The instrument's callback alternates with one that plays nothing on the same server (the difference is the instrument's
own) and, for contrast, with the same work in an ordinary Python callback.
"""

import argparse
import json

from .. import __version__
from .common import (
    UsageError,
    add_command,
    add_guitar_options,
    add_rate_option,
    add_tuning_options,
    load_guitar,
    make_console,
    make_engine,
    need_matplotlib,
)
from .play_options import DRIVERS

_EPILOG = """\
Each block size is measured under each stress for --seconds, shared by three callbacks in turns: the instrument with
all strings ringing, one that plays nothing, and the instrument called from Python. Close other programs that play.

examples:
  ukrt doctor
  ukrt doctor --block 64,128 --stress all     while Python computes, collects garbage, holds its lock
  ukrt doctor --driver jack --json > doctor.json
"""
USUAL_BLOCKS = (32, 64, 128, 256)
TURNS = 6
_SLICE_SECONDS = 2.0  # the shortest slice where there is time for more than one
_SMALLEST_SECONDS = 0.3
STRESSES = ("none", "python", "gc", "gil")


def add_parser(commands):
    """Add the subcommand to the parser."""
    parser = add_command(commands, "doctor", "find out why it crackles, and what to do about it", _EPILOG)
    parser.add_argument(
        "--seconds",
        type=_seconds,
        default=60.0,
        metavar="S",
        help="time for each block size and stress, 1 to 3600 (default: %(default)g)",
    )
    parser.add_argument(
        "--block",
        type=_blocks,
        default=None,
        metavar="N,N,..",
        help=f"block sizes in frames (default: {','.join(map(str, USUAL_BLOCKS))}; on JACK the server's own)",
    )
    parser.add_argument(
        "--stress",
        choices=(*STRESSES, "all"),
        default="none",
        help="what Python does meanwhile: nothing, computing, collecting garbage, holding its lock (default: none)",
    )
    parser.add_argument(
        "--driver",
        choices=DRIVERS,
        default=None,
        help="what to measure (default: portaudio; null without a sound card)",
    )
    add_guitar_options(parser)
    add_tuning_options(parser)
    add_rate_option(parser, None, "default: 48000 where the sound card can, else the card's own")
    parser.add_argument("--json", action="store_true", help="print exact data as JSON instead of tables")
    parser.add_argument("--plot", metavar="PNG", help="draw loads and losses into this file (needs matplotlib)")
    parser.set_defaults(run=run)


def run(args):
    """Look, measure, advise."""
    from . import doctor_report

    if args.plot:
        need_matplotlib("--plot")
    report = examine(args)
    if args.plot:
        doctor_report.draw(args.plot, report)
    if args.json:
        print(json.dumps(report, indent=2))
    else:
        doctor_report.show(report)
    return 0


def examine(args):
    """Everything that is found out, as JSON can hold it (dict)."""
    from ..drivers.doctor.advice import advise, recommend
    from ..drivers.doctor.outputs import find_outputs
    from ..drivers.doctor.system_facts import system_facts

    guitar, machine = load_guitar(args), system_facts()
    outputs, note = find_outputs(args.driver, args.rate)
    blocks, other_note = outputs.blocks(args.block, USUAL_BLOCKS)
    notes = [text for text in (note, other_note) if text]
    stresses = STRESSES if args.stress == "all" else (args.stress,)
    sources = _make_sources(guitar, outputs.sample_rate)
    cells = _measure(args, outputs, sources, blocks, stresses)
    delays = {cell["block_frames"]: cell["delay"] for cell in cells}
    output = {
        "driver": outputs.driver,
        "name": outputs.name,
        "rate_hz": outputs.sample_rate,
        "realtime": outputs.realtime,
    }
    report = {
        "ukrt": __version__,
        "preset": guitar.name,
        "machine": machine,
        "output": output,
        "notes": notes,
        "strings": len(guitar.strings),
        "strings_plucked": sources[0].strings_plucked(),
        "contacts": len(guitar.finger.contacts),
        "cells": cells,
        "recommended_block": recommend(cells),
        "advice": [{"severity": one.severity, "words": one.words} for one in advise(machine, output, cells, delays)],
    }
    for source in sources:
        if hasattr(source, "engine"):
            source.engine.close()
    return report


def turns_of(seconds):
    """How ``seconds`` [s] are shared: turns (int) of three slices, and each slice's length [s]."""
    turns = max(1, min(TURNS, int(seconds / 3 / _SLICE_SECONDS)))
    return turns, max(_SMALLEST_SECONDS, seconds / 3 / turns)


def _make_sources(guitar, rate):
    from ..drivers.doctor.sources import Compiled, Empty, Interpreted

    engines = [make_engine(guitar, rate), make_engine(guitar, rate)]
    return [Compiled(engines[0]), Empty(rate, engines[0].channels), Interpreted(engines[1])]


def _measure(args, outputs, sources, blocks, stresses):
    """One dict for each block size and stress, with a progress bar on standard error."""
    from rich.progress import Progress

    from ..drivers.doctor.measure import measure_turns

    turns, seconds = turns_of(args.seconds)
    cells = []
    console = make_console()
    # No refreshing by a thread of its own: it would disturb what is measured.
    with Progress(console=console, transient=True, auto_refresh=False, disable=not console.is_terminal) as bar:
        task = bar.add_task("", total=len(blocks) * len(stresses) * turns * len(sources))
        for block in blocks:
            with outputs.at(block):
                for stress in stresses:
                    bar.update(task, description=f"{block or 'own'} frames, {stress}", refresh=True)
                    step = lambda _: bar.update(task, advance=1, refresh=True)  # noqa: E731
                    slices = measure_turns(sources, outputs.open, stress, block, seconds, turns, step)
                    cells.append(_cell(outputs.driver, stress, block, slices, sources[0]))
    return cells


def _cell(driver, stress, block, slices, instrument):
    from ..drivers.doctor.advice import key_to_sound
    from ..drivers.doctor.measure import SOURCES, summarize, within_range
    from ..drivers.doctor.stress import WORDS
    from ..drivers.midi.host import MARGIN_SECONDS

    by_source = {name: [one for one in slices if one.source == name] for name in SOURCES}
    results = {name: summarize(own) for name, own in by_source.items()}
    frames = round(results["compiled"]["block_frames"]) or block
    rate, latency = instrument.sample_rate, results["compiled"]["latency_s"]
    margin = 0.0 if driver == "jack" else MARGIN_SECONDS
    return {
        "stress": stress,
        "words": WORDS[stress],
        "asked_block": block,
        "block_frames": frames,
        "sources": results,
        "within_range": within_range(by_source["compiled"], by_source["empty"]),
        "delay": key_to_sound(frames, rate, latency, instrument.lead_frames, margin),
        "slices": [one.to_dict() for one in slices],
    }


def _seconds(text):
    from .common import number

    return number("s", 1, 3600)(text)


def _blocks(text):
    """An argument type: block sizes such as 32,64,128."""
    try:
        blocks = [int(part) for part in text.split(",")]
    except ValueError:
        blocks = []
    if not blocks or not all(16 <= block <= 8192 for block in blocks):
        raise argparse.ArgumentTypeError(f"{text!r} is not a list of whole numbers from 16 to 8192, such as 32,64,128")
    if len(set(blocks)) != len(blocks):
        raise UsageError(f"--block: {text!r} names a block size twice")
    return sorted(blocks)
