"""Notes put into bars: what the player did and the bars of the piece enter, a sheet leaves that can be written down.

Onsets are put on a grid. Each quarter note is divided into as few equal parts as its onsets need: 1, 2, 3, 4, 6, 8, 12
or 16 parts on which all of them lie to within a hundredth of a quarter note; where none will do (people play so), the
coarsest on which each lies nearer than 30 ms (at most a twentieth of a quarter note) and no string has two; where none
does that, 16 parts, each onset on the nearest that its string has free, up to an eighth of a quarter note away, or on
none. How many were moved and how far, and how many found no place, is kept.
"""

from dataclasses import dataclass, field
from fractions import Fraction

from ukrt.drivers.files.bars import Bar
from ukrt.errors import MidiFileError

MOST_BARS = 10_000  # more are no music, and no page
DIVISIONS = (1, 2, 3, 4, 6, 8, 12, 16)
EXACT = 0.01  # quarter notes: rounding of 96 ticks, and more
FARTHEST = 0.125  # quarter notes that a note may stand off its time, where its string is busy (a choice)
LOOSE_SECONDS, LOOSE_QUARTERS = 0.03, 0.05  # about what separates notes of one chord in human playing (a choice)


@dataclass(frozen=True)
class Tone:
    """One note that is played.

    Attributes
    ----------
    start_s : float [s]
    end_s : float or None [s]
        None: it rings.
    pitch : int
        MIDI note that sounds.
    string, fret : int
        String 0 is the lowest.
    articulation : str
        ``pluck``, ``hammer-on``, ``pull-off`` or ``slide``.
    """

    start_s: float
    end_s: float | None
    pitch: int
    string: int
    fret: int
    articulation: str = "pluck"


@dataclass
class Measure:
    """One bar with its notes.

    Attributes
    ----------
    bar : Bar
    divisions : list of int
        Parts of each quarter note; the last quarter note may be cut short with the bar.
    moments : dict of Fraction to list of Tone
        Notes that begin together, by quarter notes from the bar's beginning, in order.
    markers : list of str
    """

    bar: Bar
    divisions: list
    moments: dict
    markers: list = field(default_factory=list)


@dataclass(frozen=True)
class Sheet:
    """A piece, or a part of it, as it is written down.

    Attributes
    ----------
    title, guitar : str
    open_keys : list of int
        MIDI notes of the open strings, the lowest string first.
    measures : list of Measure
    tones : list of Tone
        In order, at their own times.
    lost : list of (Bar, float, int, str)
        Notes that were not played: bar, quarter notes into it, MIDI note, fate.
    unshown : int
        Notes for which the grid had no room.
    moved : int
        Onsets further off the grid than a hundredth of a quarter note.
    moved_s : float [s]
        The largest such distance.
    """

    title: str
    guitar: str
    open_keys: list
    measures: list
    tones: list
    lost: list
    unshown: int
    moved: int
    moved_s: float


def make_sheet(score, guitar_name, notes, open_keys, start_s=0.0, end_s=float("inf")):
    """Put notes into bars.

    Parameters
    ----------
    score : Score
    guitar_name : str
    notes : list of dict
        As `ukrt.notation.silent.play_silently` gives them.
    open_keys : list of int
    start_s, end_s : float [s]
        The notes that begin there are written, with the bars they are in.

    Returns
    -------
    Sheet

    Raises
    ------
    MidiFileError
        There are too many bars.
    """
    notes = [note for note in notes if start_s <= note["time_s"] < end_s]
    tones = [_tone(note, open_keys) for note in notes if note["string"] is not None and not _is_passed(note)]
    first, last = _bars_between(score, start_s, end_s)
    if last - first >= MOST_BARS:
        raise MidiFileError(f"there are {last - first + 1} bars to write down, {MOST_BARS} at most are legal")
    measures = {number: Measure(score.bars.bar(number), [], {}) for number in range(first, last + 1)}
    places = [_place(score.bars, tone.start_s, last) for tone in tones]
    result = _Grid(measures)
    result.fill(tones, places)
    for seconds, name in score.markers:
        number = score.bars.place(seconds + 1e-9)[0]
        if number in measures and start_s <= seconds < end_s:
            measures[number].markers.append(name)
    lost = [(note, score.bars.place(note["time_s"] + 1e-9)) for note in notes if note["string"] is None]
    return Sheet(
        score.title,
        guitar_name,
        open_keys,
        list(measures.values()),
        tones,
        [(score.bars.bar(number), quarters, note["midi"], note["fate"]) for note, (number, quarters) in lost],
        result.unshown,
        result.moved,
        result.moved_s,
    )


