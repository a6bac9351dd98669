"""Measure how well a guitar is in tune: a preset enters, cents from its scale for each string and fret leave.

    python tools/measure_intonation.py [--preset NAME|FILE] [--rate HZ] [--idle damped|open|both] [--force N]
                                       [--frets 0,1,..] [--json FILE] [--plot PNG]

Measured on the sound (pressure, both channels) from 0.6 to 3.2 s after the release, partial 1, A4 = 440 Hz. Each note
is played alone on the string and fret asked for: the player's choice of string is passed over, all else is what it does
for a MIDI note. Which component of the sound is the note's pitch: ``NotePitch`` in tests/measure/forced_notes.py.
"""

import argparse
import json
import pathlib
import sys
import time

from rich.console import Console
from rich.progress import Progress
from rich.table import Table

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "tests"))

from measure.forced_notes import WINDOW, note_pitch

from ukrt.engine.engine import Engine
from ukrt.errors import UkrtError
from ukrt.model.fingerboard import fingerboard
from ukrt.model.presets import load_preset
from ukrt.model.tunings import note_name

LIMIT = 0.5  # cents: what is more is set in bold


def parse(arguments):
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--preset", default="classical", help="a preset's name or a TOML file (default: classical)")
    parser.add_argument("--rate", type=float, default=48000.0, help="sample rate in Hz (default: 48000)")
    parser.add_argument("--idle", choices=("damped", "open", "both"), default="damped", help="what the others do")
    parser.add_argument("--force", type=float, default=1.0, help="peak force of the plucks in N (default: 1)")
    parser.add_argument("--frets", help="frets to measure, such as 0,5,12 (default: all)")
    parser.add_argument("--json", metavar="FILE", help="write the numbers to this file")
    parser.add_argument("--plot", metavar="PNG", help="draw them into this file (needs matplotlib)")
    options = parser.parse_args(arguments)
    if not 0.0 < options.force <= 100.0:
        parser.error(f"--force: {options.force:g} N is not above 0 and at most 100")
    try:
        options.frets = options.frets and sorted({int(one) for one in options.frets.split(",")})
    except ValueError:
        parser.error(f"--frets: {options.frets!r} is not a list of whole numbers such as 0,5,12")
    return options


def measure(guitar, rate, force, frets, advance):
    """A `NotePitch` for each string and fret, in this order; ``advance`` is called after each."""
    engine, notes = Engine(guitar, rate), []
    for string in range(len(guitar.strings)):
        for fret in frets:
            notes.append(note_pitch(engine, string, fret, force))
            advance()
    return notes


def worst(notes):
    return max(notes, key=lambda note: abs(note.cents))


def summary(notes):
    """What is to be said of the notes in one line."""
    far, within = worst(notes), sum(abs(note.cents) <= LIMIT for note in notes)
    beaten = sum(bool(slower(note)) for note in notes)
    return (
        f"worst {far.cents:+.3f} cents: {note_name(far.midi)}, string {far.string} fret {far.fret}; {within} of "
        f"{len(notes)} notes within {LIMIT} cents; {beaten} notes with *"
    )


def slower(note):
    """Components less than 20 dB fainter than the note that decay more slowly: a string in unison, not the body."""
    return [rival for rival in note.rivals if rival.decay_rate < note.decay_rate]


def show(console, guitar, title, notes):
    table = Table(title=title, caption=summary(notes))
    table.add_column("fret", justify="right")
    for string, one in enumerate(guitar.strings):
        table.add_column(f"{string} {note_name(one.note)}", justify="right")
    cells = {(note.string, note.fret): note for note in notes}
    for fret in sorted({note.fret for note in notes}):
        row = [cells[string, fret] for string in range(len(guitar.strings))]
        words = [f"{note.cents:+.3f}" + ("*" if slower(note) else " ") for note in row]
        bold = [f"[bold]{word}[/]" if abs(note.cents) > LIMIT else word for word, note in zip(words, row, strict=True)]
        table.add_row(str(fret), *bold)
    console.print(table)


def records(notes):
    """Notes as plain dicts."""
    rows = [note._asdict() | {"name": note_name(note.midi)} for note in notes]
    return [row | {"rivals": [rival._asdict() for rival in row["rivals"]]} for row in rows]


def draw(path, guitar, results):
    """One panel for each state of the idle strings: cents over frets, a line for each string."""
    try:
        from matplotlib.figure import Figure
    except ImportError:
        raise UkrtError("--plot needs matplotlib, which is not installed: pip install matplotlib") from None
    figure = Figure(figsize=(8.0, 3.5 * len(results)), layout="constrained")
    for panel, (idle, notes) in zip(figure.subplots(len(results), squeeze=False)[:, 0], results.items(), strict=True):
        for string, one in enumerate(guitar.strings):
            own = [note for note in notes if note.string == string]
            panel.plot([note.fret for note in own], [note.cents for note in own], ".-", label=note_name(one.note))
        panel.set(title=f"idle strings {idle}", xlabel="fret", ylabel="cents beside the scale")
        panel.grid(alpha=0.3)
        panel.legend(ncols=6)
    figure.savefig(path)


def run(options):
    console = Console()
    states = ("damped", "open") if options.idle == "both" else (options.idle,)
    began, results = time.perf_counter(), {}
    for idle in states:
        guitar = load_preset(options.preset, {"playing.idle_strings": idle})
        most = fingerboard(guitar).frets
        frets = options.frets or range(most + 1)
        if not set(frets) <= set(range(most + 1)):
            raise UkrtError(f"--frets: {options.frets} asks for more than frets 0 to {most}")
        with Progress(console=console, transient=True) as progress:
            task = progress.add_task(f"idle strings {idle}", total=len(guitar.strings) * len(frets))
            results[idle] = measure(guitar, options.rate, options.force, frets, lambda: progress.advance(task))  # noqa: B023
    seconds = time.perf_counter() - began
    for idle, notes in results.items():
        words = f"{guitar.name}: cents, {options.force:g} N, {options.rate:g} Hz, idle strings {idle}"
        show(console, guitar, words, notes)
    console.print(
        "* with it sounds something that decays more slowly, within a semitone and at most 20 dB below", highlight=False
    )
    console.print(f"{seconds:.1f} s", highlight=False)
    if options.json:
        settings = {"preset": options.preset, "rate_hz": options.rate, "force_n": options.force, "window_s": WINDOW}
        idle = {state: {"worst_cents": worst(n).cents, "notes": records(n)} for state, n in results.items()}
        text = json.dumps(settings | {"seconds": seconds, "idle": idle}, indent=1)
        pathlib.Path(options.json).write_text(text + "\n")
    if options.plot:
        draw(options.plot, guitar, results)


def main(arguments=None):
    options = parse(arguments)
    try:
        run(options)
    except (UkrtError, OSError, ValueError) as error:
        sys.exit(f"measure_intonation: {error}")


if __name__ == "__main__":
    main()
