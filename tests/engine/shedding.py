"""An engine played with shedding levels that change at given frames, as when a take is played again."""

import numpy as np

from ukrt.engine import layout as at
from ukrt.engine import stage_layout as stage_at
from ukrt.engine.convolver import convolver_prepare, convolver_size
from ukrt.engine.discretize import aligned
from ukrt.engine.engine import Engine
from ukrt.engine.kernels.shed import EVERY
from ukrt.model.presets import load_preset


def play(messages, frames, levels=None, *, block=EVERY, signal="pressure", guitar=None):
    """Play ``messages``; ``levels`` is {frame: level}.

    Returns
    -------
    samples : ndarray (frames, channels)
    engine : Engine
    asleep : list of (frame, number of strings asleep), where blocks end
    """
    engine = Engine(guitar or load_preset("classical"), 48000.0, signal=signal)
    for message in messages:
        assert engine.send(*message)
    for frame, level in sorted((levels or {}).items()):
        assert engine.send_event(frame, stage_at.KIND_SHED, level, lane=stage_at.LANE_MIDI)
    pieces, asleep = [], []
    for start in range(0, frames, block):
        pieces.append(engine.process(min(block, frames - start)))
        asleep.append((engine.frame, sleepers(engine._i).count(at.ASLEEP)))
    return np.concatenate(pieces), engine, asleep


def convolver(response):
    """A convolver's arrays (v, vi) for ``response``, at rest."""
    n_v, n_vi = convolver_size(len(response))
    v, vi = aligned(n_v, np.float64), aligned(n_vi, np.int64)
    convolver_prepare(response, v, vi)
    return v, vi


def sleepers(i):
    """SI_SLEEP of each string."""
    return [int(i[at.STRING_I + s * at.STRING_I_SIZE + at.SI_SLEEP]) for s in range(i[at.H_STRINGS])]


def dense(frames, seed=3):
    """Messages of dense playing: chords, repeated notes, note-offs, pedal and bends, at seeded odd frames."""
    rng = np.random.default_rng(seed)
    events, frame = [], 0
    while frame < frames - 4000:
        frame += int(rng.integers(0, 900))
        note = int(rng.integers(40, 80))
        events.append((frame, 0x90, note, int(rng.integers(20, 127))))
        events.append((frame + int(rng.integers(300, 6000)), 0x80, note, 0))
        if rng.random() < 0.3:
            events.append((frame + 50, 0xE0, int(rng.integers(0, 128)), int(rng.integers(0, 128))))
        if rng.random() < 0.2:
            events.append((frame, 0xB0, 64, int(rng.integers(0, 128))))
    return sorted(events)


def random_levels(frames, seed, count=12):
    """Levels that jump about, at odd frames."""
    rng = np.random.default_rng(seed)
    return {int(f): int(rng.integers(0, 4)) for f in rng.integers(1, frames, count)}
