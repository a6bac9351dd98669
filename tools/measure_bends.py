"""Measure how bends are followed, each string by itself: a table and, if asked for, a picture leave.

    python tools/measure_bends.py [--idle damped|open] [--plot PNG] [--json FILE]

A MIDI file as guitars with a pickup for each string send it (a channel for each string, bends every 8 ms, their range
by RPN 0) is rendered once with its bends and once without. In each string's own force on the bridge, the pitch of the
lowest six partials is followed and compared with the same note unbent, as long as it is above -40 dB of its loudest.

Then a string is bent by a whole tone while another one sounds: how far the other's partials move, by the poles of its
force, and how far they should by those of the same guitar in continuous time (tests/oracle). How: tests/measure.
"""

import argparse
import itertools
import json
import pathlib
import sys
from dataclasses import asdict

import numpy as np
from rich.console import Console
from rich.table import Table

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "tests"))

from measure.bent_guitar import GESTURES, follow, neighbours
from measure.guitar_file import BentNote

from ukrt.errors import UkrtError
from ukrt.figures.style import BLACK, BLUE, GREY, RED, SETTINGS

NOTE_SECONDS, PAUSE_SECONDS = 2.4, 0.6
FRETS = (5, 7, 7, 5, 3, 7)  # of strings 1 to 6: A4 F#4 D4 G3 C3 B2
HANDS = ((1, 1, 2, 2, 3, 5), (5, 3, 0, 4, 7, 2))  # frets of pairs that sound together
LIMIT, ALONE = 5.0, 0.2  # cents: of a bent note; of strings that share no partial
SHARED = 50.0  # cents


def all_notes():
    """Every gesture on every string, one after another."""
    starts = itertools.count(0.2, NOTE_SECONDS + PAUSE_SECONDS)
    return [
        BentNote(name, string, FRETS[string - 1], round(next(starts), 3), NOTE_SECONDS, *gesture)
        for string in range(1, 7)
        for name, gesture in GESTURES.items()
    ]


def show_followed(found, idle, console):
    table = Table("string", "key", "gesture", "range", "worst", "rms", "lasts", "partial 1 alone, worst")
    table.title = f"cents beside the bend, idle strings {idle}"
    for one in found:
        note = one.note
        table.add_row(
            *(str(note.string), str(note.key), note.name, str(note.range_semitones)),
            *(f"{np.abs(one.off).max():.2f}", f"{np.sqrt(np.mean(one.off**2)):.2f}", f"{one.times[-1]:.1f} s"),
            f"{one.fundamental:.1f}",
            end_section=note.name == list(GESTURES)[-1],
        )
    console.print(table)
    within = sum(np.abs(one.off).max() <= LIMIT for one in found)
    worst = max(np.abs(one.off).max() for one in found)
    console.print(f"{within} of {len(found)} notes within {LIMIT:g} cents, worst {worst:.2f}", highlight=False)


def show_neighbours(found, console):
    """Those that move, or should, by more than what is allowed where nothing is shared."""
    table = Table("hand", "bent", "string", "partial", "nearest", "moves", "should", title="cents of another string")
    for hand, one in found:
        if max(abs(one.shift), abs(one.expected)) > ALONE:
            shared = f"{one.near:.0f}" + (" (shared)" if one.near <= SHARED else "")
            numbers = (str(n) for n in (one.bent, one.string, one.partial))
            table.add_row(" ".join(map(str, hand)), *numbers, shared, f"{one.shift:+.3f}", f"{one.expected:+.3f}")
    console.print(table)
    for words, chosen in (
        ("none within", [one for _, one in found if one.near > SHARED]),
        ("one within", [one for _, one in found if one.near <= SHARED]),
    ):
        still = sum(abs(one.shift) <= ALONE for one in chosen)
        off = [abs(one.shift - one.expected) for one in chosen]
        console.print(
            f"{words} {SHARED:g} cents: {still} of {len(chosen)} partials move by at most {ALONE:g} cents; beside what "
            f"they should, median {np.median(off):.4f}, 95 % {np.quantile(off, 0.95):.3f}, worst {max(off):.2f} cents",
            highlight=False,
        )


def draw(path, found, idle):
    """A row for each string: bends sent and pitch measured, and the difference below."""
    try:
        import matplotlib
        from matplotlib.figure import Figure
    except ImportError:
        raise UkrtError("--plot needs matplotlib, which is not installed: pip install matplotlib") from None
    with matplotlib.rc_context(SETTINGS):
        figure = Figure(figsize=(12.0, 15.0))
        panels = figure.subplots(12, 1, sharex=True, height_ratios=[2, 1] * 6)
        for string, (above, below) in enumerate(zip(panels[::2], panels[1::2], strict=True), start=1):
            for k, one in enumerate(one for one in found if one.note.string == string):
                times = one.times + k * (NOTE_SECONDS + PAUSE_SECONDS)
                above.plot(times, one.sent, color=GREY, linewidth=2.5, label="sent" if k == 0 else None)
                above.plot(times, one.sent + one.off, color=BLUE, label="measured" if k == 0 else None)
                below.plot(times, one.off, color=RED)
                if string == 1:
                    above.text(times[0], 570.0, one.note.name)
            above.set(ylabel=f"string {string}\n[cents]", ylim=(-350.0, 700.0))
            below.axhline(0.0, color=BLACK, linewidth=0.5)
            below.set(ylabel="beside", ylim=(-1.3 * LIMIT, 1.3 * LIMIT))
        panels[0].legend(loc="lower right")
        panels[0].set_title(f"Bends sent and pitch measured, relative to the same note unbent; idle strings {idle}")
        panels[-1].set_xlabel("Time [s]")
        figure.savefig(path, dpi=110)


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--idle", choices=("damped", "open"), default="damped", help="what other strings do")
    parser.add_argument("--plot", metavar="PNG", help="draw bends and pitches into this file (needs matplotlib)")
    parser.add_argument("--json", metavar="FILE", help="write the numbers to this file")
    options = parser.parse_args(arguments)
    console = Console(width=None if sys.stdout.isatty() else 140)
    try:
        followed = follow(all_notes(), options.idle)
        show_followed(followed, options.idle, console)
        pairs = list(itertools.permutations(range(1, 7), 2))
        others = [(hand, one) for hand in HANDS for one in neighbours(hand, pairs)]
        show_neighbours(others, console)
        if options.plot:
            draw(options.plot, followed, options.idle)
    except UkrtError as error:
        sys.exit(f"measure_bends: {error}")
    if options.json:
        notes = [
            {"gesture": one.note.name, "string": one.note.string, "worst_cents": float(np.abs(one.off).max())}
            for one in followed
        ]
        rows = [{"frets": hand} | asdict(one) for hand, one in others]
        pathlib.Path(options.json).write_text(json.dumps({"followed": notes, "neighbours": rows}, indent=1) + "\n")


if __name__ == "__main__":
    main()
