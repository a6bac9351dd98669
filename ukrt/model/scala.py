"""Scala's files as plain data: the text of a ``.scl`` (a scale) or a ``.kbm`` (which key plays which of its notes)
enters, the fields of `ukrt.model.parameters.Scale` or `Keyboard` leave. Rules: the pages on both formats at
https://www.huygens-fokker.org/scala/."""

import math
import re

from ..errors import PresetError

MOST_WHOLE = 2**31 - 1  # the highest numerator and denominator that Scala's page asks for
_CENTS = re.compile(r"[+-]?(\d+\.\d*|\.\d+)$")
_RATIO = re.compile(r"(\d+)(?:/(\d+))?$")
_UNMAPPED = "x"
_HEAD = (
    ("size of the map", 0, 128),
    ("first key", 0, 127),
    ("last key", 0, 127),
    ("middle key", 0, 127),
    ("reference key", 0, 127),
)


def read_scale(path, source):
    """The fields of a `Scale` from a ``.scl`` file; ``source`` names what asks for it in error messages."""
    lines = _lines(path, source)
    if len(lines) < 2:
        raise _refused(source, path, "it ends before the number of notes")
    (_, name), (line, text), rest = lines[0], lines[1], lines[2:]
    count = _whole(text.split()[0] if text.split() else "", 1, 1024)
    if count is None:
        raise _refused(source, path, f"line {line} is {text!r}, but the number of notes, from 1 to 1024, stands there")
    if len(rest) < count:
        raise _refused(source, path, f"it says {count} notes, but {len(rest)} follow")
    cents = []
    for line, text in rest[:count]:
        value = _pitch(text)
        if value is None:
            words = "a ratio such as 3/2 or a number of cents with a point, such as 701.955, stands there"
            raise _refused(source, path, f"line {line} is {text!r}, but {words}")
        cents.append(value)
    more = [text for _, text in rest[count:] if _pitch(text) is not None]
    if more:
        raise _refused(source, path, f"it says {count} notes, but {count + len(more)} follow")
    return {"name": name.strip() or path.stem, "cents": cents}


def read_keyboard(path, source):
    """The fields of a `Keyboard` from a ``.kbm`` file; ``source`` names what asks for it in error messages."""
    lines = _lines(path, source)
    if len(lines) < 7:
        raise _refused(source, path, f"it has {len(lines)} lines, but seven numbers stand before the map")
    words = [text.split()[0] if text.split() else "" for _, text in lines]
    head = []
    for (name, low, high), (line, text), word in zip(_HEAD, lines, words, strict=False):
        head.append(_whole(word, low, high))
        if head[-1] is None:
            what = f"the {name}, a whole number from {low} to {high}, stands there"
            raise _refused(source, path, f"line {line} is {text!r}, but {what}")
    size, first, last, middle, reference = head
    try:
        hz = float(words[5])
    except ValueError:
        hz = math.nan
    octave = _whole(words[6], 0, 1024)
    for value, row, name in ((hz, 5, "the reference frequency in Hz"), (octave, 6, "the degree of the octave")):
        if value is None or not math.isfinite(value):
            raise _refused(source, path, f"line {lines[row][0]} is {lines[row][1]!r}, but {name} stands there")
    degrees = _degrees(source, path, lines[7:], words[7:], size)
    return {
        "degrees": degrees,
        "first_key": first,
        "last_key": last,
        "middle_key": middle,
        "reference_key": reference,
        "reference_hz": hz,
        "octave_degree": octave,
    }


def _degrees(source, path, lines, words, size):
    """The map's entries as text; those that are left out at its end are unmapped."""
    rows = [(line, text, word) for (line, text), word in zip(lines, words, strict=True) if word]
    if len(rows) > size:
        raise _refused(source, path, f"it says that the map has {size} entries, but {len(rows)} follow")
    for line, text, word in rows:
        if word.lower() != _UNMAPPED and _whole(word, 0, 1024) is None:
            raise _refused(source, path, f"line {line} is {text!r}, but a degree of the scale or x stands there")
    found = [_UNMAPPED if word.lower() == _UNMAPPED else str(int(word)) for *_, word in rows]
    return found + [_UNMAPPED] * (size - len(found))


def _lines(path, source):
    """Numbered lines without comments; trailing empty ones are dropped."""
    try:
        text = path.read_text(encoding="latin-1")  # as Scala's archive; no byte is illegal in it
    except OSError as error:
        raise PresetError(f"{source} cannot be read: {error.strerror or error}", value=str(path)) from None
    lines = [(n, line) for n, line in enumerate(text.splitlines(), 1) if not line.startswith("!")]
    while lines and not lines[-1][1].strip():
        lines.pop()
    return lines


def _pitch(text):
    """Cents of a line of a scale, None if it holds no pitch; what follows the pitch is not looked at."""
    word = text.split()[0] if text.split() else ""
    if _CENTS.match(word):
        return float(word)
    ratio = _RATIO.match(word)
    if not ratio:
        return None
    over, under = int(ratio[1]), int(ratio[2] or 1)
    if not (0 < over <= MOST_WHOLE and 0 < under <= MOST_WHOLE):
        return None
    return 1200.0 * math.log2(over / under)


def _whole(word, low, high):
    return int(word) if re.fullmatch(r"\d{1,9}", word, re.ASCII) and low <= int(word) <= high else None


def _refused(source, path, words):
    return PresetError(f"{source}: {words}", value=str(path))