def _is_passed(note):
    """Whether a string went back to this note and on to another in the same instant."""
    return note["fate"] == "slurred" and note["end_s"] == note["time_s"]


def _tone(note, open_keys):
    pitch = open_keys[note["string"]] + note["fret"]
    way = note.get("articulation", "pluck")  # a player that only plucks says nothing
    return Tone(note["time_s"], note["end_s"], pitch, note["string"], note["fret"], way)


def _bars_between(score, start_s, end_s):
    """Numbers of the first and the last bar that have something of the time between."""
    first = score.bars.place(start_s + 1e-9)[0]
    last = score.bars.count if end_s >= score.duration_s else score.bars.place(end_s - 1e-9)[0]
    return min(first, last), last


def _place(bars, seconds, last):
    """Bar, which quarter note of it (from 0), and the fraction of one after that; early ones belong to what follows."""
    number, quarters = bars.place(seconds)
    bar = bars.bar(number)
    loose = min(LOOSE_SECONDS * 1e6 / bar.quarter_us, LOOSE_QUARTERS)
    if quarters > float(bar.quarters) - loose and number < last:
        return number + 1, 0, quarters - float(bar.quarters)
    unit = min(int(quarters + loose), -(-bar.quarters.numerator // bar.quarters.denominator) - 1)
    return number, unit, quarters - unit


class _Grid:
    """Fills measures; counts what it cannot keep."""

    def __init__(self, measures):
        self._measures = measures
        self.unshown, self.moved, self.moved_s = 0, 0, 0.0

    def fill(self, tones, places):
        """Put tones at their places (bar, quarter note, fraction)."""
        units = {}
        for tone, (number, unit, rest) in zip(tones, places, strict=True):
            units.setdefault((number, unit), []).append((rest, tone))
        for number, measure in self._measures.items():
            quarters = measure.bar.quarters
            for unit in range(-(-quarters.numerator // quarters.denominator)):
                onsets = units.get((number, unit), [])
                self._fill_unit(measure, unit, onsets, min(Fraction(1), quarters - unit))
            measure.moments = dict(sorted(measure.moments.items()))

    def _fill_unit(self, measure, unit, onsets, length):
        quarter_s = measure.bar.quarter_us / 1e6
        loose = min(LOOSE_SECONDS / quarter_s, LOOSE_QUARTERS)
        grids = [(n, EXACT) for n in DIVISIONS] + [(n, loose) for n in DIVISIONS]
        division = next((n for n, most in grids if _fits(onsets, n, most, length)), DIVISIONS[-1])
        measure.divisions.append(division)
        taken = set()
        for rest, tone in onsets:
            cell = _free_cell(rest, tone.string, division, length, taken)
            if cell is None:
                self.unshown += 1
                continue
            taken.add((cell, tone.string))
            off = abs(rest - cell / division)
            if off > EXACT:
                self.moved, self.moved_s = self.moved + 1, max(self.moved_s, off * quarter_s)
            measure.moments.setdefault(unit + Fraction(cell, division), []).append(tone)


def _cells(division, length):
    """Parts that begin within a quarter note of which ``length`` (Fraction) is there."""
    return max(-(-length * division // 1), 1)


def _fits(onsets, division, most, length):
    """Whether every onset lies within ``most`` of a part, and no string has two on one."""
    cells = [(min(max(round(rest * division), 0), _cells(division, length) - 1), rest, t.string) for rest, t in onsets]
    near = all(abs(rest - cell / division) <= most for cell, rest, _ in cells)
    return near and len({(cell, string) for cell, _, string in cells}) == len(cells)


def _free_cell(rest, string, division, length, taken):
    """The nearest part that ``string`` has free; None where there is none near."""
    free = [
        cell
        for cell in range(_cells(division, length))
        if (cell, string) not in taken and abs(rest - cell / division) <= max(FARTHEST, 0.5 / division)
    ]
    return min(free, key=lambda cell: abs(rest - cell / division), default=None)
