"""A part of a sound: the blocks of the whole enter, those of the part leave, and what happened in it.

The whole is computed from its beginning up to the part's end, for strings remember; nothing is faded that is not faded
in the whole. So the part is bit for bit what stands there in the whole.
"""

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Part:
    """What of a sound is wanted.

    Attributes
    ----------
    start, end : int or float
        Frames of the whole; an infinite end is the whole's.
    """

    start: int = 0
    end: float = math.inf

    @classmethod
    def of_seconds(cls, start_s, end_s, sample_rate):
        """The part between two times [s], of one frame at least."""
        start = round(start_s * sample_rate)
        return cls(start, end_s if math.isinf(end_s) else max(round(end_s * sample_rate), start + 1))

    @property
    def is_whole(self):
        """Whether nothing is cut off."""
        return self.start == 0 and math.isinf(self.end)

    def cut(self, blocks, to_end=False):
        """The part's frames of each block of the whole.

        Parameters
        ----------
        blocks : iterable of ndarray (n, channels)
            The whole, from its first frame.
        to_end : bool
            Whether the whole is gone through to its end.

        Yields
        ------
        ndarray (n, channels)
            A block of the whole.
        ndarray (m, channels)
            What of it belongs to the part, m from 0 to n.
        """
        at = 0
        for block in blocks:
            first, last = max(self.start - at, 0), max(min(self.end - at, len(block)), 0)
            yield block, block[first:last]
            at += len(block)
            if at >= self.end and not to_end:
                return

    def notes(self, notes):
        """The notes of a log whose release lies in the part, with ``release_frame`` counted from its beginning."""
        return [
            note | {"release_frame": note["release_frame"] - self.start}
            for note in notes
            if self.start <= note["release_frame"] < self.end
        ]


def count_all(total, counters):
    """What became of ``total`` notes, from the engine's counters (dict of str to int)."""
    fates = ("dropped", "stolen", "folded", "percussion")
    return {"notes_total": total} | {f"notes_{fate}": counters.get(f"notes_{fate}", 0) for fate in fates}


def count_notes(notes):
    """What became of the notes of a part, from the log (dict of str to int).

    Which notes were moved by octaves the log does not tell: they are not counted here.
    """
    fates = [note["fate"] for note in notes]
    return {"notes_total": len(notes)} | {
        f"notes_{fate}": fates.count(fate) for fate in ("dropped", "stolen", "percussion")
    }
