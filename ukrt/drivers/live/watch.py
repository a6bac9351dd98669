"""What the frame counter tells about an output: frames and times enter; standstill and what was missed leave.

Neither PortAudio nor an operating system that wakes up says that nobody asks for sound any more, and flags for missed
blocks undercount. The counter of the frames that were asked for says both.
"""

_STALL_SECONDS, _STALL_BLOCKS = 1.0, 8  # standing still for longer than both is death or sleep (choice)
_LOOK_SECONDS = 0.25  # the most that counts between two looks, which come twenty times a second
_WINDOW_SECONDS = 1.0  # the earliest of this many seconds' blocks tells where the output is, free of lateness


class StallWatch:
    """Tells whether the counter stands still.

    Attributes
    ----------
    still : float [s]
        For how long it has been watched standing still. Time in which nobody looked counts little: who was stopped
        (Ctrl-Z, a computer asleep) finds everything standing still when he goes on.
    """

    def __init__(self):
        self.restart(0.0)

    def restart(self, now):
        """Forget everything: another output begins to count at ``now`` [s]."""
        self._frame, self._looked, self.still = None, now, 0.0

    def look(self, frame, now, block_seconds):
        """Whether nobody has asked for sound for longer than is possible with blocks of ``block_seconds``."""
        passed = min(now - self._looked, _LOOK_SECONDS)
        self.still = self.still + passed if frame == self._frame else 0.0
        self._frame, self._looked = frame, now
        return self.still > max(_STALL_SECONDS, _STALL_BLOCKS * block_seconds)


class MissingFrames:
    """Counts the frames that an output should have asked for and never did.

    The beginnings of blocks lie on a straight line in time, apart from lateness. In each window of a second the
    earliest beginning counts; where it lies below the line by more than half a block, that much was left out. What lies
    nearer is the difference of two clocks, and moves the line. What is made up for later is no longer missing.

    Attributes
    ----------
    frames : int
        Missing so far.
    """

    def __init__(self):
        self.frames = 0
        self.restart()

    def restart(self):
        """Another output begins: what lies between the two is not missing."""
        self._line = self._best = self._origin = None

    def look(self, frame, time_ns, sample_rate, block):
        """Take in when a block began.

        Parameters
        ----------
        frame, time_ns : int
            The first frame of a block and the time at which it was asked for [ns]; time 0: not known.
        sample_rate : float [Hz]
        block : int
            Its frames.
        """
        if time_ns == 0:
            return
        if self._origin is None or self._rate != sample_rate:
            self._origin, self._rate, self._line = (frame, time_ns), sample_rate, None
            self._best, self._ends = None, time_ns + _WINDOW_SECONDS * 1e9
        ahead = (frame - self._origin[0]) - (time_ns - self._origin[1]) * 1e-9 * sample_rate
        self._best = ahead if self._best is None else max(self._best, ahead)
        if time_ns >= self._ends:
            self._close_window(max(1, block))
            self._best, self._ends = None, time_ns + _WINDOW_SECONDS * 1e9

    def _close_window(self, block):
        behind = 0.0 if self._line is None else self._line - self._best
        if abs(behind) > 0.5 * block:
            blocks = round(behind / block)
            self.frames = max(0, self.frames + blocks * block)
        self._line = self._best


# What each level of shedding leaves out, beyond the one below it: see the engine's README.
_LEFT_OUT = (
    "",
    "strings that are nearly silent",
    "strings that only ring along and the end of the body's response",
    "contacts of fingers that come down",
)


class ShedWatch:
    """Tells what is left out where the computer is too slow."""

    def __init__(self):
        self._level = 0

    def look(self, level):
        """A sentence if ``level`` is another one than at the last look, else None."""
        before, self._level = self._level, level
        if level == before:
            return None
        if level == 0:
            return "the computer keeps up again: nothing is left out any more"
        if level < before:
            return f"the computer keeps up better: {_LEFT_OUT[level]} are all that is left out (level {level})"
        return f"the computer is too slow: {_LEFT_OUT[level]} are left out until it keeps up again (level {level})"


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
