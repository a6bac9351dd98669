"""The one thread that writes into the engine's message queue: MIDI input and a piece enter, stamped messages leave.

The queue has a single writer by design. Messages of a piece go in a little ahead with their exact frames; messages of
a keyboard go in on arrival, stamped with the frame that is now plus a constant, so that neither the grid of blocks nor
the moods of this thread reach the ear.
"""

import threading
import time

from .clock import FrameClock

_POLL_SECONDS = 0.001
_MARGIN_SECONDS = 0.002  # constant delay of arriving messages: twice the polling interval, so that none comes too late
_AHEAD_SECONDS = 0.25  # how far ahead a piece is sent
_AHEAD_WITH_INPUT_SECONDS = 0.01  # nearer where a keyboard plays as well, whose messages go in behind the piece's
_START_SECONDS = 0.1  # silence before a piece's first frame, so that it is sent in time


class Feeder:
    """Feeds an engine while an output runs.

    Parameters
    ----------
    engine : Engine
        Gives ``send``, ``frame`` and ``sample_rate``.
    midi_input : object with ``poll() -> list of (status, data1, data2)``, optional
    """

    def __init__(self, engine, midi_input=None):
        self.received = 0
        self.refused = 0  # messages that found the queue full
        self.failure = None  # what ended the thread, if anything did
        self._engine, self._input = engine, midi_input
        self._rate = float(engine.sample_rate)
        self._clock = FrameClock(engine)
        self._last_frame = 0
        self._piece, self._next, self._piece_start = None, 0, 0
        self._piece_over = threading.Event()
        self._piece_over.set()
        self._lock = threading.Lock()
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="ukrt-midi", daemon=True)

    def start(self):
        """Start the thread (after the output, so that the frames are counting)."""
        self._thread.start()

    def close(self):
        """End the thread and close the input."""
        self._stop.set()
        if self._thread.ident is not None:
            self._thread.join()
        if self._input is not None:
            self._input.close()

    def listen(self, midi_input):
        """Take messages from ``midi_input`` from now on."""
        self._input = midi_input

    def play(self, score):
        """Send the messages of a `Score` from now on, each at its exact frame after the first."""
        frames = (score.time_s * self._rate).round().astype(int).tolist()
        events = list(zip(frames, score.status.tolist(), score.data1.tolist(), score.data2.tolist(), strict=True))
        with self._lock:
            self._piece_start = self._clock.frame() + int(_START_SECONDS * self._rate)
            self._piece, self._next = events, 0
            self._piece_end = self._piece_start + int(score.duration_s * self._rate)
            self._piece_over.clear()

    @property
    def piece_over(self):
        """Whether the piece has been sent and its last frame has passed (True without one)."""
        return self._piece_over.is_set()

    def _run(self):
        try:
            while not self._stop.is_set():
                with self._lock:
                    now = self._clock.frame()
                    self._feed_piece(now)
                    self._feed_input(now)
                time.sleep(_POLL_SECONDS)
        except Exception as error:  # a port that vanishes may raise anything; the main thread tells
            self.failure = error

    def _feed_piece(self, now):
        if self._piece is None:
            return
        ahead = _AHEAD_SECONDS if self._input is None else _AHEAD_WITH_INPUT_SECONDS
        horizon = now + int(ahead * self._rate)
        while self._next < len(self._piece):
            frame, *message = self._piece[self._next]
            if self._piece_start + frame > horizon:
                return
            self._send(self._piece_start + frame, message)
            self._next += 1
        if self._engine.frame >= self._piece_end:
            self._piece = None
            self._piece_over.set()

    def _feed_input(self, now):
        if self._input is None:
            return
        for message in self._input.poll():
            self.received += 1
            self._send(now + int(_MARGIN_SECONDS * self._rate), message)

    def _send(self, frame, message):
        frame = self._last_frame = max(frame, self._last_frame)
        if not self._engine.send(frame, *message):
            self.refused += 1
