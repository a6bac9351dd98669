"""The stage as a process without NumPy sees it: shared memory enters, a writer into one lane and block stamps leave.

The same rules as in `engine/kernels/queue.py`, in plain Python on memoryviews: a lane that fills up refuses first what
can be missed, then new notes, and the end of notes only when it is full.
"""

import threading

from ukrt.engine import stage_layout as at
from ukrt.engine.map_layout import DROPPED, mapped
from ukrt.engine.shared import attach_shared

_PEDALS, _DOWN = range(64, 67), 64  # CC64 sustain to CC66 soft; values from 64 on are "down"
_MODES = 120  # controllers from here on are channel mode messages: they end notes or reset
_SYSTEM_RESET = 0xFF
_TRIES = 100  # of reading a stamp while it is being written


def message_class(status, data1, data2):
    """What a MIDI message is to a full lane (CLASS_OFF ends notes, CLASS_NOTE_ON begins one, CLASS_OTHER)."""
    kind = status & 0xF0
    if kind == 0x80 or (kind == 0x90 and data2 == 0) or status == _SYSTEM_RESET:
        return at.CLASS_OFF
    if kind == 0x90:
        return at.CLASS_NOTE_ON
    if kind == 0xB0 and (data1 >= _MODES or (data1 in _PEDALS and data2 < _DOWN)):
        return at.CLASS_OFF
    return at.CLASS_OTHER


class Lane:
    """The one writer of a lane.

    Parameters
    ----------
    si : memoryview of int64 or ndarray of int64
        The stage's integers.
    number : int
        ``LANE_MIDI`` and so on.
    """

    def __init__(self, si, number):
        self._si = si
        self._write, self._read = at.LANE_WRITE + number * at.LANE_STEP, at.LANE_READ + number * at.LANE_STEP
        self._refused = at.LANE_REFUSED + number * at.LANE_STEP
        self._queue = at.QUEUES + number * at.LANE_SIZE
        self._fence = threading.Lock()

    def meaning(self, status, data1=0, data2=0):
        """The message that a player's message means by the stage's map: (status, data1, data2).

        None, and counted, where it means nothing.
        """
        word = mapped(self._si, status << 16 | data1 << 8 | data2)
        if word == DROPPED:
            self._si[self._refused + at.LANE_UNMAPPED] += 1
            return None
        return word >> 16, word >> 8 & 0xFF, word & 0xFF

    def push(self, frame, status, data1=0, data2=0):
        """Let a MIDI message act at ``frame``; a frame before that of a message still waiting becomes the same frame.

        Returns
        -------
        bool
            False where the lane refused it, which it counts by class.
        """
        si, kind = self._si, message_class(status, data1, data2)
        written = si[self._write]
        waiting = written - si[self._read]
        if waiting >= at.ROOM[kind]:
            si[self._refused + kind] += 1
            return False
        if waiting > 0:
            frame = max(frame, si[self._queue + 2 * ((written - 1) % at.QUEUE)])
        slot = self._queue + 2 * (written % at.QUEUE)
        si[slot], si[slot + 1] = frame, status << 16 | data1 << 8 | data2
        with self._fence:  # 0.1 us: where processors reorder stores, the message is there before its number says so
            pass
        si[self._write] = written + 1
        return True

    def refused(self):
        """Messages refused so far by class (list of CLASSES ints)."""
        return [self._si[self._refused + kind] for kind in range(at.CLASSES)]


class StageView:
    """Attached arrays of a stage in the shared memory of another process.

    Parameters
    ----------
    manifest : dict
        ``name`` of the shared memory; ``arrays``: ``{"si": [type, offset in bytes, length], "sd": ...}``, as
        ``Engine(shared=True).manifest()["stage"]`` has it.
    """

    def __init__(self, manifest):
        self._memory = attach_shared(manifest["name"])
        (_, si_at, si_length), (_, sd_at, sd_length) = manifest["arrays"]["si"], manifest["arrays"]["sd"]
        if si_length != at.SI_SIZE or sd_length != at.SD_SIZE:
            raise ValueError(f"a stage has {at.SI_SIZE} integers and {at.SD_SIZE} floats, not {si_length}, {sd_length}")
        self.si = self._memory.buf[si_at : si_at + 8 * si_length].cast("q")
        self._sd = self._memory.buf[sd_at : sd_at + 8 * sd_length].cast("d")

    @property
    def frame(self):
        """The next frame to be computed (int)."""
        return self.si[at.G_FRAME]

    @property
    def sample_rate(self):
        """Sample rate of what plays now [Hz]."""
        return self._sd[at.M_RATE]

    def stamp(self):
        """Frame, time [ns of ``time.monotonic_ns``] and frames of the last block begun; time 0 where nobody stamps."""
        si = self.si
        for _ in range(_TRIES):
            sequence = si[at.G_STAMP_SEQ]
            stamp = si[at.G_STAMP_FRAME], si[at.G_STAMP_NS], si[at.G_STAMP_BLOCK]
            if not sequence & 1 and si[at.G_STAMP_SEQ] == sequence:
                return stamp
        return stamp[0], 0, stamp[2]  # its writer died in the middle of it

    def close(self):
        """Let go of the memory, which stays as long as its owner wants."""
        self.si.release()
        self._sd.release()
        self._memory.close()
