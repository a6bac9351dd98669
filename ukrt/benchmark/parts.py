"""What a sample costs, part by part, and how near the sweeps over the modes come to what the processor can do.

The engine's kernels run by themselves on the arrays of an engine that has just been played; a part is as dear as the
quickest of many repetitions, which no other process has disturbed.
"""

import time
from dataclasses import asdict, dataclass

import numpy as np

from ..engine import gestures as do
from ..engine import layout as at
from ..engine import player_layout as player_at
from ..engine.engine import Engine
from ..engine.kernels.ramps import BEND_EVERY
from . import loops
from .cases import G_MAJOR, VELOCITY, chord_keys

SAMPLES = 512  # in one repetition
REPETITIONS = 400
PASSES = 2000  # of the loops that find out what the processor can do
FRAMES_BEFORE = 0.3  # s of sound before the parts are measured


@dataclass(frozen=True)
class Roofline:
    """What bounds the sweeps (Williams, Waterman and Patterson, Communications of the ACM 52(4), 2009).

    Attributes
    ----------
    flops, bytes : float
        Of all strings' sweeps, for each sample; a multiply-add is two flops.
    peak_flops, peak_bytes : float [1/s]
        What a loop of multiply-adds, and one that reads and writes 16 KiB, reach on this core.
    measured_ns : float
        What the sweeps take for each sample.
    """

    flops: float
    bytes: float
    peak_flops: float
    peak_bytes: float
    measured_ns: float

    @property
    def least_ns(self):
        """The time below which no code that does this work can come on this core [ns]."""
        return 1e9 * max(self.flops / self.peak_flops, self.bytes / self.peak_bytes)

    @property
    def share(self):
        """What is reached of that (0..1)."""
        return self.least_ns / self.measured_ns


def measure_parts(guitar, rate):
    """Cost of each part, with the guitar playing a G major chord of which half the strings are stopped.

    Parameters
    ----------
    guitar : ukrt.model.parameters.Guitar
    rate : float [Hz]

    Returns
    -------
    dict
        ``parts_ns``: cost of each part for each sample; ``gestures_us``: of each message or gesture; ``roofline``: what
        `Roofline` holds.
    """
    bench = _Bench(guitar, rate)
    columns = sorted({int(n) for n in bench.extra})
    sweeps = {n: bench.best(loops.sweep_strings, n) for n in columns}
    parts = {_sweep_name(n): cost for n, cost in sweeps.items()}
    linear = {n: bench.best(loops.sweep_linear, n) for n in columns if n in (0, 3)}
    parts["of these, tension modulation"] = sum(sweeps[n] - cost for n, cost in linear.items())
    parts["constraint solve and body"] = bench.best(loops.solve_samples, 0)
    parts["convolution"] = bench.convolution()
    roofline = Roofline(*bench.work(), *_peaks(), sum(sweeps.values()))
    gestures = {
        "a note-on or note-off, string and fret chosen": bench.message(),
        "a finger lands: ports and coefficients made anew": bench.gesture(1, do.PRESS, 0.25, 240.0),
        "a damper lands": bench.gesture(1, do.DAMP, 1.0, 384.0),
        "a bend, one step of 32 samples": bench.gesture(BEND_EVERY, do.TENSION, 1.01, BEND_EVERY),
        "a slide, 32 samples": bench.gesture(BEND_EVERY, do.PRESS, 0.15, 4800.0),
    }
    bench.close()
    more = {"least_ns": roofline.least_ns, "share": roofline.share}
    return {"parts_ns": parts, "gestures_us": gestures, "roofline": {**asdict(roofline), **more}}


def _sweep_name(extra):
    return "strings without contact" if extra == 0 else f"strings with {extra} contact{'s' if extra > 1 else ''}"


