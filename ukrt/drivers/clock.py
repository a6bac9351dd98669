"""Which frame is now: the engine's block-wise frame counter and the computer's clock enter, a smooth number leaves.

The engine's next frame jumps by a block at every callback. The jumps lie on a straight line in time apart from
lateness, so the earliest of them give the line: ``frame = now * rate + offset`` with the largest offset seen. An event
stamped with it is played one block after its arrival at most, and always the same time after, wherever in the block it
came.
"""

import time

_LEAK = 2e-4  # of the rate: lets the line sink, since two clocks may differ by 100 ppm and an overload loses frames
_JUMP_SECONDS = 0.1  # a counter that lags the line by more has stood still: start a new line


class FrameClock:
    """Estimate of the engine's frame at any moment.

    Parameters
    ----------
    engine : Engine
        Gives ``frame`` (the next frame to be computed) and ``sample_rate``.
    now : callable
        The computer's clock [s].
    """

    def __init__(self, engine, now=time.perf_counter):
        self._engine, self._now = engine, now
        self._rate = float(engine.sample_rate)
        self._seen = now()
        self._offset = engine.frame - self._seen * self._rate

    def frame(self):
        """The frame that is now (int), never less than the engine's next frame."""
        now, counted = self._now(), self._engine.frame
        line = self._offset - _LEAK * self._rate * (now - self._seen)
        here = counted - now * self._rate
        self._offset = here if here > line or line - here > _JUMP_SECONDS * self._rate else line
        self._seen = now
        return max(counted, int(now * self._rate + self._offset))
