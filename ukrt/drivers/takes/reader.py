"""Reads takes: a file enters, a `Take` with everything that a replay needs leaves.

A take that was cut off anywhere (by a crash, a full disk, a copy that broke off) is read up to there, with a sentence
that says so. What stands behind the end of the track is not looked at: it is what a killed recorder had not yet let
count. Nothing that a file holds raises anything but a `UkrtError`.
"""

import dataclasses
import json
import math
import pathlib
import re
from array import array

import numpy as np

from ukrt.drivers.files.midi_events import END_OF_TRACK, META, BrokenTrackError, read_at_most, track_events
from ukrt.drivers.takes.take import EVENT_NAMES, FORMAT, MARK, TEXT, Sound, file_head, piece_of, word_of
from ukrt.engine.stage_layout import KIND_SHIFT, KIND_SWAP, VALUE_MASK
from ukrt.errors import MidiFileError, UkrtError
from ukrt.model.presets import parse_preset

MAX_BYTES = 1 << 28  # 60 million messages; bounds time and memory
_HEAD_BYTES = len(file_head(1, 0))
_KINDS = {name: kind for kind, name in EVENT_NAMES.items()}
_SIGNALS = ("pressure", "bridge-force", "strings")
_PART = re.compile(rb"(\d{1,9}) part (\d{1,6}) of (\d{1,6})\n(.*)", re.DOTALL)
_SWAP = re.compile(rb"(\d{1,9}) (\{.*\})", re.DOTALL)
_MESSAGE = re.compile(rb"([0-9A-F]{2}) ([0-9A-F]{2}) ([0-9A-F]{2})")


@dataclasses.dataclass(frozen=True)
class Take:
    """What was played.

    Attributes
    ----------
    path : pathlib.Path
    signal : str
    channels : int
    settings : dict
        The engine's.
    version : str
        Of ukrt.
    environment : dict of str to str
        See `ukrt.drivers.takes.take.environment`.
    sounds : dict of int to Sound
        The guitar that begins (0), and what each swap brings.
    presets : dict of int to str
        The same guitars as text.
    event_frames, event_words : ndarray (n,) int64
        The journal: frames do not decrease; words as `ukrt.engine.stage_layout` says.
    frames : int
        Computed in all.
    lost : int
        Entries that are missing.
    warnings : tuple of str
        What was odd, in sentences.
    """

    path: pathlib.Path
    signal: str
    channels: int
    settings: dict
    version: str
    environment: dict
    sounds: dict
    presets: dict
    event_frames: np.ndarray
    event_words: np.ndarray
    frames: int
    lost: int
    warnings: tuple

    @property
    def sample_rate(self):
        """Frames per second at the beginning [Hz]."""
        return self.sounds[0].sample_rate

    def parts(self):
        """Stretches of one sample rate: list of (first frame, frame after the last, sample rate [Hz])."""
        rate, first, found = self.sample_rate, 0, []
        swaps = np.flatnonzero(self.event_words >> KIND_SHIFT == KIND_SWAP)
        for k in swaps.tolist():
            frame, then = int(self.event_frames[k]), self.sounds[int(self.event_words[k]) & VALUE_MASK].sample_rate
            if then != rate:
                found.append((first, frame, rate))
                rate, first = then, frame
        return [part for part in (*found, (first, self.frames, rate)) if part[1] > part[0]] or [(0, 0, rate)]


def is_take(path):
    """Whether a file begins as takes do; False also for what cannot be read."""
    try:
        path = pathlib.Path(path)
        if not path.is_file():
            return False
        with path.open("rb") as file:
            head = file.read(_HEAD_BYTES + 32)
    except (OSError, ValueError):  # ValueError: a NUL in the name
        return False
    return head[:4] == b"MThd" and MARK.encode() in head[_HEAD_BYTES:]


