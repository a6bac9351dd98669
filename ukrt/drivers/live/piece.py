"""Plays a piece: a `Score` enters, its messages leave for the engine's queue a second ahead, each with its exact frame.

The frames come out as in a rendered file, later by a constant, so that no mood of this thread reaches the ear. A piece
can go round and round without a seam, wait for a keyboard's first note, or follow the transport of an audio server.
Where the sample rate changes, what is still to be sent is reckoned at the new one; where nobody was there to send in
time (a stopped process), the rest of the piece is put off and not squeezed.
"""

import bisect
import collections
import threading

from ukrt.engine.stage_layout import KIND_MIDI, KIND_SHIFT

_POLL_SECONDS = 0.01
_AHEAD_SECONDS = 1.0  # how far ahead a piece is sent: longer than any pause of Python's threads (a choice)
_AHEAD_FOLLOWING_SECONDS = 0.1  # what a transport that stops may still let sound (a choice)
_START_SECONDS = 0.2  # silence before a piece's first frame, so that it is sent in time: more than the longest block
_ANSWER_SECONDS = 0.02  # from a keyboard's first note, or a transport that starts, to the first message (a choice)
_JUMP_SECONDS = 0.03  # a transport that is off by more than this has jumped: longer than a block of 1024 frames
_MOST_WAITING = 8192  # messages sent and not played yet: half of what a lane holds
_SHORTEST_LOOP_SECONDS = 0.1


