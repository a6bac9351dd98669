"""Tablature in plain text: a sheet enters, lines of text leave, a line for each string, the lowest at the bottom.

Above the strings stand the bar's number (with time signature, quarter notes a minute and markers where they change) and
the numbers of its beats. Within a quarter note all columns stand for equal times; it has as many as it needs.
``h``, ``p`` and ``/`` before a fret: hammered on, pulled off, slid to.
"""

from dataclasses import dataclass
from fractions import Fraction

from ukrt.notation.names import note_name

SIGNS = {"hammer-on": "h", "pull-off": "p", "slide": "/"}  # other articulations have none
LEAST_WIDTH = 40
_MARKER_LETTERS = 24


@dataclass(frozen=True)
class _Column:
    """What stands at one time.

    Attributes
    ----------
    frets : tuple of str
        For each string, the lowest first; "" for nothing.
    beat : str
    head : str
        Begins here in the line above.
    is_last : bool
        Whether a bar line follows.
    width : int
    """

    frets: tuple
    beat: str
    head: str
    is_last: bool
    width: int


def draw(sheet, width=80):
    """Draw a sheet.

    Parameters
    ----------
    sheet : Sheet
    width : int
        Letters in a line, at least 40.

    Returns
    -------
    str
        Lines that end with line feeds.
    """
    names = [note_name(key) for key in sheet.open_keys]
    lines = [sheet.title] if sheet.title else []
    lines += [f"{sheet.guitar}, strings from the bass side: {' '.join(names)}", ""]
    margin = max(map(len, names))
    for system in _systems(_columns(sheet), max(width, LEAST_WIDTH) - margin - 2):
        lines += [line.rstrip() for line in _draw_system(system, names, margin)] + [""]
    return "\n".join(lines + _remarks(sheet)).rstrip("\n") + "\n"


def _columns(sheet):
    """The columns of all measures, a list for each."""
    found, before = [], None
    for measure in sheet.measures:
        columns = _measure_columns(measure, len(sheet.open_keys))
        head = _head(measure, before)
        room = sum(column.width for column in columns) + 2
        last = columns[-1]
        columns[-1] = _Column(last.frets, last.beat, "", True, last.width + max(len(head) + 1 - room, 0))
        first = columns[0]
        columns[0] = _Column(first.frets, first.beat, head, first.is_last, first.width)
        found.append(columns)
        before = measure.bar
    return found


def _measure_columns(measure, n_strings):
    columns = []
    beat = Fraction(4, measure.bar.denominator)
    for unit, division in enumerate(measure.divisions):
        for cell in range(division):
            at = unit + Fraction(cell, division)
            if at >= measure.bar.quarters:
                break
            frets = [""] * n_strings
            for tone in measure.moments.get(at, ()):
                frets[tone.string] = f"{SIGNS.get(tone.articulation, '')}{tone.fret}"
            number = str(int(at / beat) + 1) if (at / beat).denominator == 1 else ""
            columns.append(_Column(tuple(frets), number, "", False, max(1, *map(len, frets), len(number)) + 1))
    return columns


def _head(measure, before):
    """Bar number, and what is new in the bar."""
    bar, words = measure.bar, [str(measure.bar.number)]
    if before is None or (bar.numerator, bar.denominator) != (before.numerator, before.denominator):
        words.append(f"{bar.numerator}/{bar.denominator}")
    if before is None or bar.quarter_us != before.quarter_us:
        words.append(f"q={60e6 / bar.quarter_us:.3g}" if bar.quarter_us < 60e6 else "q<1")
    return " ".join(words + [f"[{marker[:_MARKER_LETTERS]}]" for marker in measure.markers])


def _systems(measures, room):
    """Put measures into lines, as many as there is room for; a measure that is too wide is broken."""
    systems, used = [], room
    for columns in measures:
        width = sum(column.width for column in columns) + 2
        if used + width > room and used > 0:
            systems.append([])
            used = 0
        for column in columns:
            if used + column.width + 2 > room and systems[-1]:
                systems.append([])
                used = 0
            systems[-1].append(column)
            used += column.width + 2 * column.is_last
    return systems


def _draw_system(columns, names, margin):
    """The lines of one system."""
    heads, beats = " " * (margin + 1), " " * (margin + 2)
    strings = [name.ljust(margin) + "|-" for name in names]
    for column in columns:
        if column.head:
            heads = heads.ljust(len(beats) - 1) + column.head
        beats += column.beat.ljust(column.width)
        for s, fret in enumerate(column.frets):
            strings[s] += fret.ljust(column.width, "-") + ("|-" if column.is_last else "")
        beats += "  " * column.is_last
    ends = columns[-1].is_last
    return [heads, beats, *((line[:-1] if ends else line) for line in reversed(strings))]


def _remarks(sheet):
    """What is not in the tablature, in words."""
    lines = []
    for bar, quarters, midi, fate in sheet.lost:
        if fate != "percussion":
            beat = 1 + quarters * bar.denominator / 4
            lines.append(f"{fate}: bar {bar.number}, beat {beat:.4g}: {note_name(midi, bar.fifths)} (MIDI note {midi})")
    if percussion := sum(fate == "percussion" for *_, fate in sheet.lost):
        lines.append(f"not played: {_notes(percussion)} of percussion (channel 10)")
    if sheet.unshown:
        lines.append(f"not shown: {_notes(sheet.unshown)}, too quick for the grid")
    if sheet.moved:
        lines.append(f"played off the grid: {_notes(sheet.moved)}, by {1000 * sheet.moved_s:.0f} ms at most")
    return lines


def _notes(count):
    return f"{count} note{'s' * (count != 1)}"
