"""Play a million random messages of every kind and look for what is stuck afterwards: seeds enter, a table leaves.

    python tools/stuck_notes.py [--events N] [--rates 100,1000,20000] [--presets NAME,..] [--modes NAME,..]
                                [--seeds 1,2] [--signal NAME]

The messages (tests/engine/storm.py: all channels, statuses, controllers and bytes, registered parameters, system
messages) are shared out among presets, idle strings open and damped, modes, rates in messages a second, and seeds.
After each share CC 123 comes on every channel, then every pedal goes up; half a second later there must be no note,
finger, damper, touch, bend or gesture that was not there before the first message. From then on energy must fall in
every 10 ms, and not more slowly than the slowest mode alone. What is not so is printed, and the exit code is 1.
"""

import argparse
import itertools
import pathlib
import sys
import time

import numpy as np
from rich.console import Console
from rich.table import Table

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "tests"))

from engine.storm import storm

from ukrt.engine.engine import Engine
from ukrt.errors import UkrtError
from ukrt.model.parameters import MIDI_MODES
from ukrt.model.presets import load_preset

COLUMNS = ("preset", "idle", "mode", "a second", "seed", "messages", "sound", "notes", "stolen", "slurred", "pedalled")
REST_SECONDS = 10.0


def parse(arguments):
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--events", type=int, default=1_000_000, help="messages in all (default: 1000000)")
    parser.add_argument("--rates", default="100,1000,20000", help="messages a second (default: 100,1000,20000)")
    parser.add_argument("--presets", default="classical,ukulele,eight-string", help="(default: %(default)s)")
    parser.add_argument("--modes", default=",".join(MIDI_MODES), help="of MIDI (default: %(default)s)")
    parser.add_argument("--seeds", default="1,2", help="(default: 1,2)")
    parser.add_argument("--signal", default="pressure", help="pressure, bridge-force or strings (default: pressure)")
    options = parser.parse_args(arguments)
    try:
        options.rates = [float(one) for one in options.rates.split(",")]
        options.seeds = [int(one) for one in options.seeds.split(",")]
    except ValueError:
        parser.error("--rates and --seeds: numbers with commas between them are needed")
    if options.events < 1 or min(options.rates) <= 0.0:
        parser.error("--events and --rates: numbers above 0 are needed")
    return options


def guitars(options):
    """Preset, what its idle strings do, and mode (list of tuples of str)."""
    return list(itertools.product(options.presets.split(","), ("open", "damped"), options.modes.split(",")))


def shares(options):
    """How many messages each rate gets: a third of all come at the fastest, the others last equally long (dict)."""
    each = options.events / (len(guitars(options)) * len(options.seeds))
    slower = sorted(options.rates)[:-1]
    counts = {rate: max(round(each * 2 / 3 * rate / sum(slower)), 1) for rate in slower}
    return counts | {max(options.rates): max(round(each) - sum(counts.values()), 1)}


def row(outcome):
    counts = outcome.counters
    fell = 10.0 * np.log10(np.array([outcome.after_j, outcome.rests_j[-1]]) / outcome.before_j)
    yield f"{outcome.sound_s:.0f} s"
    yield from (str(counts[name]) for name in ("notes_played", "notes_stolen", "notes_slurred"))
    yield str(outcome.pedalled)
    yield from (f"{level:.0f} dB" for level in fell)


def run(options, console):
    """Play all shares; returns whether all was well."""
    table = Table(*COLUMNS, "after 0.5 s", f"{REST_SECONDS:g} s later")
    began, sent, well = time.perf_counter(), 0, True
    for preset, idle, mode in guitars(options):
        settings = {"playing.idle_strings": idle, "playing.midi_mode": mode}
        engine = Engine(load_preset(preset, settings), signal=options.signal)
        for (rate, count), seed in itertools.product(shares(options).items(), options.seeds):
            outcome = storm(engine, seed, count, rate, REST_SECONDS)
            sent += count
            table.add_row(preset, idle, mode, f"{rate:g}", str(seed), str(count), *row(outcome))
            for words in outcome.complaints():
                console.print(f"{preset}, {idle}, {mode}, {rate:g} a second, seed {seed}: {words}", highlight=False)
                well = False
        engine.close()
    console.print(table)
    words = "nothing is stuck" if well else "see above"
    console.print(f"{sent} messages in {time.perf_counter() - began:.0f} s: {words}", highlight=False)
    return well


def main(arguments=None):
    options = parse(arguments)
    try:
        sys.exit(0 if run(options, Console(width=None if sys.stdout.isatty() else 140)) else 1)
    except UkrtError as error:
        sys.exit(f"stuck_notes: {error}")


if __name__ == "__main__":
    main()