class PiecePlayer:
    """Sends a `Score` to an engine that runs, from a thread of its own.

    Parameters
    ----------
    engine : Engine
        Gives ``send``, ``frame`` and ``sample_rate``, which may change; and ``journal`` where ``wait`` is asked for.
    score : Score
    loop : bool
        Begin again at the end, without a gap, until closed.
    wait : bool
        Begin with the first note that somebody else plays, instead of with `start`.
    transport : callable () -> (rolling, position_s, frame), optional
        Somebody else's clock to follow: whether it runs, and which second of the piece falls on which frame.
    """

    def __init__(self, engine, score, loop=False, wait=False, transport=None):
        self.failure = None  # what ended the thread, if anything did
        self.sent, self.slips = 0, 0  # messages; times the piece was put off because nobody had sent for too long
        self._engine, self._loop, self._wait, self._transport = engine, loop, wait, transport
        columns = (score.time_s, score.status, score.data1, score.data2)
        self._events = list(zip(*(column.tolist() for column in columns), strict=True))
        self._duration = max(score.duration_s, _SHORTEST_LOOP_SECONDS) if loop else score.duration_s
        if loop:
            self._events += [(self._duration, *message) for message in loose_ends(self._events)]
        self._times = [event[0] for event in self._events]
        self._pass, self._next = 0, 0  # which time through the piece, which event of it comes next
        self._anchor = None  # frame and second (of all passes) that belong together; None while the piece stands
        self._rate, self._last_frame = float(engine.sample_rate), 0
        self._waiting = collections.deque()  # frames of the messages that the engine has not come to yet
        self._journal = 0
        self._over = threading.Event()
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="ukrt-piece", daemon=True)

    def start(self):
        """Start the thread (after the output, so that the frames are counting), and the piece unless it is to wait."""
        if not self._wait and self._transport is None:
            self._begin(self._engine.frame + round(_START_SECONDS * self._rate))
        self._thread.start()

    def close(self):
        """End the thread; what is queued already is still played by whoever goes on asking for sound."""
        self._stop.set()
        if self._thread.ident is not None:
            self._thread.join()

    @property
    def begun(self):
        """Whether the piece is being played (False while it waits or stands)."""
        return self._anchor is not None

    @property
    def over(self):
        """Whether the piece's last frame has passed; never with ``loop`` or ``transport``."""
        return self._over.is_set()

    @property
    def position_s(self):
        """The second of the piece that is played now [s]; 0 before it begins."""
        anchor = self._anchor
        if anchor is None:
            return 0.0
        seconds = max(0.0, anchor[1] + (self._engine.frame - anchor[0]) / self._rate)
        return seconds % self._duration if self._loop else min(seconds, self._duration)

    def _run(self):
        try:
            while not self._stop.wait(_POLL_SECONDS):
                self.turn()
        except Exception as error:  # the main thread tells, whatever it was
            self.failure = error

    def turn(self):
        """One look: has the rate changed, does somebody else's clock or keyboard say so, what is to be sent."""
        if (rate := float(self._engine.sample_rate)) != self._rate:
            if self._anchor is not None:  # what has been sent stays; from there on the new rate counts
                at = max(self._last_frame, self._engine.frame)
                self._anchor = (at, self._anchor[1] + (at - self._anchor[0]) / self._rate)
            self._rate = rate
        if self._transport is not None:
            self._follow()
        elif self._anchor is None and self._wait:
            self._listen()
        if self._anchor is not None and not self._over.is_set():
            self._feed()

    def _begin(self, frame, second=0.0):
        """Let ``second`` of the piece fall on ``frame``, and go on from there."""
        self._next = bisect.bisect_left(self._times, second)
        self._pass = 0
        self._anchor = (frame, second)

    def _listen(self):
        """Begin if a note has been played."""
        self._journal, rows, _ = self._engine.journal(self._journal)
        for frame, word in rows.tolist():
            if word >> KIND_SHIFT == KIND_MIDI and word >> 16 & 0xF0 == 0x90 and word & 0x7F:
                margin = round(_ANSWER_SECONDS * self._rate)
                self._begin(max(frame, self._engine.frame + margin))
                return

    def _follow(self):
        """Go, stand or jump as the transport does."""
        rolling, second, frame = self._transport()
        if not rolling or not 0.0 <= second < self._duration:
            if self._anchor is not None:
                self._fall_silent()
                self._anchor = None
            return
        if self._anchor is not None:
            expected = self._anchor[1] + (frame - self._anchor[0]) / self._rate
            if abs(expected - second) < _JUMP_SECONDS:
                return
            self._fall_silent()
        self._begin(frame, second)
        earliest = self._engine.frame + round(_ANSWER_SECONDS * self._rate)
        self._next = bisect.bisect_left(self._times, second + (earliest - frame) / self._rate)

    def _fall_silent(self):
        """End what the messages sent so far hold, as soon as those have been played."""
        frame = max(self._last_frame, self._engine.frame)
        for message in loose_ends(self._events[: self._next]):
            self._send(frame, message)

    def _feed(self):
        """Send what is due within the next second; what finds no room is sent later."""
        now = self._engine.frame
        ahead = _AHEAD_SECONDS if self._transport is None else _AHEAD_FOLLOWING_SECONDS
        while self._waiting and self._waiting[0] < now:
            self._waiting.popleft()
        while len(self._waiting) < _MOST_WAITING:
            if self._next == len(self._events):
                if not self._loop:
                    break
                self._pass, self._next = self._pass + 1, 0
            time_s, *message = self._events[self._next]
            frame = self._frame(self._pass * self._duration + time_s)
            if frame < now and self._transport is None:  # this thread was kept from its work: later, but not squeezed
                self._put_off(now - frame)
                continue
            if frame > now + ahead * self._rate or not self._send(frame, message):
                return
            self._next += 1
        ended = self._next == len(self._events) and not self._loop and self._transport is None
        if ended and self._engine.frame >= self._frame(self._duration):
            self._over.set()

    def _put_off(self, frames):
        self._anchor = (self._anchor[0] + frames + round(_START_SECONDS * self._rate), self._anchor[1])
        self.slips += 1

    def _frame(self, second):
        return self._anchor[0] + round((second - self._anchor[1]) * self._rate)

    def _send(self, frame, message):
        frame = max(frame, self._last_frame)
        if not self._engine.send(frame, *message):
            return False
        self._last_frame = frame
        self._waiting.append(frame)
        self.sent += 1
        return True


def loose_ends(events):
    """What ends all that ``events`` leave held.

    Parameters
    ----------
    events : list of (time_s, status, data1, data2)

    Returns
    -------
    list of (status, data1, data2)
        Note-offs, and for each channel whose controllers or bender were moved, all of them back (CC121).
    """
    held, moved = {}, set()
    for _, status, data1, data2 in events:
        kind, channel = status & 0xF0, status & 0x0F
        if kind == 0x90 and data2:
            held[channel, data1] = None
        elif kind in (0x80, 0x90):
            held.pop((channel, data1), None)
        elif kind in (0xB0, 0xE0):
            moved.add(channel)
    return [(0x80 | channel, key, 0) for channel, key in held] + [(0xB0 | channel, 121, 0) for channel in sorted(moved)]
