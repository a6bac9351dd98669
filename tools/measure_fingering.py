"""Measure how pieces lie under the hand: MIDI files enter, one line for each way to choose strings and frets leaves.

    python tools/measure_fingering.py [FILE.mid ...] [--preset NAME|FILE] [--json FILE]

Without files the bundled piece is measured. Both ways, note by note as in live play and with look-ahead, are played by
the compiled player without sound; what is counted is read from its log of notes, for both by the same rules:

playable    notes that begin under a hand that there is, of all notes in the file
dropped     notes that got no string
moved       notes moved by octaves into the instrument's range
cut         notes that lose their string, or their finger, before their end in the file
hands       moments whose stopped notes no hand can hold (wider than the widest stretch, or more than four fingers)
of them     those whose new notes alone cannot be held on any strings
stretches   moments at which a possible hand reaches beyond its comfort
shifts      times the hand moves, and millimetres it moves on average each time and for each note
"""

import argparse
import json
import pathlib
import sys
import time

import numpy as np
from rich.console import Console
from rich.table import Table

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "tests" / "playing"))

from player_bench import RATE, Bench

from ukrt.drivers.files.midi import load_midi_file
from ukrt.errors import UkrtError
from ukrt.playing.fingering_costs import LEGATO_SECONDS
from ukrt.playing.grips import neck_of
from ukrt.playing.matching import playable_notes, ways_to_place
from ukrt.playing.written_fingering import CHOICES, choose_fingering
from ukrt.playing.written_notes import written_notes

BUNDLED = pathlib.Path(__file__).resolve().parents[1] / "ukrt" / "data" / "romance.mid"


def play(score, preset):
    """The bench after its player has played ``score``, and the hand's position after each note's moment."""
    bench, hands = Bench(preset=preset), {}
    columns = (np.rint(score.time_s * RATE).astype(int), score.status, score.data1, score.data2)
    for frame, *message in zip(*(column.tolist() for column in columns), strict=True):
        bench.send(frame, *message)
        hands[frame] = bench.hand
    bench.finish()
    return bench, hands


def measure(score, choice, preset):
    """What is counted (dict)."""
    began = time.perf_counter()
    written, _ = choose_fingering(score, Bench(preset=preset).guitar, choice)
    seconds = time.perf_counter() - began
    bench, hands = play(written, preset)
    neck = neck_of(bench.guitar)
    log = [note for note in bench.log if note["string"] is not None]
    positions = [hands[frame] for frame in sorted({round(note["time_s"] * RATE) for note in log})]
    moves = [neck.ways[a, b] for a, b in zip(positions, positions[1:], strict=False) if a != b]
    counts = grips(log, neck) | {
        "notes": score.n_notes,
        "dropped": bench.counters["notes_dropped"],
        "moved": bench.counters["notes_folded"],
        "cut": cut_short(score, log),
        "shifts": len(moves),
        "mm_per_shift": 1000.0 * float(sum(moves)) / max(len(moves), 1),
        "mm_per_note": 1000.0 * float(sum(moves)) / len(log),
        "refused": bench.counters["forces_refused"],
        "seconds": seconds,
    }
    return counts


def cut_short(score, log):
    """Notes whose log ends before the file's key and pedal do, by more than a keyboard's legato (int)."""
    ends = {(round(note.start_s * RATE), note.channel, note.key): note.end_s for note in written_notes(score)}
    found = 0
    for note in log:
        end = ends.get((round(note["time_s"] * RATE), note["channel"], note["midi"]), 0.0)
        found += note["end_s"] is not None and note["end_s"] < end - LEGATO_SECONDS
    return found


def grips(log, neck):
    """Notes under a hand that can be; hands that cannot, those of them that nobody could avoid, and stretches, each a
    number of moments (dict)."""
    counts = {"playable": 0, "hands": 0, "unavoidable": 0, "stretches": 0}
    for moment in sorted({note["time_s"] for note in log}):
        frets, new = [-1] * len(neck.open), []
        for note in log:
            if note["time_s"] > moment:
                break
            ends = note["end_s"] if note["end_s"] is not None else np.inf
            if note["time_s"] == moment:
                new.append(neck.open[note["string"]] + note["fret"])
            elif ends <= moment + LEGATO_SECONDS:
                continue
            frets[note["string"]] = note["fret"]
        grip = neck.grip(tuple(frets))
        counts["playable"] += len(new) if grip.possible else 0
        counts["stretches"] += bool(grip.possible and grip.stretch_m > 0.0)
        counts["hands"] += not grip.possible
        counts["unavoidable"] += not grip.possible and not can_be_held(new, neck)
    return counts


def can_be_held(pitches, neck):
    """Whether some way to put ``pitches`` on strings is a hand that there is."""
    kept = tuple(pitches[k] for k in playable_notes(pitches, neck))
    for strings in ways_to_place(kept, neck):
        frets = [-1] * len(neck.open)
        for pitch, s in zip(kept, strings, strict=True):
            frets[s] = pitch - neck.open[s]
        if neck.grip(tuple(frets)).possible:
            return True
    return False


def show(results, console):
    table = Table("piece", "choice", "notes", "playable", "dropped", "moved", "cut", "hands", "of them", "stretches")
    for name in ("shifts", "mm/shift", "mm/note", "search"):
        table.add_column(name)
    for (name, choice), found in results.items():
        table.add_row(
            *(name, choice, str(found["notes"]), f"{100 * found['playable'] / found['notes']:.1f} %"),
            *(str(found[key]) for key in ("dropped", "moved", "cut", "hands", "unavoidable", "stretches", "shifts")),
            *(f"{found['mm_per_shift']:.0f}", f"{found['mm_per_note']:.1f}", f"{found['seconds']:.2f} s"),
            end_section=choice == CHOICES[0],
        )
    console.print(table)


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("files", nargs="*", metavar="FILE.mid", help="pieces (default: the bundled one)")
    parser.add_argument("--preset", default="classical", help="a preset's name or a TOML file (default: classical)")
    parser.add_argument("--json", metavar="FILE", help="write the numbers to this file")
    options = parser.parse_args(arguments)
    results = {}
    try:
        for path in options.files or [BUNDLED]:
            score = load_midi_file(path)
            for choice in reversed(CHOICES):
                results[pathlib.Path(path).stem, choice] = measure(score, choice, options.preset)
    except UkrtError as error:
        parser.error(str(error))
    show(results, Console())
    if options.json:
        rows = [{"piece": name, "choice": choice} | found for (name, choice), found in results.items()]
        pathlib.Path(options.json).write_text(json.dumps(rows, indent=1) + "\n")


if __name__ == "__main__":
    main()
