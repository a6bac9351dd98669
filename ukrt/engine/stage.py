"""The stage as Python sees it: flat arrays shared with the callback; stamps, journal, samples and counters leave."""

import threading

import numpy as np

from ukrt.engine import layout as instance_at
from ukrt.engine import stage_layout as at
from ukrt.engine.compiled import limiter_gain
from ukrt.engine.memory import Block
from ukrt.engine.note_log import read_counters
from ukrt.units import gain_to_db

SHED_BUDGET = 0.9  # of a block's period: live default
MESSAGE_CAP = 64  # messages played in 64 frames, live default: bounds the work of a flood (choice)
_RING_FLOATS = 2 * at.RING_FRAMES
_TRIES = 1000  # of reading a stamp while it is being written


class Stage:
    """What lies between hosts and instruments.

    Parameters
    ----------
    channels : int
    shared : bool
        Live: in shared memory, with the limiter, shedding, bounded bursts of messages and the ring of samples switched
        on.
    """

    def __init__(self, channels, shared=False):
        self.live, self.channels = shared, channels
        sizes = {"si": ("i8", at.SI_SIZE), "sd": ("f8", at.SD_SIZE), "ring": ("f4", _RING_FLOATS if shared else 16)}
        self.block = Block(sizes, shared)
        self._look()

    def _look(self):
        self.arrays = self.block.arrays
        self.si, self.sd = self.arrays["si"], self.arrays["sd"]

    def reset(self, sample_rate):
        """Frame 0, nothing waiting, counters at zero, settings as at first."""
        si, sd, tick_rate = self.si, self.sd, self.sd[at.M_TICKS_PER_SECOND]
        si[:], sd[:] = 0, 0.0
        self.arrays["ring"][:] = 0.0  # every page is there before the callback writes it
        sd[at.M_TICKS_PER_SECOND], sd[at.M_RATE] = tick_rate, sample_rate
        si[at.G_CHANNELS] = self.channels
        si[at.LANE_SENSED : at.LANE_SENSED + at.LANE_STEP * at.LANES] = -1
        si[at.G_RING_FRAMES] = len(self.arrays["ring"]) // self.channels
        si[at.G_LIMITER] = si[at.G_RECORD] = self.live
        si[at.G_CAP] = MESSAGE_CAP if self.live else 0
        sd[at.M_SHED_BUDGET] = SHED_BUDGET if self.live else 0.0

    @property
    def limiter(self):
        """Whether what goes to a card is limited (bool)."""
        return bool(self.si[at.G_LIMITER])

    @limiter.setter
    def limiter(self, on):
        self.si[at.G_LIMITER] = bool(on)

    @property
    def message_cap(self):
        """Most messages played in 64 frames, 0: no bound (int)."""
        return int(self.si[at.G_CAP])

    @message_cap.setter
    def message_cap(self, cap):
        self.si[at.G_CAP] = cap

    @property
    def shed_budget(self):
        """Share of a block's period above which it counts as too slow, 0: nothing is ever shed [1]."""
        return float(self.sd[at.M_SHED_BUDGET])

    @shed_budget.setter
    def shed_budget(self, load):
        self.sd[at.M_SHED_BUDGET] = load
        if load == 0.0:
            self.si[at.G_SHED_WANTED] = 0

    def set_map(self, entries):
        """Let what arrives live mean something else from now on: see `map_layout.map_entry`.

        May be done at any time: the other of two tables is written, then it counts. By one thread at a time.

        Parameters
        ----------
        entries : dict of (channel, source) to int
            What is not in it means itself.
        """
        si = self.si
        which = 3 - max(int(si[at.G_MAP]), 1)
        table = np.zeros((16, at.MAP_SOURCES), np.int64)
        for (channel, source), entry in entries.items():
            table[channel, source] = entry
        start = at.MAPS + at.MAP_SIZE * (which - 1)
        si[start : start + at.MAP_SIZE] = table.ravel()
        with threading.Lock():  # where processors reorder stores, the table is there before its number says so
            pass
        si[at.G_MAP] = which if entries else 0

    def settings(self):
        """What changes the samples of a card (dict)."""
        return {"limiter": self.limiter}

    def apply(self, settings):
        """Take over what `settings` gave."""
        self.limiter = settings["limiter"]

    def stamp(self):
        """Frame and time (``time.monotonic_ns``) at which the last block began; time 0 where no clock is known."""
        si = self.si
        for _ in range(_TRIES):
            sequence = int(si[at.G_STAMP_SEQ])
            frame, now = int(si[at.G_STAMP_FRAME]), int(si[at.G_STAMP_NS])
            if sequence % 2 == 0 and sequence == si[at.G_STAMP_SEQ]:
                return frame, now
        return frame, 0  # its writer died in the middle of it

    def journal(self, since):
        """What has acted on the instrument.

        Parameters
        ----------
        since : int
            Number of the first entry wanted.

        Returns
        -------
        next : int
            Number of the first entry still to come.
        entries : ndarray (n, 2) int64
            Frame and word of each, in order.
        lost : int
            How many from ``since`` on had been overwritten.
        """
        return self._from_ring(at.N_JOURNAL, self.si[at.JOURNAL_AT : at.JOURNAL_AT + 2 * at.JOURNAL], 2, since)

    def recorded(self, since):
        """What the card got, as `journal`: (next, samples (n, channels) float32, lost)."""
        size = int(self.si[at.G_RING_FRAMES]) * self.channels
        return self._from_ring(at.N_RECORDED, self.arrays["ring"][:size], self.channels, since)

    def _from_ring(self, counter, flat, width, since):
        """Rows ``since`` to the newest out of a ring of rows; those overwritten while copying count as lost."""
        rows = flat.reshape(-1, width)
        count = int(self.si[counter])
        first = min(max(since, count - len(rows)), count)
        got = rows[np.arange(first, count) % len(rows)]
        # The callback may have gone on while we copied, and may be in the middle of its next piece.
        dropped = min(max(int(self.si[counter]) + at.MAX_PIECE - len(rows) - first, 0), len(got))
        return count, got[dropped:], first - since + dropped

    def fill_ring(self):
        """Silence for the frames that a host computed but did not live to give to the card, so that the ring keeps
        pace with the journal; only while nobody calls the callback."""
        si, rows = self.si, int(self.si[at.G_RING_FRAMES])
        first, end = int(si[at.N_RECORDED]), int(si[at.G_FRAME])
        if si[at.G_RECORD] and first < end:
            ring = self.arrays["ring"][: rows * self.channels].reshape(rows, self.channels)
            ring[np.arange(first, end) % rows] = 0.0
            si[at.N_RECORDED] = end

    def peak_recent(self):
        """The loudest sample that came to the limiter since the last call [1]."""
        peak = float(self.sd[at.M_PEAK_RECENT])
        self.sd[at.M_PEAK_RECENT] = 0.0
        return peak

    def counters(self, instance):
        """Everything that was counted.

        Parameters
        ----------
        instance : ndarray of int64
            The numbers ``i`` of the instance that is heard.

        Returns
        -------
        dict
            Numbers by name; ``load_histogram`` is a list of (share of the block's period, blocks).
        """
        si = self.si
        counts = {name: int(si[at.COUNTS + k]) for k, name in enumerate(at.COUNT_NAMES)}
        refused = si[at.LANE_REFUSED : at.LANE_REFUSED + at.LANE_STEP * at.LANES].reshape(at.LANES, at.LANE_STEP)
        by_class = refused[:, : at.CLASSES].sum(axis=0)
        counts |= {
            "frames": int(si[at.G_FRAME]),
            "shed_level": int(si[at.G_SHED]),
            "mapped_to_nothing": int(refused[:, at.LANE_UNMAPPED].sum()),
            "midi_dropped": int(by_class.sum()),
            "controllers_refused": int(by_class[at.CLASS_OTHER]),
            "notes_refused": int(by_class[at.CLASS_NOTE_ON]),
            "note_ends_refused": int(by_class[at.CLASS_OFF]),
            "gestures_executed": int(instance[instance_at.H_GESTURES_DONE]),
            "gestures_dropped": int(instance[instance_at.H_GESTURES_DROPPED]),
            "peak": float(self.sd[at.M_PEAK]),
            "limiter_db": self._limiter_db(),
        }
        bins = si[at.LOAD : at.LOAD + at.LOAD_BINS].copy()  # the callback goes on counting
        middles = 2.0 ** ((np.arange(at.LOAD_BINS) + 0.5 - at.LOAD_FULL) / at.LOAD_PER_OCTAVE)
        loads = [(float(middles[k]), int(bins[k])) for k in np.flatnonzero(bins)]
        return counts | read_counters(instance) | {"load_histogram": loads}

    def _limiter_db(self):
        """The most that the limiter has taken away [dB], 0 or negative."""
        return gain_to_db(limiter_gain(float(self.sd[at.M_PEAK]))) if self.limiter else 0.0

    def close(self):
        """Give shared memory back; what was counted can still be read."""
        self.arrays, self.si, self.sd = {}, None, None
        self.block.close()
        self._look()