class _Bench:
    """An engine that has played, and copies of its arrays to repeat its work on."""

    def __init__(self, guitar, rate):
        self._engine = Engine(guitar, float(rate))
        for key in chord_keys(G_MAJOR, guitar):
            self._engine.send(0, 0x90, key, VELOCITY)
        self._engine.process(int(FRAMES_BEFORE * rate) // at.CHUNK * at.CHUNK)
        instance = self._engine.instance
        self._kept = [array.copy() for array in (instance.d, instance.i, instance.v, instance.vi)]
        self._arrays = [instance.d, instance.i, instance.v, instance.vi]
        rows = [at.STRING_I + s * at.STRING_I_SIZE for s in range(len(guitar.strings))]
        self.tiles = np.array([self._kept[1][row + at.SI_TILES] - at.PSEUDO_TILES for row in rows])
        ends = np.array([self._kept[1][row + at.SI_END] - self._kept[1][row + at.SI_TILE] for row in rows])
        self.pseudo_tiles = ends - self.tiles
        self.extra = np.array([self._kept[1][row + at.SI_EXTRA] for row in rows])

    def _again(self):
        for array, kept in zip(self._arrays, self._kept, strict=True):
            array[:] = kept

    def _quickest(self, run, count, repetitions, fresh_every=1):
        """Least time [ns] of ``run`` for one of ``count`` items; each ``fresh_every`` times from the same state."""
        least = np.inf
        for turn in range(repetitions):
            if turn % fresh_every == 0:
                self._again()
            start = time.perf_counter_ns()
            run()
            least = min(least, time.perf_counter_ns() - start)
        self._again()
        return least / count

    def best(self, loop, extra):
        """A sample of one of the loops [ns]."""
        d, i, _, _ = self._arrays
        return self._quickest(lambda: loop(d, i, SAMPLES, extra), SAMPLES, REPETITIONS, 16)

    def convolution(self):
        """A sample of the convolver [ns]: the mean over all of its periods, which are not alike."""
        d, _, v, vi = self._arrays
        frames, now = 1 << 16, self._engine.frame
        return self._quickest(lambda: loops.convolve_frames(v, vi, d, now, frames), frames, 8)

    def message(self):
        """A message for the player [us]: the mean over the notes of a chord and their ends."""
        d, i, _, _ = self._arrays
        keys = [int(i[player_at.I_OPEN + s]) + 2 for s in range(len(self.tiles))]
        now = self._engine.frame

        def run():
            for key in keys:
                loops.play_message(d, i, now, 0x90, key, VELOCITY)
            for key in keys:
                loops.play_message(d, i, now + 1, 0x80, key, 0)

        return 1e-3 * self._quickest(run, 2 * len(keys), 100)

    def gesture(self, samples, kind, p0, p1):
        """The dearest string's gesture over its first ``samples`` samples [us], beside what every sample costs."""
        d, i, _, _ = self._arrays
        costs = [
            self._quickest(lambda s=s: loops.make_gesture(d, i, samples, kind, s, p0, float(p1)), 1, 100)
            for s in range(len(self.tiles))
        ]
        return 1e-3 * max(costs)

    def work(self):
        """Flops and bytes of all sweeps for each sample."""
        columns = 1 + self.extra
        flops = 8 * (self.tiles * (2 * (3 * columns + 4) + 2) + self.pseudo_tiles * (2 * (2 * columns + 1) + 1))
        moved = self.tiles * (2 * at.STATE_TILE + at.TILE * (3 + columns))
        moved += self.pseudo_tiles * (2 * at.STATE_TILE + at.TILE * (2 + columns))
        return float(flops.sum()), float(8 * moved.sum())

    def close(self):
        self._engine.close()


def _peaks():
    """Multiply-adds and first-level cache of this core at their best: flops and bytes per second."""
    d = _aligned(max(loops.STREAM, 16 + 8 * loops.CHAINS))
    d[:] = 0.5

    def best(run):
        run()
        times = []
        for _ in range(50):
            start = time.perf_counter_ns()
            run()
            times.append(time.perf_counter_ns() - start)
        return 1e-9 * min(times)

    flops = PASSES * loops.CHAINS * 16 / best(lambda: loops.multiply_add(d, PASSES))
    moved = PASSES * loops.STREAM * 16 / best(lambda: loops.stream(d, PASSES))
    return flops, moved


def _aligned(count):
    """Doubles whose first lies on a 64-byte boundary."""
    room = np.zeros(count + 8)
    start = (-room.ctypes.data // 8) % 8
    return room[start : start + count]
