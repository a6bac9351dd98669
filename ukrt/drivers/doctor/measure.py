"""What an output does to a callback: a source, an output and a stress enter, counts for one slice of time leave.

Flags and xruns tell only what a server noticed; callbacks that never happened are found by comparing the frames that
were asked for with the time that went by.
"""

import contextlib
import dataclasses
import os
import time

from ukrt.drivers.doctor.stress import run_stress
from ukrt.drivers.live.session import load_quantile
from ukrt.drivers.sound.scheduling import raise_thread
from ukrt.errors import DeviceError

SOURCES = ("compiled", "empty", "python")
_START_SECONDS = 5.0  # an output that has not asked for sound by then will not
_SETTLE_SECONDS = 0.2  # servers stumble when a client comes in; not what is measured
_QUANTILES = {"p50": 0.5, "p99": 0.99, "p99.9": 0.999, "max": 1.0}


@dataclasses.dataclass(frozen=True)
class Slice:
    """What was counted while one source played under one stress.

    ``frames`` and ``seconds`` belong together exactly; ``block`` is how many frames a callback had (0 if none came).
    """

    source: str
    stress: str
    asked_block: int
    seconds: float
    frames: int
    blocks: int
    block: float
    missing_frames: int
    flags: dict
    xruns: int
    loads: dict
    latency: float
    longest_gap_ms: float | None

    @property
    def missing(self):
        """Callbacks that never happened (int); a part of one is where the slice was cut."""
        return int(self.missing_frames / (self.block or self.asked_block or 1))

    @property
    def missing_percent(self):
        """Share of the callbacks that never happened [%]."""
        return 100.0 * self.missing / max(1, self.missing + self.blocks)

    def to_dict(self):
        """All of it as JSON can hold it."""
        plain = dataclasses.asdict(self)
        plain["loads"] = sorted(self.loads.items())
        return plain | {"missing": self.missing, "missing_percent": self.missing_percent}


def measure_slice(source, output, stress, seconds, block):
    """Play ``source`` on the freshly opened ``output`` for ``seconds`` [s] while this thread does ``stress``.

    Returns
    -------
    Slice

    Raises
    ------
    DeviceError
        If the output never asks for sound.
    """
    source.prepare(seconds + _SETTLE_SECONDS + 1.0)
    began, threads = source.frame, _threads()
    try:
        output.start()
        _wait_for(source, began)
        _raise(_threads() - threads)
        time.sleep(_SETTLE_SECONDS)
        xruns, (start, first), before = _xruns(output), _frame_now(source), source.counts()
        run_stress(stress, seconds)
        (end, last), after = _frame_now(source), source.counts()
        xruns = _xruns(output) - xruns
        gap, latency = source.longest_gap() if hasattr(source, "longest_gap") else None, float(output.latency)
    finally:
        output.close()
    elapsed = end - start
    blocks = after["blocks"] - before["blocks"]
    return Slice(
        source=source.name,
        stress=stress,
        asked_block=block,
        seconds=elapsed,
        frames=last - first,
        blocks=blocks,
        block=(after["frames"] - before["frames"]) / blocks if blocks else 0.0,
        missing_frames=max(0, int(elapsed * source.sample_rate) - (last - first)),
        flags={kind: after["flags"][kind] - before["flags"][kind] for kind in after["flags"]},
        xruns=xruns,
        loads=_difference(after["loads"], before["loads"]),
        latency=latency,
        longest_gap_ms=None if gap is None else 1e3 * gap,
    )


def measure_turns(sources, open_output, stress, block, seconds, turns, advance):
    """Measure the sources in turns, each ``turns`` slices of ``seconds`` [s], whoever begins changing with each turn.

    Parameters
    ----------
    sources : list of sources
    open_output : callable
        From a source and a block size [frames] to an output that has not been started.
    advance : callable
        Is told each `Slice` when it is done.

    Returns
    -------
    list of Slice
    """
    slices = []
    for turn in range(turns):
        for k in range(len(sources)):
            source = sources[(turn + k) % len(sources)]
            slices.append(measure_slice(source, open_output(source, block), stress, seconds, block))
            advance(slices[-1])
    return slices


def summarize(slices):
    """One cell, one source: sums, range over the slices, quantiles of load (dict)."""
    loads = {}
    for one in slices:
        for load, blocks in one.loads.items():
            loads[load] = loads.get(load, 0) + blocks
    histogram = sorted(loads.items())
    missing = [one.missing for one in slices]
    seen = [max(one.xruns, one.flags["underflows"]) for one in slices]
    gaps = [one.longest_gap_ms for one in slices if one.longest_gap_ms is not None]
    blocks = sum(one.blocks for one in slices)
    return {
        "seconds": sum(one.seconds for one in slices),
        "blocks": blocks,
        "block_frames": max(one.block for one in slices),
        "load": {name: load_quantile(histogram, share) for name, share in _QUANTILES.items()} if histogram else None,
        "xruns": sum(seen),
        "xruns_range": [min(seen), max(seen)],
        "missing": sum(missing),
        "missing_range": [min(missing), max(missing)],
        "missing_percent": 100.0 * sum(missing) / max(1, sum(missing) + blocks),
        "latency_s": slices[-1].latency,
        "longest_gap_ms": max(gaps) if gaps else None,
    }


def within_range(compiled, empty):
    """Whether the instrument did no worse than nothing: its mean slice lies within the range of the empty slices.

    Parameters
    ----------
    compiled, empty : list of Slice

    Returns
    -------
    dict of bool
        For ``xruns`` and ``missing``.
    """
    result = {}
    for name, count in (("xruns", lambda one: max(one.xruns, one.flags["underflows"])), ("missing", _missing)):
        mine, nothing = [count(one) for one in compiled], [count(one) for one in empty]
        result[name] = sum(mine) / len(mine) <= max(nothing)
    return result


def _missing(one):
    return one.missing


def _wait_for(source, began):
    ends = time.monotonic() + _START_SECONDS
    while source.frame == began:
        if time.monotonic() > ends:
            raise DeviceError(f"the output did not ask for sound within {_START_SECONDS:g} s")
        time.sleep(0.005)


def _threads():
    """Numbers of this process's threads (set of int); empty where the system does not tell."""
    try:
        return {int(name) for name in os.listdir("/proc/self/task")}
    except OSError:
        return set()


def _raise(threads):
    """Schedule an output's threads as live playing does, unless the sound system has done so with one of them."""
    for number in threads:
        with contextlib.suppress(OSError):
            if os.sched_getscheduler(number) & ~os.SCHED_RESET_ON_FORK != os.SCHED_OTHER:
                return
    for number in threads:
        raise_thread(number)


def _frame_now(source):
    """The time and the frame that belong together [s, frames]: the closest of some readings."""
    best = None
    for _ in range(20):
        before = time.perf_counter()
        frame = source.frame
        after = time.perf_counter()
        if best is None or after - before < best[0]:
            best = (after - before, (before, frame))
    return best[1]


def _xruns(output):
    """Xruns as the output's own server counts them; 0 where only flags tell."""
    return output.xruns() if hasattr(output, "xruns") else 0


def _difference(after, before):
    return {load: n - before.get(load, 0) for load, n in after.items() if n > before.get(load, 0)}
