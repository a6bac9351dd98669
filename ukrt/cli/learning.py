"""``ukrt play --learn``: what a player types and moves enters; a mapping of controllers, kept in a file, leaves.

It is looked after by the session, which plays meanwhile. While it listens for a knob, controllers mean what their
numbers say, or it would hear what they have been made to mean.
"""

import io
import queue
import sys
import threading
import time

from ..drivers.midi.listen import Listener
from ..drivers.midi.mapping import Mapped, Mapping, mapping_text
from ..engine.controller_names import FUNCTIONS, NOTHING
from ..engine.stage_layout import AT_ONCE, KIND_MIDI, KIND_SHIFT
from .common import UsageError
from .report import write_whole

NAMES = (*FUNCTIONS, NOTHING)
_HELP = "type a function's name to learn it, forget NAME, clear, list, or an empty line to go on playing"


def wanted_functions(words):
    """The functions that ``--learn`` names (list of str); none: they are asked for."""
    names = [word.strip() for word in words.split(",") if word.strip()]
    for name in names:
        if name not in NAMES:
            raise UsageError(f"--learn {name}: no function is called so, there are {', '.join(NAMES)}")
    return list(dict.fromkeys(names))


def _typed_lines():
    """Reads lines from standard input without its buffer, whose lock a thread must not hold when Python ends."""
    return io.FileIO(sys.stdin.fileno(), closefd=False).readline


class Controllers:
    """What live controllers mean on an engine.

    Parameters
    ----------
    mapping : Mapping
    path : pathlib.Path or None
        Where it was read and is kept; None: nowhere.
    """

    def __init__(self, mapping, path):
        self.mapping, self.path = mapping, path

    def put_on(self, engine):
        """Let it count, from now on, for all that arrives live."""
        engine.stage.set_map(self.mapping.table())

    def keep(self, mapping):
        """Take over another one, and write it."""
        self.path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(self.path, mapping_text(mapping).encode(), "--learn")
        self.mapping = mapping

    def describe(self):
        """For the report (dict)."""
        return {"file": self.path and str(self.path), "controllers": [str(one) for one in self.mapping.controllers]}


class Learning:
    """The dialogue; does nothing any more once ``over``.

    Parameters
    ----------
    engine : Engine
    controllers : Controllers
    names : list of str
        What is to be learned one after another; empty: what is typed.
    say : callable (str)
    read : callable () -> bytes, optional
        A line that was typed, nothing at the end of all; by default from standard input.
    """

    def __init__(self, engine, controllers, names, say, read=None):
        self._engine, self._controllers, self._say = engine, controllers, say
        self._names, self._asking = list(names), not names
        self._listener, self._words, self._lines = Listener(), queue.SimpleQueue(), queue.SimpleQueue()
        self._function, self.over = None, False
        if self._asking:
            say(f"learn: there are {', '.join(NAMES)}")
            say(f"learn: {_HELP}")
            threading.Thread(target=self._type, args=(read or _typed_lines(),), daemon=True).start()
        self._next()

    def hear(self, entries):
        """What has acted on the engine (ndarray (n, 2) of frames and words); called by the recorder's thread."""
        words = entries[:, 1]
        for word in words[words >> KIND_SHIFT == KIND_MIDI].tolist():
            self._words.put(word)

    def _type(self, read):
        while line := read():
            self._lines.put(line.decode(errors="replace").strip())
        self._lines.put("")

    def turn(self):
        """To be called about twenty times a second."""
        now = time.monotonic()
        while not self._words.empty():
            self._listener.take(self._words.get(), now)
        while not self._lines.empty() and not self.over:
            self._command(self._lines.get())
        if self._function is not None and (heard := self._listener.gesture(now)) is not None:
            self._learn(heard)

    def _next(self):
        """Listen for the next of the functions that were named; over where there is none."""
        if self._names:
            self._listen(self._names.pop(0))
        elif not self._asking:
            self._end()

    def _listen(self, function):
        self._function = function
        self._listener.restart()
        self._mean(Mapping())
        self._say(f"learn: {function}: move its knob, wheel or pedal through all of its range, then let it rest")

    def _learn(self, heard):
        notes = self._listener.notes_channel
        plays = notes if notes and notes != heard.channel else 0
        new = Mapped(self._function, heard.source, heard.channel, plays)
        self._keep(self._controllers.mapping.learned(new), f"heard {heard}: {new}")
        self._function = None
        self._next()

    def _keep(self, mapping, words):
        try:
            self._controllers.keep(mapping)
        except (UsageError, OSError) as error:
            self._say(f"learn: {words}, but it cannot be kept: {error}")
        else:
            self._say(f"learn: {words}; kept in {self._controllers.path}")
        self._mean(self._controllers.mapping)

    def _mean(self, mapping):
        """Let ``mapping`` count; what was moved under another one goes back, or nobody could move it any more."""
        self._engine.stage.set_map(mapping.table())
        for channel in range(16):
            self._engine.send(AT_ONCE, 0xB0 | channel, 121, 0)

    def _command(self, line):
        words = line.split()
        match words:
            case []:
                self._end()
            case ["list"]:
                self._say(f"learn: {self._controllers.mapping}")
            case ["clear"]:
                self._stop()
                self._keep(Mapping(), "all is forgotten")
            case ["forget", name] if name in NAMES:
                self._stop()
                self._keep(self._controllers.mapping.without(name), f"{name} is forgotten")
            case [name] if name in NAMES:
                self._listen(name)
            case _:
                self._say(f"learn: {line!r} is not understood; {_HELP}")

    def _stop(self):
        """Listen no longer for what has not been moved."""
        self._function = None

    def _end(self):
        if self._function is not None:
            self._stop()
            self._mean(self._controllers.mapping)
        self.over = True
        self._say(f"learn: over; {self._controllers.mapping}")
