"""Proof 4: many MIDI messages. A way in, a stress and a rate enter; what was lost, doubled, swapped or late leaves.

The guitar keeps a take: every message that acted, with its frame. It is compared with what the probe sent, message by
message.
"""

import collections
import json
import pathlib
import tempfile
import time

import numpy as np

from .guitar import disturb, playing, probing
from .probe import CLIENT, MIDI_PORT
from .server import RATE, ProofError, jack_server

_WINDOW = RATE // 10  # frames: within which frames lost by the server do not count as a message's delay
BURST, BURSTS, BURST_PAUSE = 2000, 15, 1.5


def run(options, say):
    """Each way under each stress: a steady stream, then bursts (list of dict)."""
    results = []
    for way in options.ways:
        for stress in options.stresses:
            steady = {"rate": options.rate, "seconds": options.seconds}
            bursts = {"size": BURST, "count": BURSTS, "pause": BURST_PAUSE}
            for schedule, arguments in (("steady", steady), ("bursts", bursts)):
                result = _measure(way, options.block, stress, schedule, arguments)
                results.append(result)
                say(_line(result))
    return results


def _measure(way, block, stress, schedule, arguments):
    from ukrt.drivers.takes.reader import read_take

    with tempfile.TemporaryDirectory(prefix="ukrt-proof-") as name, jack_server(block) as environment:
        take, report = pathlib.Path(name) / "take.mid", pathlib.Path(name) / "report.json"
        files = ("--record", take, "--report", report)
        with probing(environment) as ask:
            with playing(environment, stress, "--quiet", "--driver", way, "--midi-in", CLIENT, *files) as process:
                if not ask("wait", port=MIDI_PORT)["connected"]:
                    raise ProofError(f"the guitar ({way}) has not connected its MIDI input to the probe")
                disturb(process)
                time.sleep(1.0)
                sent = ask("play", schedule=schedule, arguments=arguments)
                time.sleep(1.0)
        played, told = read_take(take), json.loads(report.read_text())
    return {
        "way": way,
        "block": block,
        "stress": stress,
        "schedule": schedule,
        **arguments,
        "realtime_server": environment["UKRT_PROOF_REALTIME"] == "yes",
        "refused_by_jack": sent["refused"],
        "lost_by_the_recorder": int(played.lost),
        **compare(sent["words"], sent["sent"], played.event_words, played.event_frames),
        "witness": _witnessed(sent),
        "report": told,
    }


def _witnessed(sent):
    """What a listener that does nothing else lost and doubled of the same messages on the same server (dict)."""
    words = np.array(sent["witness"], np.int64)
    told = compare(sent["words"], sent["sent"], words, np.arange(len(words)))
    return {name: told[name] for name in ("lost", "doubled", "swapped")}


def compare(words, sent_frames, played_words, played_frames):
    """What became of each message.

    Parameters
    ----------
    words, sent_frames : list of int
        As sent, in order: status << 16 | data1 << 8 | data2, and the server's frame.
    played_words, played_frames : ndarray of int64
        As acted, in order, and the guitar's frame; the guitar's own events have words above 24 bits.

    Returns
    -------
    dict
        ``sent``, ``lost``, ``doubled``, ``swapped`` (neighbours in the wrong order), ``foreign``; ``jitter_frames``:
        quantiles of the delay above the least one near it.
    """
    keep = played_words < 1 << 24
    played_words, played_frames = played_words[keep], played_frames[keep]
    places = collections.defaultdict(collections.deque)  # equal messages (notes) are told apart by their order
    for place, word in enumerate(words):
        places[word].append(place)
    order, frames, foreign, doubled = [], [], 0, 0
    for word, frame in zip(played_words.tolist(), played_frames.tolist(), strict=True):
        if places.get(word):
            order.append(places[word].popleft())
            frames.append(frame)
        elif word in places:
            doubled += 1
        else:
            foreign += 1
    # Of equal messages (notes) nobody can tell which one is missing: order and time are told by the numbered ones.
    often = collections.Counter(words)
    sure = [k for k, place in enumerate(order) if often[words[place]] == 1]
    order_of_sure = np.array(order, int)[sure]
    result = {
        "sent": len(words),
        "played": len(order),
        "lost": len(words) - len(order),
        "doubled": doubled,
        "swapped": int((np.diff(order_of_sure) < 0).sum()),
        "foreign": foreign,
    }
    if sure:
        result["jitter_frames"] = _jitter(np.array(frames)[sure], np.array(sent_frames)[order_of_sure])
    return result


def _jitter(played, sent):
    """Quantiles of the delay above the least one of the same tenth of a second [frames]."""
    delay, window = played - sent, (sent - sent.min()) // _WINDOW
    least = np.full(window.max() + 1, np.iinfo(np.int64).max)
    np.minimum.at(least, window, delay)
    values = delay - least[window]
    quantiles = np.quantile(values, (0.5, 0.99, 0.999, 1.0), method="nearest").tolist()
    return dict(zip(("median", "p99", "p99.9", "max"), map(int, quantiles), strict=True))


def _line(result):
    counts = ", ".join(f"{name} {result[name]}" for name in ("sent", "lost", "doubled", "swapped", "foreign"))
    late = result["report"]["counters"]["late_messages"]
    return (
        f"{result['way']}, {result['stress']}, {result['schedule']}: {counts}, late {late}; beside it a listener that "
        f"does nothing else: {result['witness']}; jitter in frames {result.get('jitter_frames')}"
    )


def verdict(results):
    """The numbers that matter (list of dict)."""
    names = ("way", "stress", "schedule", "sent", "lost", "doubled", "swapped", "foreign", "witness", "jitter_frames")
    return [
        {name: one.get(name) for name in names} | {"late": one["report"]["counters"]["late_messages"]}
        for one in results
    ]
