"""What became of a session: a live session that has ended enters; a dict for JSON and a few lines of words leave."""

import os
import platform

from .. import __version__
from ..model.string_limits import describe_tuning
from .common import clock_time, describe_notes

_SHARES = {"p50": 0.5, "p99": 0.99, "p99_9": 0.999, "max": 1.0}
_FLAGS = ("underflows", "overflows", "input_underflows", "input_overflows", "priming")


def make_report(session, state, output_counts, recorder, shelf, ended, news, args):
    """Everything that is known, ready for JSON.

    Parameters
    ----------
    session : LiveSession
        Ended, its engine not closed yet.
    state : dict
        ``session.state()`` as it was last.
    output_counts : dict
        What the output has counted by itself, such as JACK's events.
    recorder : Recorder
    shelf : PresetShelf
    ended : str
        Why it ended.
    news : list of (seconds, sentence)
    args : argparse.Namespace
        The options as given.
    """
    engine = session.engine
    counters = engine.counters()
    histogram = counters.pop("load_histogram")
    return {
        "ukrt": __version__,
        "versions": _versions(),
        "options": {name: value for name, value in vars(args).items() if name not in ("run", "command", "list")},
        "ended": ended,
        "seconds": session.seconds,
        "output": state["output"],
        "sample_rate": state["sample_rate"],
        "block_size": state["block_size"],
        "load": {name: load_quantile(histogram, share) for name, share in _SHARES.items()},
        "flags": {name: counters[name] for name in _FLAGS},
        "xruns": session.xruns(),
        "reconnections": session.reconnections,
        "session": {**state, "seconds": session.seconds},
        "counters": counters,
        "load_histogram": [[load, blocks] for load, blocks in histogram],
        "midi": [source.counts() for source in session.midi_sources],
        "output_counts": output_counts,
        "guitar": engine.guitar.name,
        "tuning": describe_tuning(engine.guitar),
        "presets": shelf.names,
        "settings": engine.settings(),
        "recorded": recorder.counts(),
        "news": [{"seconds": round(seconds, 3), "text": text} for seconds, text in news],
    }


def _versions():
    from ..drivers.takes.take import environment

    return {"python": platform.python_version(), "system": platform.platform(), "cores": os.cpu_count()} | environment()


def load_quantile(histogram, share):
    """See `ukrt.drivers.live.watch.load_quantile`."""
    from ukrt.drivers.live import watch as live_watch

    return live_watch.load_quantile(histogram, share)


def summary(report):
    """What was played and how well, in words, from the report."""
    counters, load = report["counters"], report["load"]
    missing = report["session"]["missing_frames"]
    blocks = f"{counters['blocks']} in {clock_time(report['seconds'])}, xruns {report['xruns']}"
    blocks += f", late {counters['late_blocks']}" + (f", {missing} frames never asked for" if missing else "")
    if load["p50"] is not None:
        numbers = ", ".join(f"{name} {100 * load[key]:.1f} %" for name, key in _LOAD_WORDS)
        blocks += f"; load {numbers}"
    lines = [
        f"blocks   {blocks}",
        f"notes    {describe_notes(counters)}",
        f"messages {counters['midi_received']}, too late {counters['late_messages']}, lost {counters['midi_dropped']}",
    ]
    if report["reconnections"]:
        lines.append(f"output   came back {report['reconnections']} times")
    if counters["limited_samples"]:
        words = f"by {-counters['limiter_db']:.1f} dB at most; lower the gain with --set radiation.gain_db=..."
        lines.append(f"limited  {counters['limited_samples']} frames {words}")
    if counters["clipped_samples"]:
        lines.append(f"clipped  {counters['clipped_samples']} samples; lower the gain with --set radiation.gain_db=...")
    if counters["shed_events"]:
        lines.append(f"shed     {counters['shed_events']} times, where the computer was too slow")
    if counters["nonfinite_resets"]:
        lines.append(f"restarts {counters['nonfinite_resets']} times, after something that was not a number")
    lines += [f"recorded {path}" for path in report["recorded"]["files"]]
    return "\n".join(lines)


_LOAD_WORDS = (("median", "p50"), ("99 %", "p99"), ("worst", "max"))
