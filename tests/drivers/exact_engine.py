"""A stand-in for the engine with the same face: each note is a step at its release and a decay known exactly."""

import numpy as np

from ukrt.model.presets import load_preset

EXACT = load_preset("paper", {"name": "exact", "radiation.gain_db": 6.0})


class ExactEngine:
    """Note-ons sound ``amplitude * exp(-(n - release) / decay_frames)`` from their release on; energy is its square.

    The queue and the log are as small as an engine may have them; misuse raises.
    """

    QUEUE = 16384
    LOG = 16384
    LEAD = 480
    MAX_BLOCK = 8192

    def __init__(self, guitar, sample_rate, signal="pressure", decay_s=0.2, response_frames=4800):
        self.guitar, self.sample_rate, self.signal = guitar, sample_rate, signal
        self.channels = {"pressure": 2, "bridge-force": 1, "strings": 6}[signal]
        self.lead_frames, self.response_frames = self.LEAD, response_frames
        self.frame, self.closed, self.blocks = 0, False, []
        self.received, self.late = [], 0
        self._decay = decay_s * sample_rate
        self._queue, self._sounding, self._log = [], [], []

    def send(self, frame, status, data1, data2):
        if len(self._queue) == self.QUEUE:
            return False
        assert all(type(value) is int for value in (frame, status, data1, data2))
        assert not self._queue or frame >= self._queue[-1][0]
        self.late += frame < self.frame
        self._queue.append((frame, status, data1, data2))
        return True

    def process(self, n):
        assert 1 <= n <= self.MAX_BLOCK
        self.blocks.append(n)
        while self._queue and self._queue[0][0] < self.frame + n:
            self._act(*self._queue.pop(0))
        at = np.arange(self.frame, self.frame + n)
        out = np.zeros(n)
        for release, amplitude in self._sounding:
            out += np.where(at >= release, amplitude * np.exp(-np.maximum(at - release, 0) / self._decay), 0.0)
        self.frame += n
        return np.outer(out, 1.0 / np.arange(1, self.channels + 1))

    def _act(self, frame, status, key, velocity):
        self.received.append((frame, status, key, velocity))
        if status & 0xF0 == 0x90 and velocity:
            if self._decay > 0.0:
                self._sounding.append((frame + self.LEAD, velocity / 127))
            self._log.append(
                {
                    "time_s": frame / self.sample_rate,
                    "release_frame": np.int64(frame + self.LEAD),
                    "midi": key,
                    "channel": 0,
                    "string": 0,
                    "fret": (key - 40) % 20,
                    "force_n": np.float64(1.0),
                    "end_s": None,
                    "fate": "played",
                }
            )
        elif status & 0xF0 in (0x80, 0x90):
            for row in self._log:
                if row["midi"] == key and row["end_s"] is None:
                    row["end_s"] = frame / self.sample_rate

    def energy(self):
        return float(
            sum(amplitude * np.exp(-max(self.frame - at, 0) / self._decay) for at, amplitude in self._sounding) ** 2
        )

    def counters(self):
        return {"notes_dropped": 0, "notes_stolen": np.int64(0), "peak": 1.0, "load_histogram": np.zeros(9)}

    @property
    def notes_logged(self):
        return len(self._log)

    def note_log(self):
        return [dict(row) for row in self._log[-self.LOG :]]

    def close(self):
        self.closed = True
