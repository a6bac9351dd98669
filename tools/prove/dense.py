"""Proof 6: long dense playing. A duration enters; counters at the end and the memory over time leave.

A generated piece keeps all six strings busy: arpeggios, chords, bends, pedal, notes repeated fast, for ever.
"""

import json
import os
import pathlib
import random
import tempfile
import time

import numpy as np

from .guitar import playing
from .server import ProofError, jack_server

PIECE_SECONDS = 60
_TICKS, _TEMPO = 480, 500_000  # 960 ticks a second
_NOTES_A_SECOND = 16
_WARM_SECONDS = 60.0  # until every page has been touched and every cache filled
_OPEN = (40, 45, 50, 55, 59, 64)
_CHILDREN = ("audio_host", "midi_host", "resource_tracker")  # the last one is Python's own
_CALM = 0.1  # of the time that is left out of the fit at the start, where playing is short


def run(options, say):
    """Each way for the whole duration (list of dict)."""
    results = []
    for way in options.ways:
        results.append(_measure(way, options.block, options.seconds, options.every, say))
        say(_line(results[-1]))
    return results


def make_piece(path, seed=1):
    """Write the piece, `PIECE_SECONDS` long, to a MIDI file; returns how many notes it has."""
    import mido

    chance, events = random.Random(seed), []
    for k in range(PIECE_SECONDS * _NOTES_A_SECOND):
        at = k / _NOTES_A_SECOND
        note = chance.choice(_OPEN) + chance.randrange(10)
        length = chance.choice((0.05, 0.2, 0.8))
        events.append((at, mido.Message("note_on", note=note, velocity=chance.randrange(30, 120))))
        events.append((min(at + length, PIECE_SECONDS - 0.01), mido.Message("note_off", note=note)))
        if k % 8 == 0:
            events.append((at, mido.Message("pitchwheel", pitch=chance.randrange(-4096, 4096))))
        if k % 32 == 0:
            events.append((at, mido.Message("control_change", control=64, value=127 * (k // 32 % 2))))
        if k % 64 == 0:  # a chord on top
            events += [(at, mido.Message("note_on", note=one + 2, velocity=90)) for one in _OPEN]
            events += [(at + 0.5, mido.Message("note_off", note=one + 2)) for one in _OPEN]
    events.sort(key=lambda event: event[0])
    file = mido.MidiFile(ticks_per_beat=_TICKS)
    track = mido.MidiTrack([mido.MetaMessage("set_tempo", tempo=_TEMPO)])
    file.tracks.append(track)
    now = 0
    for at, message in events:
        tick = round(at * _TICKS * 1e6 / _TEMPO)
        track.append(message.copy(time=tick - now))
        now = tick
    file.save(path)
    return sum(message.type == "note_on" for _, message in events)


def _measure(way, block, seconds, every, say):
    with tempfile.TemporaryDirectory(prefix="ukrt-proof-") as name, jack_server(block) as environment:
        folder = pathlib.Path(name)
        notes = make_piece(folder / "dense.mid")
        report = folder / "report.json"
        options = ("--quiet", "--driver", way, "--loop", "--report", report)
        with playing(environment, "none", folder / "dense.mid", *options) as process:
            samples = _watch(process, seconds, every, say)
        told = json.loads(report.read_text())
    return {
        "way": way,
        "block": block,
        "seconds": seconds,
        "notes_in_piece": notes,
        "realtime_server": environment["UKRT_PROOF_REALTIME"] == "yes",
        "samples": samples,
        "memory": {name: _trend(samples, name, seconds) for name in samples[-1]["rss_kib"]},
        "report": told,
    }


def _watch(process, seconds, every, say):
    """Resident memory of the process and its children, now and then (list of dict)."""
    began, samples, next_word = time.monotonic(), [], 60.0
    while (now := time.monotonic() - began) < seconds:
        if process.poll() is not None:
            raise ProofError(f"ukrt play ended after {now:.0f} s with exit code {process.returncode}")
        samples.append({"seconds": now, "rss_kib": _memory_of(process.pid)})
        if now > next_word:
            next_word += 60.0
            say(f"  {now:.0f} s: {samples[-1]['rss_kib']}")
        time.sleep(every)
    return samples


def _memory_of(pid):
    """Resident memory [KiB] of a process and all its descendants, by what they run (dict)."""
    found = {"main": _resident(pid)}
    for child in _children(pid):
        command = pathlib.Path(f"/proc/{child}/cmdline").read_bytes().decode(errors="replace")
        known = [name for name in _CHILDREN if name in command]
        found[known[0] if known else str(child)] = _resident(child)
    return found


def _resident(pid):
    pages = int(pathlib.Path(f"/proc/{pid}/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") // 1024


def _children(pid):
    found = []
    for task in pathlib.Path(f"/proc/{pid}/task").iterdir():
        for child in (task / "children").read_text().split():
            found += [int(child), *_children(int(child))]
    return found


def _trend(samples, name, seconds):
    """First and last after warming up, least and most, and the slope of a straight line [KiB a minute]."""
    from_when = min(_WARM_SECONDS, _CALM * seconds)
    warm = [(one["seconds"], one["rss_kib"].get(name)) for one in samples if one["seconds"] >= from_when]
    warm = [(when, size) for when, size in warm if size]
    times, sizes = np.array(warm, float).T
    slope = np.polyfit(times, sizes, 1)[0] if len(times) > 1 else 0.0
    return {
        "first_kib": int(sizes[0]),
        "last_kib": int(sizes[-1]),
        "least_kib": int(sizes.min()),
        "most_kib": int(sizes.max()),
        "slope_kib_per_minute": float(60.0 * slope),
    }


def _line(result):
    told = result["report"]
    memory = ", ".join(
        f"{name} {one['first_kib']} to {one['last_kib']} KiB ({one['slope_kib_per_minute']:+.1f} KiB/min)"
        for name, one in result["memory"].items()
    )
    counters = told["counters"]
    return (
        f"{result['way']}, {result['seconds']:g} s at {result['block']} frames: blocks {counters['blocks']}, xruns "
        f"{told['xruns']}, frames never asked for {told['session']['missing_frames']}, late blocks "
        f"{counters['late_blocks']}, notes {counters['notes_on']}, dropped {counters['notes_dropped']}, messages lost "
        f"{counters['midi_dropped']}, not a number {counters['nonfinite_resets']}, shed {counters['shed_events']}; "
        f"load {told['load']}; memory: {memory}"
    )


def verdict(results):
    """Counters and trends of memory (list of dict)."""
    names = ("blocks", "late_blocks", "notes_on", "notes_dropped", "midi_dropped", "late_messages", "nonfinite_resets")
    return [
        {"way": one["way"], "seconds": one["seconds"], "xruns": one["report"]["xruns"], "memory": one["memory"]}
        | {"missing_frames": one["report"]["session"]["missing_frames"], "load": one["report"]["load"]}
        | {name: one["report"]["counters"][name] for name in names}
        for one in results
    ]
