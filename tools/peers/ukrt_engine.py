"""Used by ``bench_peers``: the first seconds of the piece by ukrt's engine alone, in blocks of 64 frames.

    python -m peers.ukrt_engine SECONDS OUT.wav

The compiled callback is what a sound card calls when ukrt plays live; strings and frets are chosen as the notes come.
Prints the CPU time of rendering and writing [s].
"""

import sys
import time

import numpy as np
import soundfile

from ukrt.engine.engine import Engine
from ukrt.model.presets import load_preset

from . import piece
from .peer import BLOCK, SAMPLE_RATE


def render(engine, notes, seconds):
    """The first seconds of the notes: ndarray (n, channels) [Pa]."""
    sound = np.empty((int(round(seconds * SAMPLE_RATE)), engine.channels))
    waiting = iter([*piece.events(notes), (np.inf, False, None)])
    at, is_on, note = next(waiting)
    for first in range(0, len(sound), BLOCK):
        while at * SAMPLE_RATE < first + BLOCK:
            engine.send(int(round(at * SAMPLE_RATE)), 0x90 if is_on else 0x80, note.key, note.velocity)
            at, is_on, note = next(waiting)
        engine.process_into(sound[first : first + BLOCK])
    return sound


if __name__ == "__main__":
    seconds, target = float(sys.argv[1]), sys.argv[2]
    engine = Engine(load_preset("classical"), SAMPLE_RATE)
    notes = piece.first_seconds(piece.make_piece(), seconds)
    before = time.process_time()
    soundfile.write(target, render(engine, notes, seconds), SAMPLE_RATE, subtype="FLOAT")
    print(time.process_time() - before)
    engine.close()
