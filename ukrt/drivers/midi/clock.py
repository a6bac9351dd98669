"""Which frame acts on what arrives now: a stage's block stamps and the computer's clock enter, a smooth frame leaves.

Blocks begin late by anything from microseconds to milliseconds, in pairs where a server batches them, but never early.
Apart from that lateness, frames over time are a straight line, so the earliest blocks give the line: the upper
envelope. A message that acts one block after the frame of its arrival is always written before its block is computed,
and always the same time after, wherever in a block it came.
"""

import time

_LEAK = 100e-6  # of the rate: the line sinks by what two quartzes may differ, and the earliest blocks lift it again
_WINDOW_NS, _WINDOW_POINTS = 500_000_000, 16  # a line no point came up to for so long has lost frames (xrun, new block)
_BLOCKS_WINDOW_NS = 100_000_000  # blocks come often: until then what arrives acts late by the blocks that were lost
_SLACK_NS = 200_000  # ... if it is too high by more than this (measured: blocks that begin on time do so to 0.1 ms)
_SLACK_BLOCKS = 1 / 8  # ... and by this: where all blocks jitter by half a period, one of 16 is nearer but for 1 %
_JUMP_NS, _JUMP_BLOCKS = 50_000_000, 2  # what is later than both has stood still (suspend, another output): a new line
_NS = 1e-9


class EarliestLine:
    """The upper envelope of points (time, frame) that come late, never early.

    Parameters
    ----------
    window_ns : int
        For so long, and 16 points at least, no point may stay away from the line.

    Attributes
    ----------
    restarts : int
        How often the line was begun anew or brought down.
    """

    def __init__(self, window_ns=_WINDOW_NS):
        self.restarts, self._long_ns = 0, window_ns
        self._rate, self._ns, self._frame = 0.0, 0, 0.0
        self._window_ns, self._points, self._least = 0, 0, 0.0

    def see(self, ns, frame, rate, slack, jump):
        """Take in that ``frame`` was reached at the time ``ns`` or earlier.

        Parameters
        ----------
        ns : int
            Never decreasing.
        frame, rate : float
            The rate [Hz]; another one than before starts a new line.
        slack : float [frames]
            The line is brought down where it was too high by more for a window.
        jump : float [frames]
            The line starts anew where it is too high by more.
        """
        line = self.at(ns) - (ns - self._ns) * _LEAK * self._rate * _NS
        below = line - frame
        if rate != self._rate or below > jump:
            self.restarts += self._rate != 0.0
            self._rate, line, below = rate, frame, 0.0
            self._begin_window(ns)
        self._points += 1
        self._least = min(self._least, max(below, 0.0))
        if ns - self._window_ns > self._long_ns and self._points >= _WINDOW_POINTS:
            if self._least > slack:
                line -= self._least
                self.restarts += 1
            self._begin_window(ns)
        self._ns, self._frame = ns, max(line, frame)

    def _begin_window(self, ns):
        self._window_ns, self._points, self._least = ns, 0, float("inf")

    def at(self, ns):
        """The frame at the time ``ns`` (float)."""
        return self._frame + (ns - self._ns) * self._rate * _NS


class FrameClock:
    """Estimate of the frame at any moment, and of the frame at which what arrives then shall act.

    Parameters
    ----------
    source : object
        Gives ``frame`` (the next one to be computed), ``sample_rate`` [Hz] and, where there is one, ``stamp() ->
        (frame, ns, frames)``: the beginning of the last block and its length. Where nothing is stamped (ns = 0) the
        counter is watched, which is as good as `look` is called often.
    delay_frames : float, optional
        From the frame of arrival to the frame at which it acts; if left out one block and ``margin``.
    margin : float [s]
        How long a message takes from its arrival until it is in the queue.
    now : callable
        The clock of the stamps [ns].
    """

    def __init__(self, source, delay_frames=None, margin=0.0, now=time.monotonic_ns):
        self._source, self._delay, self._margin, self._now = source, delay_frames, margin, now
        self._stamp = getattr(source, "stamp", None)
        self._line, self._seen, self._counted, self._block = EarliestLine(_BLOCKS_WINDOW_NS), (0, 0), None, 0
        self.look()

    @property
    def restarts(self):
        """How often frames were lost or the output changed, so that the line was begun anew (int)."""
        return self._line.restarts

    def look(self):
        """Take in the newest stamp; call it often, best more often than there are blocks."""
        frame, ns, block = self._stamp() if self._stamp else (0, 0, 0)
        if ns:
            if (frame, ns) != self._seen:
                self._seen, self._block = (frame, ns), block
                self._see(ns, frame)
            return
        counted, now = self._source.frame, self._now()
        if counted != self._counted:  # the next frame to be computed: what is just playing began a block before
            self._block = 0 if self._counted is None else max(counted - self._counted, 0)
            self._counted = counted
            self._see(now, counted - self._block)

    def _see(self, ns, frame):
        rate = self._source.sample_rate
        slack = max(_SLACK_NS * _NS * rate, _SLACK_BLOCKS * self._block)
        self._line.see(ns, frame + self._lead(), rate, slack, self._jump())

    def _jump(self):
        return max(_JUMP_NS * _NS * self._source.sample_rate, _JUMP_BLOCKS * self._block)

    def _lead(self):
        if self._delay is not None:
            return self._delay
        return self._block + self._margin * self._source.sample_rate

    def acts_at(self, ns):
        """The frame at which a message acts that arrived at the time ``ns`` (int).

        While the output stands still time does not run on for long.
        """
        return int(min(self._line.at(ns), self._source.frame + self._lead() + self._block + self._jump()))

    def frame(self):
        """The frame that is now (int), never less than the source's next frame."""
        self.look()
        return max(self._source.frame, self.acts_at(self._now()))
