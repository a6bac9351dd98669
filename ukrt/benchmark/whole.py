"""The whole engine, block by block: cases enter, times real time and quantiles of the blocks' times leave."""

import dataclasses
import time

import numpy as np

from ..drivers.files.bundled import ROMANCE
from ..drivers.files.midi import load_midi_file
from ..engine.engine import Engine
from ..radiation.impulse_response import load_impulse_response
from .cases import VELOCITY, chord_keys, guitar_of

RESPONSE_SECONDS = 0.5
RUNS = 5
QUANTILES = {"p50": 0.5, "p99": 0.99, "p99.9": 0.999, "max": 1.0}


def measure_cases(cases, guitar, rate, block, seconds, runs=RUNS, progress=lambda: None):
    """Run all cases in turns, so that what else the machine does falls on all of them alike.

    Parameters
    ----------
    cases : sequence of ukrt.benchmark.cases.Case
    guitar : ukrt.model.parameters.Guitar
    rate : float [Hz]
    block : int
        Frames computed at once.
    seconds : float [s]
        Sound computed in each run of each case.
    runs : int
    progress : callable
        Called after each run of each case.

    Returns
    -------
    list of dict
        For each case the times real time (median and all runs) and quantiles of the blocks' times [us].
    """
    runners = [Runner(case, guitar, rate, block) for case in cases]
    n_blocks = max(1, int(round(seconds * rate / block)))
    times = np.zeros((len(cases), runs, n_blocks))  # ns
    for turn in range(runs):
        for k, runner in enumerate(runners):
            times[k, turn] = runner.run(n_blocks)
            progress()
    return [_result(runner, times[k], block / rate) for k, runner in enumerate(runners)]


def _result(runner, times, block_s):
    speeds = times.shape[1] * block_s / (times.sum(axis=1) * 1e-9)
    quantiles = np.quantile(times * 1e-3, list(QUANTILES.values()))
    result = {
        "name": runner.case.name,
        "words": runner.case.words,
        "strings_plucked": runner.strings_plucked,
        "times_real_time": float(np.median(speeds)),
        "times_real_time_runs": [float(s) for s in speeds],
        "block_us": dict(zip(QUANTILES, map(float, quantiles), strict=True)),
        "histogram": _histogram(1e-3 * times),
    }
    runner.close()
    return result


def _histogram(times_us):
    """Blocks by their time, in bins of even ratio, sixteen to an octave."""
    low, high = np.floor(np.log2(times_us.min())), np.ceil(np.log2(times_us.max()))
    edges = 2.0 ** np.arange(low, high + 1 / 16, 1 / 16)
    counts, _ = np.histogram(times_us, edges)
    return {"edges_us": [float(edge) for edge in edges], "blocks": [int(count) for count in counts]}


class Runner:
    """One case, warmed up for a second.

    Parameters
    ----------
    case, guitar, rate, block
        As in `measure_cases`.
    """

    def __init__(self, case, guitar, rate, block):
        self.case, guitar = case, guitar_of(case, guitar)
        self._engine = Engine(guitar, float(rate), signal=case.signal, impulse_response=_response(case, guitar, rate))
        self._out = np.zeros((block, self._engine.channels))
        self._messages = _chord(case, guitar, rate) if case.chord else _piece(rate)
        self._turn, self._next, self._plucked = 0, 0, set()
        self.run(int(round(rate / block)))

    @property
    def strings_plucked(self):
        """How many strings have been plucked so far (int)."""
        self._plucked |= {note["string"] for note in self._engine.note_log() if note["string"] is not None}
        return len(self._plucked)

    def run(self, n_blocks):
        """Compute ``n_blocks`` blocks; returns each block's time [ns]."""
        times, engine, out = np.zeros(n_blocks), self._engine, self._out
        for k in range(n_blocks):
            self._send(engine.frame + len(out))
            start = time.perf_counter_ns()
            engine.process_into(out)
            times[k] = time.perf_counter_ns() - start
        return times

    def _send(self, end):
        """Queue the messages up to frame ``end``; what is played begins again after its period."""
        messages, period = self._messages
        while True:
            frame, *message = messages[self._next]
            frame += self._turn * period
            if frame >= end:
                return
            self._engine.send(frame, *message)
            self._next += 1
            if self._next == len(messages):
                self._next, self._turn = 0, self._turn + 1

    def close(self):
        """Give memory back."""
        self._engine.close()


def _chord(case, guitar, rate):
    """The chord plucked each second: messages (frame, status, data1, data2), and their period in frames."""
    return [(0, 0x90, key, VELOCITY) for key in chord_keys(case.chord, guitar)], int(rate)


def _piece(rate):
    """The bundled piece, in the same form."""
    score = load_midi_file(ROMANCE)
    columns = (np.rint(score.time_s * rate), score.status, score.data1, score.data2)
    messages = [tuple(int(value) for value in row) for row in zip(*columns, strict=True)]
    return messages, int(round(score.duration_s * rate)) + 1


def _response(case, guitar, rate):
    """The guitar's impulse response, cut or continued with zeros to the length that is measured."""
    if case.signal != "pressure":
        return None
    response = load_impulse_response(guitar.radiation.impulse_response, rate)
    samples = np.zeros((int(round(RESPONSE_SECONDS * rate)), 2, 2))
    taps = min(len(samples), len(response.samples))
    samples[:taps] = response.samples[:taps]
    return dataclasses.replace(response, samples=samples)
