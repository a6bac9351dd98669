"""Convolvers beside each other: 48000 taps, blocks of 64 frames, cost for each pair of an input and an output."""

import functools
import statistics
from collections.abc import Callable
from dataclasses import dataclass

import ukrt

from .peer import SOURCES, PeerError, called, debian_version, program_path, worker

TAPS = 48000
SECONDS = 30.0  # of sound in each run; a second more before it fills caches
PACKAGES = ("libzita-convolver-dev", "libfftw3-dev", "g++")


@dataclass(frozen=True)
class Convolver:
    """One to be measured: its pairs of inputs and outputs, and how its command and version are found."""

    name: str
    computes: str
    pairs: int
    packages: tuple
    prepare: Callable


def _zita(inputs, outputs, work):
    program = work.program(SOURCES / "zita_blocks.cpp", "-lzita-convolver", "-lfftw3f", "-lpthread")
    command = [program, str(inputs), str(outputs), str(TAPS), str(SECONDS)]
    return command, debian_version("libzita-convolver4")


def _ukrt(_work):
    return worker("ukrt_blocks", TAPS, SECONDS), ukrt.__version__


PARTS = "non-uniform partitions, float32, larger ones in threads"
CONVOLVERS = (
    Convolver("ukrt, 2 in 2 out", "non-uniform partitions, float64, one thread, spread evenly", 4, (), _ukrt),
    Convolver("zita-convolver, 2 in 2 out", PARTS, 4, PACKAGES, functools.partial(_zita, 2, 2)),
    Convolver("zita-convolver, 1 in 1 out", PARTS, 1, PACKAGES, functools.partial(_zita, 1, 1)),
)


def in_turns(convolvers, runs, work, say):
    """Measure all in turns.

    Returns
    -------
    results : list of dict
        ``name``, ``computes``, ``version``, ``pairs``; medians of the runs: ``percent`` of a core, ``percent_a_pair``,
        ``p50_us``, ``p99_us``.
    failed : dict of str to str
        Those left out, and why.
    """
    commands, failed = {}, {}
    for one in convolvers:
        try:
            commands[one] = one.prepare(work)
        except PeerError as error:
            failed[one.name] = str(error)
    taken = {one: [] for one in commands}
    for turn in range(runs):
        for one in [one for one in commands if one.name not in failed]:
            try:
                taken[one].append(_numbers(commands[one][0]))
                say(f"turn {turn + 1}, {one.name}: {100 * taken[one][-1][0] / SECONDS:.3g} % of a core")
            except PeerError as error:
                failed[one.name] = str(error)
    return [_result(one, commands[one][1], taken[one]) for one in commands if one.name not in failed], failed


def _numbers(command):
    program_path(command[0])
    words = called(*command).split()
    return [float(word) for word in words[-3:]]


def _result(one, version, runs):
    cpu, p50, p99 = (statistics.median(column) for column in zip(*runs, strict=True))
    percent = 100.0 * cpu / SECONDS
    facts = {"name": one.name, "computes": one.computes, "version": version, "pairs": one.pairs}
    return facts | {"percent": percent, "percent_a_pair": percent / one.pairs, "p50_us": p50, "p99_us": p99}
