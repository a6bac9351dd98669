"""Trills by a key that is held: where a slurred note ends while one it was slurred from is still held, the string goes
back to that one, by the left hand alone, as on every monophonic keyboard with legato.

Each string remembers up to HOLDS such notes, the last on top. Their note-offs are owed like those of any note that
sounds no more (I_OWED), so a key is on a string's list only while a note-off of it is still to come.
"""

from ukrt.engine import gestures as do
from ukrt.engine import player_layout as at
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.player_log import count, log_end, log_kept, log_note, log_place
from ukrt.engine.kernels.player_loosen import follow_touch
from ukrt.engine.kernels.player_pedals import is_held_by_pedal
from ukrt.engine.kernels.player_slur import slur_note, way_to
from ukrt.engine.kernels.player_strings import bend_string, note_ratio
from ukrt.engine.kernels.player_tuning import tune_note
from ukrt.engine.kernels.timeline import timeline_cancel


@kernel
def _take_out(i, s, k):
    """Forget the ``k``-th of the string's held notes."""
    i[at.S_HOLDS + s] -= 1
    for row in range(k, i[at.S_HOLDS + s]):
        for base in (at.HOLD_KEY, at.HOLD_FRET, at.HOLD_SEQ, at.HOLD_MOVED):
            i[base + row * at.ROW + s] = i[base + (row + 1) * at.ROW + s]


@kernel
def remember_hold(i, s):
    """The note of string ``s``, whose key is down, is slurred into another."""
    if i[at.S_HOLDS + s] == at.HOLDS:
        count(i, at.HOLDS_FORGOTTEN)
        _take_out(i, s, 0)
    row = i[at.S_HOLDS + s] * at.ROW + s
    i[at.HOLD_KEY + row], i[at.HOLD_SEQ + row] = i[at.S_KEY + s], i[at.S_SEQ + s]
    i[at.HOLD_FRET + row], i[at.HOLD_MOVED + row] = i[at.S_PITCH + s] - i[at.I_OPEN + s], i[at.S_MOVED + s]
    i[at.S_HOLDS + s] += 1


@kernel
def forget_hold(i, channel, key):
    """A key that was owed has come up: one note of it is held no more, if strings remember more than are still owed."""
    held, at_string, at_row = 0, -1, -1
    for s in range(i[at.I_STRINGS]):
        for k in range(i[at.S_HOLDS + s]):
            if i[at.S_CHANNEL + s] == channel and i[at.HOLD_KEY + k * at.ROW + s] == key:
                held, at_string, at_row = held + 1, s, k
    if held > i[at.I_OWED + channel * 128 + key]:
        _take_out(i, at_string, at_row)


@kernel
def forget_holds(i, channel):
    """No key of the channel is down any more."""
    for s in range(i[at.I_STRINGS]):
        if i[at.S_CHANNEL + s] == channel:
            i[at.S_HOLDS + s] = 0


@kernel
def go_back(d, i, s, frame):
    """The key of the note on string ``s`` comes up: go back to the last held note that the left hand can go back to.

    Returns
    -------
    bool
        Whether there is one. With the pedal down the note rings on instead.
    """
    if i[at.S_RESUMED + s] == frame:
        _take_back(d, i, s, frame)
    channel = i[at.S_CHANNEL + s]
    if is_held_by_pedal(i, s):
        return False
    for k in range(i[at.S_HOLDS + s] - 1, -1, -1):
        fret = i[at.HOLD_FRET + k * at.ROW + s]
        way = way_to(i, s, channel, i[at.I_OPEN + s] + fret)
        if way != at.PLUCKED:
            _resume(d, i, s, frame, k, fret, way)
            return True
    return False


@kernel
def _resume(d, i, s, frame, k, fret, way):
    """The ``k``-th held note sounds again, as a new note of the log with its own force."""
    channel, key, former = i[at.S_CHANNEL + s], i[at.HOLD_KEY + k * at.ROW + s], i[at.HOLD_SEQ + k * at.ROW + s]
    source = former if log_kept(i, former) else i[at.S_SEQ + s]
    force = d[at.D_LOG_FORCE + source % at.LOG_CAPACITY]
    moved, i[at.S_CAUGHT + s] = i[at.HOLD_MOVED + k * at.ROW + s], 0
    ended, left = i[at.S_SEQ + s], i[at.S_FINGER + s] if i[at.S_LOOSE + s] > 0 else 0
    log_end(i, ended, frame, at.PLAYED)
    seq = log_note(d, i, frame, channel, key, force)
    log_place(i, seq, s, fret, way)
    count(i, at.NOTES_RESUMED)
    _take_out(i, s, k)
    i[at.I_OWED + channel * 128 + key] -= 1
    tuned = i[at.S_TUNED + s]
    tune_note(i, s, channel, key, moved)
    slur_note(d, i, s, frame, fret, force, channel, way)
    if i[at.S_TUNED + s] != tuned:
        bend_string(d, i, s, frame, note_ratio(d, i, s, channel))
    i[at.S_RESUMED + s], i[at.S_FORMER + s], i[at.S_LEFT + s] = frame, ended, left
    i[at.S_KEY + s], i[at.S_PITCH + s], i[at.S_SEQ + s] = key, i[at.I_OPEN + s] + fret, seq
    follow_touch(d, i, s, frame)


@kernel
def _take_back(d, i, s, frame):
    """The note that the string went back to in this very frame ends, too: it never began; the finger is where it was.

    Its row of the log is taken back where it is the last; else it stays, with no length.
    """
    seq, finger = i[at.S_SEQ + s], i[at.S_STAYS + s]
    if i[at.S_PULLED + s] == frame:
        finger = i[at.S_PULLED_FROM + s]
    elif i[at.S_FINGER + s] == 0:
        finger = 0
    timeline_cancel(d, i, s, do.LIFT, frame)
    timeline_cancel(d, i, s, do.PRESS, frame)
    i[at.S_FINGER + s], i[at.S_PULLED + s], i[at.S_STEP + s], i[at.S_LOOSE + s] = finger, -1, 0, 0
    if i[at.S_LEFT + s] > 0:
        i[at.S_FINGER + s], i[at.S_LOOSE + s] = i[at.S_LEFT + s], max(1, i[at.C_LOOSE + i[at.S_CHANNEL + s]])
    if seq == i[at.I_NEXT_SEQ] - 1:
        i[at.I_NEXT_SEQ] = seq
        count(i, at.NOTES_RESUMED, -1)
        count(i, at.NOTE_LOG_OVERFLOWS, -1 if seq >= at.LOG_CAPACITY else 0)
    else:
        log_end(i, seq, frame, at.PLAYED)
    i[at.S_SEQ + s], i[at.S_RESUMED + s] = i[at.S_FORMER + s], -1