def read_take(path):
    """Read a take.

    Raises
    ------
    MidiFileError
        One sentence: nothing of it can be played. What can be played in part is; see ``warnings``.
    """
    path = pathlib.Path(path)
    try:
        data = read_at_most(path, MAX_BYTES)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise MidiFileError(f"{path}: cannot be read ({reason}), a readable take is needed") from None
    if len(data) > MAX_BYTES:
        raise MidiFileError(f"{path}: is larger than {MAX_BYTES >> 20} MB, the most a take may have")
    if data[:4] != b"MThd" or data[14:18] != b"MTrk":
        raise MidiFileError(f"{path}: is no take, which is a MIDI file with a single track")
    return _Reader(path, int.from_bytes(data[12:14], "big")).read(data)


class _Reader:
    """Collects what the events of one take say."""

    def __init__(self, path, division):
        self.path, self.division = path, division
        self.frames, self.words = array("q"), array("q")
        self.header, self.parts, self.sounds, self.presets = None, {}, {}, {}
        self.lost, self.end, self.warnings = 0, 0, []

    def read(self, data):
        try:
            self._read_events(data)
        except BrokenTrackError as cut:
            self.warnings.append(f"the take breaks off at frame {self.end} ({cut}) and is played up to there")
        if self.header is None:
            raise MidiFileError(f"{self.path}: is no take, whose first event is the text {MARK}{FORMAT}")
        if 0 not in self.sounds:
            reason = self.warnings[0] if self.warnings else "its preset is not complete"
            raise MidiFileError(f"{self.path}: nothing of it can be played: {reason}")
        if self.lost:
            self.warnings.append(
                f"{self.lost} entries were lost while the take was recorded, so the sound is not what was heard"
            )
        header = self.header
        return Take(
            self.path, header["signal"], header["channels"], header["settings"], str(header.get("ukrt")),
            header.get("environment") or {}, self.sounds, self.presets, np.array(self.frames, dtype=np.int64),
            np.array(self.words, dtype=np.int64), self.end, self.lost, tuple(self.warnings),
        )  # fmt: skip

    def _read_events(self, data):
        for frame, status, data1, data2, raw, _ in track_events(data, _HEAD_BYTES, len(data)):
            if status < 0xF0:
                self._note(frame, word_of(status, data1, data2))
            elif raw is None:
                raise BrokenTrackError(f"byte 0x{status:02X}, which no MIDI file may hold")
            elif (status, data1) == (META, TEXT) and raw.startswith(b"ukrt "):
                self._text(frame, raw)
            elif status != META and (piece := piece_of(status, raw)):
                self._note(frame, word_of(*piece))
            self.end = frame
            if (status, data1) == (META, END_OF_TRACK):
                return
        raise BrokenTrackError("the file ends before the track does")

    def _note(self, frame, word):
        self.frames.append(frame)
        self.words.append(word)

    def _text(self, frame, raw):
        """One of our own text events."""
        _, name, rest = (*raw.split(b" ", 2), b"")[:3]
        name = name.decode("latin-1")
        if name == "take" and self.header is None:
            self.header = self._header(rest)
        elif self.header is None:
            raise BrokenTrackError(f"its text {_shown(raw)} comes before the head of the take")
        elif name == "preset" and (found := _PART.fullmatch(rest)):
            self._part(*map(int, found.groups()[:3]), found[4])
        elif name == "swap" and (found := _SWAP.fullmatch(rest)):
            self._swap(frame, int(found[1]), _tree(found[2]))
        elif name == "message" and (found := _MESSAGE.fullmatch(rest)):
            self._note(frame, word_of(*(int(byte, 16) for byte in found.groups())))
        elif name in (*_KINDS, "lost") and re.fullmatch(rb"\d{1,10}", rest) and int(rest) <= VALUE_MASK:
            if name == "lost":
                self.lost += int(rest)
            else:
                self._note(frame, _KINDS[name] << KIND_SHIFT | int(rest))
        else:
            raise BrokenTrackError(f"its text {_shown(raw)} means nothing")

    def _header(self, raw):
        """The tree that says what the take is, everything about it checked."""
        number, _, rest = raw.partition(b" ")
        if number != str(FORMAT).encode():
            found = _shown(number)
            raise MidiFileError(f"{self.path}: is a take of format {found}, {FORMAT} is the only one known here")
        try:
            tree = _tree(rest)
        except BrokenTrackError as reason:
            raise MidiFileError(f"{self.path}: the head of the take cannot be read: {reason}") from None
        checks = {
            "sample_rate": (_is_rate, "a number of hertz"),
            "signal": (lambda value: value in _SIGNALS, f"one of {', '.join(_SIGNALS)}"),
            "channels": (lambda value: type(value) is int and 1 <= value <= 64, "a whole number from 1 to 64"),
            "settings": (lambda value: isinstance(value, dict), "a table"),
            "division": (
                lambda value: value == self.division,
                f"{self.division} as in the file's head (another program may have saved the take; "
                "--preset renders it like any MIDI file)",
            ),
        }
        for key, (is_right, words) in checks.items():
            if not is_right(tree.get(key)):
                found = _shown(repr(tree.get(key)))
                raise MidiFileError(f"{self.path}: the take's {key} is {found}, but it must be {words}")
        if not isinstance(tree.get("environment", {}), dict):
            tree["environment"] = {}
        return tree

    def _part(self, n, k, count, raw):
        """Part ``k`` of the text of preset ``n``."""
        parts = self.parts.setdefault(n, {})
        parts[k] = raw
        if n == 0 and 0 not in self.sounds and len(parts) == count:
            self.sounds[0] = self._sound(0, self.header)

    def _sound(self, n, tree):
        """The guitar of preset ``n`` with what ``tree`` says of how it sounds."""
        parts = self.parts.get(n, {})
        whole = b"".join(parts[k] for k in sorted(parts))
        try:
            words = whole.decode("utf-8")
        except UnicodeDecodeError:
            raise BrokenTrackError(f"its preset {n} is not text in UTF-8") from None
        guitar = parse_preset(words, f"{self.path}: its preset {n}")
        self.presets[n] = words
        gain = tree.get("output_gain", 1.0)
        if type(gain) not in (int, float) or not 0.0 <= gain < 1e9:
            raise BrokenTrackError(f"the output_gain of its preset {n} is {_shown(repr(gain))}")
        return Sound(guitar, float(tree["sample_rate"]), _response(tree.get("impulse_response")), float(gain))

    def _swap(self, frame, n, tree):
        if not _is_rate(tree.get("sample_rate")) or n == 0:
            raise BrokenTrackError(f"its swap {n} has no sample rate, or no number above 0")
        try:
            self.sounds[n] = self._sound(n, tree)
        except UkrtError as error:
            raise BrokenTrackError(str(error)) from None
        self._note(frame, KIND_SWAP << KIND_SHIFT | n)


def _tree(raw):
    """A JSON object from bytes."""
    try:
        tree = json.loads(raw)
    except (ValueError, RecursionError):  # ValueError: no JSON, no UTF-8, numbers of thousands of digits
        raise BrokenTrackError(f"{_shown(raw)} is not JSON") from None
    if not isinstance(tree, dict):
        raise BrokenTrackError(f"{_shown(raw)} is no JSON object")
    return tree


def _response(tree):
    """What is known of an impulse response: a dict of texts, or None."""
    keys = ("name", "file", "sha256")
    if not isinstance(tree, dict) or not all(isinstance(tree.get(key), str) for key in keys):
        return None
    return {key: tree[key] for key in keys}


def _is_rate(value):
    return type(value) in (int, float) and 0 < value < 1e9 and math.isfinite(value)


def _shown(raw, limit=40):
    """A few characters of what was found, printable."""
    words = raw if isinstance(raw, str) else raw.decode("latin-1")
    words = "".join(letter if letter.isprintable() else "?" for letter in words)
    return words if len(words) <= limit else words[: limit - 3] + "..."
