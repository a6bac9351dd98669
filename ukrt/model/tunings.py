"""Tunings in words: names of notes, letters or the name of a tuning enter, MIDI notes leave; and keys of a preset that
stand for others, ``tuning.open_strings``, ``tuning.scale`` and ``tuning.keyboard``, are written out."""

import re
from pathlib import Path

from ..errors import ParameterError
from .scala import read_keyboard, read_scale

NOTE_NAMES = ("C", "C#", "D", "D#", "E", "F", "F#", "G", "G#", "A", "A#", "B")
NAMED = {  # guitars and ukuleles; each as players spell it, lowest octave at the bass side
    "standard": "E2 A2 D3 G3 B3 E4",
    "half-step-down": "Eb2 Ab2 Db3 Gb3 Bb3 Eb4",
    "drop-d": "D2 A2 D3 G3 B3 E4",
    "double-drop-d": "D2 A2 D3 G3 B3 D4",
    "drop-c": "C2 G2 C3 F3 A3 D4",
    "dadgad": "D2 A2 D3 G3 A3 D4",
    "open-c": "C2 G2 C3 G3 C4 E4",
    "open-d": "D2 A2 D3 F#3 A3 D4",
    "open-e": "E2 B2 E3 G#3 B3 E4",
    "open-g": "D2 G2 D3 G3 B3 D4",
    "open-a": "E2 A2 E3 A3 C#4 E4",
    "lute": "E2 A2 D3 F#3 B3 E4",
    "ukulele": "G4 C4 E4 A4",
    "low-g": "G3 C4 E4 A4",
}
OPEN_STRINGS = "tuning.open_strings"
_FILES = {"scale": (".scl", read_scale), "keyboard": (".kbm", read_keyboard)}
_NOTE = re.compile(r"([A-G])([#b]?)(-?\d+)?")


def note_name(note):
    """Name of a MIDI note with its octave; 60 is C4."""
    return f"{NOTE_NAMES[note % 12]}{note // 12 - 1}"


def parse_tuning(text, present):
    """MIDI notes of open strings.

    Parameters
    ----------
    text : str
        A name out of `NAMED`; MIDI notes or names, "D2 A2 D3 G3 B3 E4"; or letters without octaves, "DADGBE", each of
        which moves its string by as little as can be (down, where there are two ways).
    present : sequence of int
        MIDI notes of the strings as they are, that on the bass side first.

    Returns
    -------
    list of int

    Raises
    ------
    ParameterError
    """
    words = re.split(r"[\s,]+", NAMED.get(text, text).strip())
    if len(words) == 1 and "".join(match[0] for match in _NOTE.finditer(words[0])) == words[0]:
        words = [match[0] for match in _NOTE.finditer(words[0])]
    if len(words) != len(present):
        known = ", ".join(name for name, notes in NAMED.items() if len(notes.split()) == len(present))
        ways = f'notes such as "{" ".join(map(note_name, present))}"' + (f" or one of {known}" if known else "")
        raise ParameterError(OPEN_STRINGS, text, f"this guitar has {len(present)} strings and wants {ways}")
    return [_parsed(text, word, now) for word, now in zip(words, present, strict=True)]


def expand(tree, folder, source):
    """Write out, in place, the keys of a preset's tree that stand for others.

    Parameters
    ----------
    tree : dict
        Of a whole preset, base and all.
    folder : pathlib.Path
        What names of files are relative to.
    source : str
        What the preset is called in error messages.

    Raises
    ------
    PresetError
        A file that cannot be read or understood.
    ParameterError
        A tuning that cannot be understood.
    """
    tuning = tree.get("tuning")
    if not isinstance(tuning, dict):
        return
    tree["tuning"] = tuning = dict(tuning)
    for key, (suffix, read) in _FILES.items():
        if isinstance(name := tuning.get(key), str):
            if not name.lower().endswith(suffix):
                raise ParameterError(f"tuning.{key}", name, f"it must be a table, or the name of a {suffix} file")
            path = folder / Path(name)
            tuning[key] = read(path, f"{source}: tuning.{key} {path}")
    if "open_strings" in tuning:
        _tune(tree, tuning.pop("open_strings"))


def _tune(tree, text):
    """Give the strings of a tree other notes; tensions follow, as a first guess or, in mode published, for good."""
    strings = tree.get("strings")
    notes = [one.get("note") for one in strings or () if isinstance(one, dict)] if isinstance(strings, list) else []
    if not notes or not all(isinstance(note, int) for note in notes):
        raise ParameterError(OPEN_STRINGS, text, "there must be strings with notes that it can change")
    if not isinstance(text, str):
        raise ParameterError(OPEN_STRINGS, text, "it must be text in quotes")
    changed = []
    for one, note in zip(strings, parse_tuning(text, notes), strict=True):
        ratio = 2.0 ** ((note - one["note"]) / 6.0)
        if ratio != 1.0:
            tension = one.get("tension", 0.0) * ratio
            if not 1.0 <= tension <= 500.0:
                words = f"{note_name(note)} on {one.get('name')} needs about {tension:.3g} N, and 1 to 500 N are legal"
                raise ParameterError(OPEN_STRINGS, text, words)
            one = one | {"note": note, "name": note_name(note), "tension": tension}
        changed.append(one)
    tree["strings"] = changed


def _parsed(text, word, now):
    """The MIDI note that one word stands for, on a string that has note ``now``."""
    note = None
    if re.fullmatch(r"\d{1,3}", word, re.ASCII):
        note = int(word)
    elif match := _NOTE.fullmatch(word):
        pitch = NOTE_NAMES.index(match[1]) + {"#": 1, "b": -1, "": 0}[match[2]]
        octave = match[3]
        note = pitch + 12 * (int(octave) + 1) if octave else now + (pitch - now + 6) % 12 - 6
    if note is None or not 0 <= note <= 127:
        words = "its words must be MIDI notes from 0 to 127, or names with capital letters such as F#3, Bb or A"
        raise ParameterError(OPEN_STRINGS, text if word == text else f"{text} ({word})", words)
    return note
