"""Scores and sheets for the tests of notation, without files."""

import random

import numpy as np

from ukrt.drivers.files.bars import Bars, Sequence
from ukrt.drivers.files.midi import Score
from ukrt.drivers.files.tempo_map import TempoMap
from ukrt.notation.sheet import make_sheet

TICKS = 960
OPEN = [40, 45, 50, 55, 59, 64]


def make_score(events, quarters, tempos=(), signatures=(), keys=(), markers=()):
    """A score of ``events`` (quarter notes, status, data1, data2), ``quarters`` long; changes are (quarter, ...)."""
    clock = TempoMap([(round(q * TICKS), tempo) for q, tempo in tempos], TICKS, None)
    scaled = [tuple((round(q * TICKS), *rest) for q, *rest in changes) for changes in (signatures, keys)]
    bars = Bars([Sequence(0.0, clock, round(quarters * TICKS), *scaled)])
    events = sorted(events, key=lambda event: event[0])
    ticks = np.array([round(q * TICKS) for q, *_ in events], dtype=np.int64)
    columns = np.array([message for _, *message in events], dtype=np.uint8).reshape(-1, 3).T
    n_notes = sum(status >> 4 == 9 and velocity > 0 for _, status, _, velocity in events)
    times = [(clock.seconds(round(q * TICKS)), name) for q, name in markers]
    return Score(clock.seconds_array(ticks), *columns, clock.seconds(round(quarters * TICKS)), n_notes,
                 markers=tuple(times), bars=bars, title="Étude")  # fmt: skip


def row(score, quarters, string, fret, articulation="pluck", end=None, late_s=0.0):
    """A row of the player's log; times in quarter notes of a score with one sequence."""
    clock = score.bars._spans[0].sequence.clock
    start = clock.seconds(round(quarters * TICKS)) + late_s
    return {
        "time_s": start,
        "end_s": None if end is None else clock.seconds(round(end * TICKS)),
        "midi": OPEN[string] + fret,
        "string": string,
        "fret": fret,
        "articulation": articulation,
        "fate": "played",
    }


def random_rows(rng, score, quarters, steps=(1, 2, 3, 4, 6, 8)):
    """Random notes on grids that change with every quarter note, no string twice at a time."""
    rows = []
    for unit in range(quarters):
        parts = rng.choice(steps)
        for cell in rng.sample(range(parts), rng.randint(0, parts)):
            for string in rng.sample(range(6), rng.randint(1, 3)):
                rows.append(row(score, unit + cell / parts, string, rng.randrange(20)))
    return sorted(rows, key=lambda row: row["time_s"])


def random_sheet(seed, quarters=20):
    """(score, rows, sheet) with changes of tempo, time and key."""
    rng = random.Random(seed)
    signatures = [(0, rng.choice([2, 3, 4]), 4), (8, 6, 8), (14, 2, 2)]
    tempos = [(0, 600_000), (5, 1_000_000)]
    score = make_score([], quarters, tempos, signatures, [(0, -2)], [(8, "Chorus")])
    rows = random_rows(rng, score, quarters)
    return score, rows, make_sheet(score, "classical", rows, OPEN)
