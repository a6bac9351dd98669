"""A take with an entry of every kind, for the tests of the format."""

import dataclasses

from ukrt.drivers.takes.growing import GrowingTake
from ukrt.drivers.takes.take import Sound
from ukrt.engine.stage_layout import KIND_RESET, KIND_SHED, KIND_SHIFT, KIND_SWAP
from ukrt.model.presets import load_preset

PAPER = load_preset("paper")
SETTINGS = {"limiter": True, "output_gain": 0.1}
SOUND = Sound(PAPER, 48000.0, {"name": "hall.wav", "file": "/tmp/hall.wav", "sha256": "0" * 64}, 0.1)
OTHER = dataclasses.replace(SOUND, guitar=dataclasses.replace(PAPER, name="Größe"), sample_rate=44100.0, gain=3.5)
NOTE = 0x90 << 16 | 60 << 8 | 100
SHED, RESET, SWAP = (kind << KIND_SHIFT for kind in (KIND_SHED, KIND_RESET, KIND_SWAP))
ENTRIES = [(0, NOTE), (10, SHED | 2), (10, NOTE), (11, SWAP | 1), (11, 0xC0 << 16 | 5 << 8), (500, RESET | 64),
           (500, 0xFF << 16), (501, 0x90 << 16 | 200 << 8 | 1), (600, 0xF07F7F), (600, 0xF40401), (600, 0xF40102),
           (700, 0xF70000), (701, 0xF50000), (9000, 0xE0 << 16 | 127 << 8)]  # fmt: skip


def sounds(number):
    return OTHER if number == 1 else dataclasses.replace(OTHER, sample_rate=44100.0 + number)


def start_take(path, sample_rate=48000.0):
    """A take that grows, without entries."""
    return GrowingTake(path, dataclasses.replace(SOUND, sample_rate=sample_rate), "pressure", 2, SETTINGS)


def write_take(path):
    """A take with all entries; returns its path."""
    file = start_take(path)
    file.append(ENTRIES, 10_000, sounds)
    file.close()
    return path


def entries_of(take):
    """The journal of a `Take` as (frame, word)."""
    return list(zip(take.event_frames.tolist(), take.event_words.tolist(), strict=True))
