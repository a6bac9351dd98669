"""Proof 2: from a MIDI event to the first sample that it changes. A way in and a period enter, a distribution leaves.

Three clients of one server: the probe sends, the guitar plays, jack_capture records the guitar beside the probe's
marker. The guitar is one whose notes die at once, so that silence precedes each note and its first sample stands out.
"""

import collections
import pathlib
import shutil
import signal
import subprocess
import tempfile
import time

import numpy as np

from .guitar import disturb, make_dead_preset, playing, probing
from .probe import CLIENT, MARKER_PORT, MIDI_PORT
from .server import RATE, ProofError, jack_server

WAYS = ("jack", "portaudio")
_GAP, _SPREAD = 9600, 4800  # frames between notes: the last one has died, and no two fall on the same place of a block
_BEFORE = 400  # frames that must be quiet before a note
_QUIET = 4e-7  # what second differences may be left there; those of a note's first sample are 4e-6
_FIRST = 3.0  # times what is left, which only dies away: the note has begun
_SEARCH = RATE // 10


def run(options, say):
    """Each way in at each period (list of dict)."""
    results = []
    for way in options.ways:
        for block in options.blocks:
            results.append(_measure(way, block, options.stress, options.events))
            say(_line(results[-1]))
    return results


def _measure(way, block, stress, events):
    with tempfile.TemporaryDirectory(prefix="ukrt-proof-") as name, jack_server(block) as environment:
        folder = pathlib.Path(name)
        preset = make_dead_preset(folder)
        common = ("--quiet", "--driver", way, "--midi-in", CLIENT, "--preset", preset)
        with probing(environment) as ask, playing(environment, stress, *common) as process:
            if not ask("wait", port=MIDI_PORT)["connected"]:
                raise ProofError(f"the guitar ({way}) has not connected its MIDI input to the probe")
            outputs = ask("outputs")["outputs"]
            if not outputs:
                raise ProofError(f"the guitar ({way}) offers no audio outputs")
            disturb(process)
            time.sleep(1.0)  # a note that comes at the very start may find clocks not yet settled
            with _recording(environment, folder / "heard.wav", outputs[0]):
                if not ask("wait", port=MARKER_PORT)["connected"]:
                    raise ProofError("jack_capture has not connected to the probe's marker")
                time.sleep(0.5)
                schedule = {"count": events, "gap": _GAP, "spread": _SPREAD}
                sent = ask("play", schedule="single_notes", arguments=schedule)
                time.sleep(0.5)
        found = _find_notes(folder / "heard.wav", sent["offsets"][::2])
        return {
            "way": way,
            "block": block,
            "stress": stress,
            "sent": len(sent["sent"]) // 2,
            "realtime_server": environment["UKRT_PROOF_REALTIME"] == "yes",
            "measured": len(found["delays"]),
            **{name: found[name] for name in ("markers", "not_quiet_before", "not_heard")},
            "event": _distribution(found["delays"]) if found["delays"] else None,
            "cycle": _distribution(found["from_cycle"]) if found["from_cycle"] else None,
            "in_order": found["delays"],
        }


class _recording:
    """jack_capture on one output and the marker, until the context is left."""

    def __init__(self, environment, path, output):
        if shutil.which("jack_capture") is None:
            raise ProofError("jack_capture is missing (Debian: apt-get install jack-capture)")
        ports = ["--port", output, "--port", f"{CLIENT}:{MARKER_PORT}"]
        self._command = ["jack_capture", "--daemon", "-c", "2", "-b", "FLOAT", "-f", "wav", *ports, str(path)]
        self._environment = environment

    def __enter__(self):
        silent = {"stdin": subprocess.DEVNULL, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        self._process = subprocess.Popen(self._command, env=self._environment, **silent)

    def __exit__(self, *_):
        self._process.send_signal(signal.SIGINT)
        self._process.wait(20)


def _find_notes(path, offsets):
    """What the recording tells of each note.

    Parameters
    ----------
    offsets : list of int [frames]
        Place of each note in the cycle that sent it.

    Returns
    -------
    dict
        ``delays``: frames from each marker to the first changed sample; ``from_cycle``: the same from the start of the
        cycle; how many ``markers``, ``not_quiet_before``, ``not_heard``.
    """
    import soundfile

    sound, _ = soundfile.read(path, dtype="float32", always_2d=True)
    # What is left of the last note swings slowly; its second differences are far below a beginning note's.
    heard = np.abs(np.diff(sound[:, 0].astype(float), 2, prepend=[0.0, 0.0]))
    markers = np.flatnonzero(sound[:, 1] > 0.5)
    found = {"delays": [], "from_cycle": [], "markers": len(markers), "not_quiet_before": 0, "not_heard": 0}
    complete = len(markers) == len(offsets)
    for k, at in enumerate(markers):
        residue = heard[max(0, at - _BEFORE) : at].max(initial=0.0)
        late = np.flatnonzero(heard[at : at + _SEARCH] > max(_FIRST * residue, 1e-3 * _QUIET))
        if residue > _QUIET:
            found["not_quiet_before"] += 1
        elif not len(late):
            found["not_heard"] += 1
        else:
            found["delays"].append(int(late[0]))
            if complete:
                found["from_cycle"].append(int(late[0]) + offsets[k])
    return found


def _distribution(delays):
    """Quantiles, spread and counts of delays [frames] (dict)."""
    values = np.array(delays)
    quantiles = np.quantile(values, (0.0, 0.01, 0.5, 0.99, 1.0), method="nearest").tolist()
    names = ("min", "p1", "median", "p99", "max")
    return {
        "frames": dict(zip(names, quantiles, strict=True)),
        "ms": {name: 1e3 * value / RATE for name, value in zip(names, quantiles, strict=True)},
        "sd_us": float(1e6 * values.std() / RATE),
        "spread_frames": int(values.max() - values.min()),
        "counts": sorted(collections.Counter(delays).items()),
    }


def _words(distribution):
    frames = ", ".join(f"{name} {value}" for name, value in distribution["frames"].items())
    return f"{frames}; sd {distribution['sd_us']:.1f} us, spread {distribution['spread_frames']} frames"


def _line(result):
    lines = [
        f"{result['way']}, {result['block']} frames, {result['stress']}: {result['measured']} of {result['sent']} "
        f"notes, not quiet before {result['not_quiet_before']}, not heard {result['not_heard']}"
    ]
    for name, words in (("event", "from the event"), ("cycle", "from the start of its cycle")):
        if result[name]:
            lines.append(f"  frames {words} to the first changed sample: {_words(result[name])}")
    return "\n".join(lines)
