"""What a peer is: how it is made ready, and the command that renders so many seconds of the piece with it."""

import pathlib
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass

from . import piece

SAMPLE_RATE = 48000
BLOCK = 64  # frames
SOURCES = pathlib.Path(__file__).resolve().parent
FLAGS = ("-O3", "-march=native", "-ffast-math", "-std=c++17")  # of g++, for programs compiled here


class PeerError(Exception):
    """A peer cannot be had or does not run; says why in one line."""


@dataclass(frozen=True)
class Peer:
    """A system that is compared.

    Attributes
    ----------
    name : str
    computes : str
        In a few words what it computes, for the table.
    packages : tuple of str
        Debian's names of what it needs.
    prepare : callable (Work) -> Ready
        Raises PeerError where the system is absent or broken.
    """

    name: str
    computes: str
    packages: tuple
    prepare: Callable


@dataclass(frozen=True)
class Ready:
    """A peer that can run.

    Attributes
    ----------
    command : callable (seconds, path) -> list of str
        Renders so many seconds of the piece into a sound file.
    version : str
    seconds : (float, float), optional
        Of the short and the long render, where they are not those of all.
    note : str
        To be printed below the table.
    counts_itself : bool
        Whether the last thing that it prints is the CPU time that its rendering took [s].
    """

    command: Callable
    version: str
    seconds: tuple = ()
    note: str = ""
    counts_itself: bool = False


class Work:
    """A folder in which the piece lies as the peers want it, and what is made for them."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.notes, self._written = piece.make_piece(), set()

    def path(self, name):
        """A file's path in the folder."""
        return self.folder / name

    def file(self, name, write):
        """A file in the folder, written anew by ``write(path)`` when it is first asked for (its path as str)."""
        path = self.path(name)
        if name not in self._written:
            write(path)
            self._written.add(name)
        return str(path)

    def midi(self, seconds):
        """The first seconds of the piece as a MIDI file (its path)."""
        notes = piece.first_seconds(self.notes, seconds)
        return self.file(f"piece-{seconds:g}.mid", lambda path: piece.write_midi(path, notes, seconds))

    def events(self, seconds):
        """The first seconds of the piece as lines for the C++ programs (its path)."""
        notes = piece.first_seconds(self.notes, seconds)
        return self.file(
            f"piece-{seconds:g}.events", lambda path: piece.write_events(path, notes, seconds, SAMPLE_RATE)
        )

    def program(self, source, *arguments, name=None):
        """Compile a C++ program of this folder, or one that was made (its path)."""
        target = self.path(name or pathlib.Path(source).stem)
        called("g++", *FLAGS, str(source), f"-I{SOURCES}", *arguments, "-o", str(target))
        return str(target)


def program_path(name):
    """Where a program is; PeerError if it is not installed."""
    if (path := shutil.which(name)) is None:
        raise PeerError(f"{name} is not installed")
    return path


def called(name, *arguments, timeout=600, **options):
    """Run a program and return what it printed, both streams (str).

    Raises
    ------
    PeerError
        It is not installed, or failed: the last line it wrote.
    """
    streams = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "stdin": subprocess.DEVNULL}
    try:
        run = subprocess.run([program_path(name), *arguments], timeout=timeout, **streams, **options)
    except subprocess.TimeoutExpired:
        raise PeerError(f"{name} took more than {timeout} s") from None
    text = run.stdout.decode(errors="replace")
    if run.returncode:
        raise PeerError(f"{name} failed: {last_line(text) or f'exit code {run.returncode}'}")
    return text


def last_line(text):
    """The last line that says something, preferring one that speaks of an error (str)."""
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    errors = [line for line in lines if "error" in line.lower()]
    return (errors or lines or [""])[-1]


def debian_version(package):
    """The version of an installed package, as Debian counts it (str); ``?`` where dpkg does not know."""
    try:
        return called("dpkg-query", "-W", "-f=${Version}", package).strip()
    except PeerError:
        return "?"


def worker(module, *arguments):
    """The command that runs a module of this folder in a Python of its own (list of str)."""
    return [sys.executable, "-m", f"peers.{module}", *map(str, arguments)]
