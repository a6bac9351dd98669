"""A live session: an engine, an output and messages enter; it runs until closed, and says when the output has died.

Start and end are in the one order that is safe: the output counts frames before messages are stamped with them, and
nobody sends any more when the output goes.
"""

import time

from ..errors import DeviceError

_STALL_SECONDS = 5.0  # an output that asks for no block in this time is dead: suspend and dead servers say nothing
_QUIET_RATIO = 1e-6  # energy after a piece relative to its largest: -60 dB


class LiveSession:
    """Context manager that runs an output and a feeder on an engine."""

    def __init__(self, engine, output, feeder):
        self.engine, self.output, self.feeder = engine, output, feeder
        self.seconds = 0.0
        self.closed_cleanly = True
        self._largest_energy = 0.0
        self._seen_frame, self._seen_at = -1, time.monotonic()

    def __enter__(self):
        self._started = time.monotonic()
        self.output.start()
        self.feeder.start()
        return self

    def __exit__(self, *_):
        self.seconds = time.monotonic() - self._started
        self.feeder.close()
        self.closed_cleanly = self.output.close()

    def check(self):
        """Raise `DeviceError` if the output has stopped asking for sound or a MIDI port has failed."""
        frame, now = self.engine.frame, time.monotonic()
        if frame != self._seen_frame:
            self._seen_frame, self._seen_at = frame, now
        if now - self._seen_at > _STALL_SECONDS or not self.output.running:
            raise DeviceError(f"{self.output.name} has stopped asking for sound")
        if self.feeder.failure is not None:
            raise DeviceError(f"reading MIDI has failed: {self.feeder.failure}")

    def xruns(self):
        """Blocks that came too late: what PortAudio flagged, or what the null output saw."""
        return self.engine.counters()["underflows"] + getattr(self.output, "late_blocks", 0)

    def sounding(self):
        """Whether the guitar still has more than a millionth of the largest energy that this function has seen."""
        energy = self.engine.energy()
        self._largest_energy = max(self._largest_energy, energy)
        return energy > _QUIET_RATIO * self._largest_energy


def load_quantile(histogram, share):
    """The load below which ``share`` of the blocks stayed [1, of the block's period]; None without blocks.

    Parameters
    ----------
    histogram : list of (load, blocks)
        By increasing load, as in ``Engine.counters()["load_histogram"]``.
    share : float [1]
    """
    need, seen = share * sum(blocks for _, blocks in histogram), 0
    for load, blocks in histogram:
        seen += blocks
        if seen >= need:
            return load
    return None
