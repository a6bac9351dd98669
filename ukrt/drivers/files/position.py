"""Places in a piece, in words: text such as ``bar:5.3`` enters, a time in seconds leaves.

Legal words::

    12.5             seconds
    1:30, 1:02:03.5  minutes (or hours, minutes) and seconds
    bar:5            the beginning of bar 5, from 1 as `ukrt.drivers.files.bars` numbers them
    bar:5.3          its third beat
    marker:NAME      a marker or cue point of that name, capitals or not
"""

import math
import re
from dataclasses import dataclass

from ukrt.errors import MidiFileError, ParameterError

LEGAL = "seconds (12.5), minutes (1:30), bar:5, bar:5.3 (its third beat) or marker:NAME are legal"
_CLOCK = re.compile(r"(?:(\d{1,3}):)?(\d{1,5}):(\d{1,2}(?:\.\d*)?)")
_BAR = re.compile(r"bar:(\d{1,9})(?:\.(\d{1,3}))?", re.IGNORECASE)
_MARKER = re.compile(r"marker:(.+)", re.IGNORECASE | re.DOTALL)


@dataclass(frozen=True)
class Position:
    """A place in a piece, not yet looked up.

    Attributes
    ----------
    text : str
        As it was given.
    seconds : float or None [s]
        Where a time was given.
    bar, beat : int
        From 1; bar 0 where none was given.
    marker : str
    """

    text: str
    seconds: float | None = None
    bar: int = 0
    beat: int = 1
    marker: str = ""


def parse_position(value, key="the place"):
    """Read a place in a piece.

    Parameters
    ----------
    value : str, float [s] or Position
    key : str
        What a refusal calls it.

    Returns
    -------
    Position

    Raises
    ------
    ParameterError
    """
    if isinstance(value, Position):
        return value
    text = str(value).strip()
    if found := _CLOCK.fullmatch(text):
        hours, minutes, seconds = int(found[1] or 0), int(found[2]), float(found[3])
        if seconds < 60.0:
            return Position(text, 3600.0 * hours + 60.0 * minutes + seconds)
    elif (found := _BAR.fullmatch(text)) and int(found[1]) > 0 and found[2] != "0":
        return Position(text, bar=int(found[1]), beat=int(found[2] or 1))
    elif found := _MARKER.fullmatch(text):
        return Position(text, marker=found[1].strip().strip('"').strip())
    else:
        try:
            seconds = float(text)
        except ValueError:
            seconds = math.nan
        if 0.0 <= seconds < math.inf:
            return Position(text, seconds)
    raise ParameterError(key, value, LEGAL)


def find(position, score, path, after_s=-math.inf):
    """Look up a place.

    Parameters
    ----------
    position : Position
    score : Score
    path : str
        Of the file, for refusals.
    after_s : float [s]
        Of markers of one name the first one after this is meant.

    Returns
    -------
    float [s]

    Raises
    ------
    MidiFileError
        There is no such bar, beat or marker.
    """
    if position.seconds is not None:
        return position.seconds
    if position.bar:
        return _find_bar(position, score.bars, path)
    wanted = position.marker.casefold()
    for seconds, name in score.markers:
        if name.casefold() == wanted and seconds > after_s:
            return seconds
    names = ", ".join(dict.fromkeys(name for _, name in score.markers))
    where = " after the part's beginning" if after_s > -math.inf else ""
    raise MidiFileError(f"{path}: has no marker {position.marker!r}{where}, its markers are: {names[:300] or 'none'}")


def _find_bar(position, bars, path):
    seconds = bars.seconds(position.bar, position.beat)
    if seconds is None and position.bar <= bars.count:
        beats = bars.beats(position.bar)
        legal = f"1 to {beats} are its beats, or fewer where it is cut short"
        raise MidiFileError(f"{path}: bar {position.bar} has no beat {position.beat}, {legal}")
    if seconds is None:
        most = f"bar:1 to bar:{bars.count + 1}, the end of the last, are there"
        raise MidiFileError(f"{path}: has {bars.count} bar{'s' * (bars.count != 1)} and no {position.text}; {most}")
    return seconds


def find_part(start, end, score, path):
    """The part of a piece from ``start`` to ``end``.

    Parameters
    ----------
    start, end : str, float [s], Position or None
        None: the piece's beginning, its end.
    score : Score
    path : str

    Returns
    -------
    start_s : float [s]
    end_s : float [s]
        Infinite for the end.

    Raises
    ------
    ParameterError
        The end does not come after the start.
    MidiFileError
        As from `find`.
    """
    start_s = 0.0 if start is None else find(parse_position(start, "start"), score, path)
    if end is None:
        return start_s, math.inf
    end_s = find(parse_position(end, "end"), score, path, start_s if start is not None else -math.inf)
    if end_s <= start_s:
        legal = f"it must come after the start at {start_s:g} s, and falls on {end_s:g} s"
        raise ParameterError("end", _text(end), legal)
    return start_s, end_s


def _text(position):
    return parse_position(position).text
