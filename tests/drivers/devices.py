"""Outputs whose fate is in the test's hands."""

import time

from ukrt.drivers.sound.null import NullOutput


def wait_until(condition, seconds=20.0, meanwhile=lambda: None):
    """Wait for ``condition()``, calling ``meanwhile()`` as often as a main loop would."""
    ends = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < ends, "waited too long"
        meanwhile()
        time.sleep(0.02)


class Device:
    """A clocked output that can die, or stop asking without a word."""

    def __init__(self, engine, name="the device", sample_rate=48000.0, diary=None):
        self._clock = NullOutput(engine, 128, silent=True)
        self.name, self.sample_rate, self.block_size, self.latency = name, sample_rate, 128, 0.0027
        self.running = False
        self.refreshed, self.gaps = 0, 0
        self._diary = [] if diary is None else diary
        self._alive = False

    def start(self):
        self._diary.append(f"{self.name} starts")
        self._clock.start()
        self.running = self._alive = True

    def stall(self):
        """Ask for nothing any more, and say nothing."""
        if self._alive:
            self._clock.close()
        self._alive = False

    def die(self):
        self.stall()
        self.running = False

    def refresh(self):
        self.refreshed += 1

    def xruns(self):
        return self.gaps

    def close(self):
        self._diary.append(f"{self.name} closes")
        self.die()
        return True
