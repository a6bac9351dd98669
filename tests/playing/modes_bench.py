"""Benches in other modes: how they are set up, what is sent to them, and what a string then does."""

import math

from player_bench import Bench

from ukrt.engine import layout
from ukrt.engine.kernels.transfer_player import transfer_player

OPEN = (64, 59, 55, 50, 45, 40)  # of strings 1 to 6
PRESET_RANGE = 4  # semitones outside zones, so that they can be told from masters
LOWER, UPPER = 1, 16  # masters, as musicians count channels


def guitar_bench(base=1, mode="guitar", preset="classical", **more):
    settings = {"playing.midi_mode": mode, "playing.base_channel": str(base)}
    return Bench(settings | {key.replace("__", "."): value for key, value in more.items()}, preset=preset)


def places(bench):
    """Channel -> (string number, fret, key) of what sounds."""
    count = len(bench.open)
    return {channel: (count - s, fret, key) for s, (key, channel, fret) in bench.held().items()}


def ways(bench):
    return [note["articulation"] for note in bench.log]


def mpe_bench(mode="mpe"):
    return Bench({"playing.midi_mode": mode, "playing.bend_range_semitones": str(PRESET_RANGE)})


def rpn(bench, channel, number, value, fine=None):
    """A registered parameter on a channel, counted from 1."""
    for controller, data in ((101, 0), (100, number), (6, value), (38, fine)):
        if data is not None:
            bench.cc(bench.frame + 10, controller, data, channel - 1)


def mcm(bench, master, members):
    rpn(bench, master, 6, members)


def swapped(bench, mode):
    """The same guitar in another mode goes on, with the gestures that are still to come."""
    other = mpe_bench(mode)
    bench.run(bench.frame)
    bench.i[layout.H_STRINGS] = other.i[layout.H_STRINGS] = len(bench.strings)
    transfer_player(bench.d, bench.i, other.d, other.i, bench.frame, 1.0)
    other.strings, other.frame = bench.strings, bench.frame
    return other


def cents(bench, s):
    """How far string ``s`` is from its own tension, in cents: pitch goes with the root of the tension."""
    return 600.0 * math.log2(bench.strings[s].tension)


def string_of(bench, channel, key):
    return next(s for s, (k, c, _) in bench.held().items() if (k, c) == (key, channel - 1))


def bend(bench, channel, share):
    """A pitch bend to a share of the range, and its effect awaited."""
    bench.bend(bench.frame + 5000, round(share * 8192), channel - 1)
    bench.run(bench.frame + 5000)
