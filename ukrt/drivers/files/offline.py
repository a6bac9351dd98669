"""Plays a score on an engine without a clock: a `Score` and an `Engine` enter, blocks and a log of notes leave.

Events at time t are sent at frame round(t fs); the engine lets go of strings a constant ``lead_frames`` later, and the
first ``lead_frames`` frames are left out of what is given, so that sample 0 is MIDI time 0 and a note's release falls
on its time.

After the score's end the sound goes on until the energy of strings, body and fingers has stayed ``tail_db`` below its
largest value for as long as the impulse response lasts, at most 30 s; its last 30 ms are faded out. A score without
notes takes its own duration and no more. Neither the samples nor their number depend on the block size.

A part is cut out of the whole, which is computed from its beginning: strings remember (`ukrt.drivers.files.part`).
"""

import math
import time

import numpy as np

MAX_TAIL_SECONDS = 30.0
FADE_SECONDS = 0.03
CHECK_FRAMES = 8192  # the tail's end and the progress are looked at on multiples of this, whatever the block size
SEND_LIMIT = 8192  # messages sent before the engine runs again: half of what its queue holds


class Performance:
    """One score played on one engine: gives the blocks that are to be written, and afterwards the log of the notes.

    Parameters
    ----------
    score : Score
    engine : Engine
        New, at frame 0.
    block_size : int
    tail_db : float [dB]
        Energy at which the tail ends, relative to its largest value.
    response_frames : int
        Length of the impulse response through which the sound is heard.
    progress : callable (done_s, total_s), optional
    """

    def __init__(self, score, engine, block_size, tail_db, response_frames=0, progress=None):
        self.score, self.engine, self.block_size = score, engine, block_size
        self._notes = []
        self.compute_seconds, self.timed_frames = 0.0, 0
        self._quiet_ratio = 10.0 ** (tail_db / 10.0)
        self._response_frames = response_frames
        self._progress = progress or (lambda done_s, total_s: None)
        self._rate = float(engine.sample_rate)
        self._frames = np.rint(score.time_s * self._rate).astype(np.int64)
        self._next = 0  # message to be sent
        self._notes_seen = 0
        self._largest_energy, self._quiet_since = 0.0, 0
        self._end = engine.lead_frames + math.ceil(score.duration_s * self._rate)

    def blocks(self):
        """Yield blocks, float64 (n <= block_size, channels) [Pa or N], from MIDI time 0 to the end of the tail."""
        engine, skip = self.engine, self.engine.lead_frames
        engine.energy()  # compiles it, if that is still to be done, before the clock runs
        fade = round(FADE_SECONDS * self._rate) if self.score.n_notes else 0
        last = self._end + round(MAX_TAIL_SECONDS * self._rate) - fade if self.score.n_notes else self._end
        while engine.frame < last and not self._is_quiet():
            stop = min((engine.frame // CHECK_FRAMES + 1) * CHECK_FRAMES, last)
            while engine.frame < stop:
                block = self._next_block(min(engine.frame + self.block_size, stop))
                dropped = min(skip, len(block))
                skip -= dropped
                if dropped < len(block):
                    yield block[dropped:]
            self._progress(*self._done())
        start = engine.frame
        while engine.frame < start + fade:
            at = engine.frame - start
            block = engine.process(min(self.block_size, fade - at))
            phase = (np.arange(at, at + len(block)) + 0.5) / fade
            yield block * (0.5 + 0.5 * np.cos(np.pi * phase))[:, None]

    def notes(self):
        """The log of the notes so far (list of dict)."""
        self._harvest()
        return self._notes

    def _done(self):
        done = max(self.engine.frame - self.engine.lead_frames, 0) / self._rate
        return done, max(done, self.score.duration_s)

    def _next_block(self, stop):
        """Send what is due before ``stop`` and compute up to there, or less far where too many messages are due."""
        first, start = self._next, self.engine.frame
        due = int(np.searchsorted(self._frames, stop))
        if due - first > SEND_LIMIT:  # the rest of those of this frame come one frame late
            due = first + SEND_LIMIT
            stop = max(int(self._frames[due - 1]), start) + 1
        columns = (self._frames, self.score.status, self.score.data1, self.score.data2)
        for frame, *message in zip(*(column[first:due].tolist() for column in columns), strict=True):
            if not self.engine.send(max(frame, start), *message):
                raise RuntimeError("the engine's message queue is full though it had been emptied")
        self._next = due
        began = time.perf_counter()
        block = self.engine.process(stop - start)
        if start > 0:
            self.compute_seconds += time.perf_counter() - began
            self.timed_frames += stop - start
        if self.engine.notes_logged - self._notes_seen >= SEND_LIMIT // 2:
            self._harvest()
        return block

    def _harvest(self):
        """Take over the log of notes before its ring comes round; rows known already are renewed."""
        rows = self.engine.note_log()
        self._notes_seen = self.engine.notes_logged
        self._notes[self._notes_seen - len(rows) :] = rows

    def _is_quiet(self):
        """Whether nothing is left to play and the energy has stayed low for as long as the impulse response lasts."""
        energy = self.engine.energy()
        self._largest_energy = max(self._largest_energy, energy)
        if energy > self._quiet_ratio * self._largest_energy or self.engine.frame < self._end:
            self._quiet_since = self.engine.frame
        response = self._response_frames if self._largest_energy > 0.0 else 0
        return self.engine.frame >= max(self._end, self._quiet_since + response)
