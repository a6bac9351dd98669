"""The player's counters and its log of notes: what was asked, which string and fret it got, when and why it ended.

A note enters when its note-on arrives and keeps its number; its row is found by that number modulo the log's length.
"""

from ukrt.engine import player_layout as at
from ukrt.engine.kernels.jit import kernel


@kernel
def count(i, which, amount=1):
    """Add ``amount`` to one counter."""
    i[at.I_COUNTERS + which] += amount


@kernel
def log_note(d, i, frame, channel, key, force):
    """Open a row for a note-on; returns the note's number."""
    seq = i[at.I_NEXT_SEQ]
    i[at.I_NEXT_SEQ] = seq + 1
    if seq >= at.LOG_CAPACITY:
        count(i, at.NOTE_LOG_OVERFLOWS)
    row = seq % at.LOG_CAPACITY
    i[at.L_FRAME + row] = frame
    i[at.L_END + row] = -1
    i[at.L_KEY + row] = key
    i[at.L_CHANNEL + row] = channel
    i[at.L_STRING + row] = -1
    i[at.L_FRET + row] = -1
    i[at.L_FATE + row] = at.PLAYED
    i[at.L_WAY + row] = at.PLUCKED
    i[at.L_LATE + row], i[at.L_FINGER + row] = 0, at.NO_FINGER
    d[at.D_LOG_FORCE + row] = force
    return seq


@kernel
def log_kept(i, seq):
    """Whether the note's row has not been overwritten."""
    return seq >= 0 and i[at.I_NEXT_SEQ] - seq <= at.LOG_CAPACITY


@kernel
def log_place(i, seq, s, fret, way):
    """Say which string and fret a note got (-1, -1: none), and how it is played."""
    if log_kept(i, seq):
        i[at.L_STRING + seq % at.LOG_CAPACITY] = s
        i[at.L_FRET + seq % at.LOG_CAPACITY] = fret
        i[at.L_WAY + seq % at.LOG_CAPACITY] = way


@kernel
def log_pluck(i, seq, late, finger):
    """Say how many frames a strum lets a note wait, and which finger plucks it."""
    if log_kept(i, seq):
        i[at.L_LATE + seq % at.LOG_CAPACITY] = late
        i[at.L_FINGER + seq % at.LOG_CAPACITY] = finger


@kernel
def log_end(i, seq, frame, fate):
    """Say when (-1: it rings) and how a note ended."""
    if log_kept(i, seq):
        i[at.L_END + seq % at.LOG_CAPACITY] = frame
        i[at.L_FATE + seq % at.LOG_CAPACITY] = fate
