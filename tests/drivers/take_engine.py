"""An engine without physics for the recorder's tests: its samples are known numbers, its journal is written by hand."""

import numpy as np

from ukrt.engine import layout as at
from ukrt.engine.stage_layout import KIND_SHIFT, KIND_SWAP
from ukrt.model.presets import load_preset

PAPER = load_preset("paper")


class FakeInstance:
    """What a recorder asks of an instance."""

    signal, guitar = "strings", PAPER

    def __init__(self, sample_rate=48000.0, gain=1.0):
        self.sample_rate = sample_rate
        self.d = np.zeros(at.METER + 8)
        self.d[at.METER + at.M_GAIN] = gain


class FakeEngine:
    """Sample of frame n: (n, -n) / 1000, kept for RING frames."""

    RING = 5000
    signal, channels = "strings", 2

    def __init__(self):
        self.frame, self.entries, self._overwritten, self.instance = 0, [], 0, FakeInstance()

    @property
    def sample_rate(self):
        return self.instance.sample_rate

    def settings(self):
        return {"limiter": True, "output_gain": 1.0}

    def run(self, frames):
        self.frame += frames

    def note(self, word):
        """``word`` acts at the next frame to be computed."""
        self.entries.append((self.frame, word))

    def swap(self, instance):
        self.instance = instance
        number = 1 + sum(word >> KIND_SHIFT == KIND_SWAP for _, word in self.entries)
        self.note(KIND_SWAP << KIND_SHIFT | number)

    def lose_entries(self, count):
        """The next look at the journal comes too late for ``count`` entries."""
        self._overwritten = count

    def samples(self, first, last):
        frames = np.arange(first, last)
        return np.stack([frames / 1000, -frames / 1000], axis=1).astype(np.float32)

    def journal(self, since):
        lost, self._overwritten = self._overwritten, 0
        entries = np.array(self.entries[since + lost :], dtype=np.int64).reshape(-1, 2)
        return len(self.entries), entries, lost

    def recorded(self, since):
        first = max(since, self.frame - self.RING)
        return self.frame, self.samples(first, self.frame), first - since
