"""Strums: the hand sweeps over the strings at an even speed and comes to the strings of a chord one after another.

Enter a chord whose notes have their strings; leave how many frames each of them waits (X_LATE). Notes that come just
after a stroke has begun, to strings that lie ahead of the hand, join it, as those of a chord on a keyboard do, which
never come at once. The left hand does not wait.
"""

from ukrt.engine import controller_layout as cc
from ukrt.engine import player_layout as at
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.player_right_hand import direction, strum_frames
from ukrt.engine.kernels.player_slur import way_of

FROM_BASS, FROM_TREBLE = 1, -1  # values of I_STROKE_WAY


@kernel
def _plucked_by(d, i, note):
    """What goes into X_LATE before the hand has moved."""
    s = i[at.G_STRING + note]
    if s < 0 or way_of(i, note, s) in (at.HAMMERED, at.PULLED, at.SLID):
        return at.NOT_PLUCKED
    return 0 if strum_frames(d, i, i[at.G_CHANNEL + note]) > 0 else at.BY_FINGER


@kernel
def _way_to(i, s):
    """Strings from where the stroke began to ``s``; below 0 behind the hand."""
    return i[at.I_STROKE_WAY] * (s - i[at.I_STROKE_FROM])


@kernel
def _comes(d, i, note):
    """The frame at which the hand comes to a note of the chord."""
    frames, strings = strum_frames(d, i, i[at.G_CHANNEL + note]), i[at.I_STRINGS]
    return i[at.I_STROKE] + frames * _way_to(i, i[at.G_STRING + note]) // max(1, strings - 1)


@kernel
def _joins(d, i, frame):
    """Whether the stroke under way can take the chord: all its strings lie ahead of the hand."""
    if i[at.I_STROKE_WAY] == 0 or frame - i[at.I_STROKE] > i[at.I_STROKE_JOIN]:
        return False
    for note in range(i[at.G_COUNT]):
        if i[at.X_LATE + note] >= 0:
            if _way_to(i, i[at.G_STRING + note]) < 1 or _comes(d, i, note) < frame:
                return False
    return True


@kernel
def _begin_stroke(i, frame, value, lowest, highest):
    """A new stroke, which way CC 24's ``value`` says; in turns, but no hand turns within I_STROKE_JOIN."""
    if value < cc.ALTERNATE:
        i[at.I_STROKE_WAY] = FROM_BASS if value < cc.MIDDLE else FROM_TREBLE
    elif i[at.I_STROKE_WAY] == 0:
        i[at.I_STROKE_WAY] = FROM_BASS
    elif frame - i[at.I_STROKE] > i[at.I_STROKE_JOIN]:
        i[at.I_STROKE_WAY] = -i[at.I_STROKE_WAY]
    i[at.I_STROKE] = frame
    i[at.I_STROKE_FROM] = lowest if i[at.I_STROKE_WAY] == FROM_BASS else highest


@kernel
def plan_strum(d, i, frame):
    """X_LATE of each note of the chord: frames until the hand comes to it, or that it is not strummed."""
    value, lowest, highest = -1, at.ROW, -1
    for note in range(i[at.G_COUNT]):
        i[at.X_LATE + note] = _plucked_by(d, i, note)
        if i[at.X_LATE + note] == 0:
            value = direction(i, i[at.G_CHANNEL + note]) if value < 0 else value
            lowest, highest = min(lowest, i[at.G_STRING + note]), max(highest, i[at.G_STRING + note])
    if value < 0:
        return
    if not _joins(d, i, frame):
        _begin_stroke(i, frame, value, lowest, highest)
    for note in range(i[at.G_COUNT]):
        if i[at.X_LATE + note] >= 0:
            i[at.X_LATE + note] = _comes(d, i, note) - frame


@kernel
def end_of_stroke(i, s, frame):
    """When a note whose key comes up at ``frame`` ends: then, or, where the hand came late, not before it has sounded
    as long as its key was down, up to I_STROKE_HOLD."""
    late = i[at.S_LATE + s]
    if late == 0:
        return frame
    began = i[at.L_FRAME + i[at.S_SEQ + s] % at.LOG_CAPACITY]
    return max(frame, began + late + min(frame - began, i[at.I_STROKE_HOLD]))
