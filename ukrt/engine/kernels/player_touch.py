"""Harmonics and muting: what touches a string while it is plucked, and where the left hand then stops it.

Enter a note and its channel's controllers; leave the pitch the string is to be stopped at, and touches on the timeline.
"""

from ukrt.engine import gestures as do
from ukrt.engine import player_layout as at
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.player_right_hand import muting
from ukrt.engine.kernels.player_strings import ask, ask_fully
from ukrt.engine.kernels.timeline import timeline_cancel

HIGHEST_PARTIAL = 5  # beyond it the nodes lie closer than a fingertip is wide


@kernel
def semitones(partial):
    """Semitones from a string's pitch to its partial 2 to 5, to the nearest."""
    if partial == 2:
        return 12
    if partial == 3:
        return 19
    return 24 if partial == 4 else 28


@kernel
def stopped_pitch(i, channel, key):
    """The pitch a string must be stopped at for a note, and which partial of it sounds (0: all of them).

    A harmonic is the lowest partial of an open string that has its pitch, else the octave of a stopped one.
    """
    if i[at.C_HARMONIC + channel] == 0:
        return key, 0
    for partial in range(2, HIGHEST_PARTIAL + 1):
        for s in range(i[at.I_STRINGS]):
            if i[at.I_OPEN + s] + semitones(partial) == key:
                return key - semitones(partial), partial
    return max(0, key - 12), 2


@kernel
def touch_string(d, i, s, frame, late, fret, channel, partial):
    """What touches the string from ``frame`` on, a node for a harmonic or the hand's edge, or that nothing does.

    A node is touched for as many frames longer as its pluck is ``late``.
    """
    timeline_cancel(d, i, s, do.TOUCH, frame)
    stopped = d[at.D_PLACES + s * at.FRET_ROW + fret] / d[at.D_LENGTH + s]
    touched = i[at.S_TOUCHED + s] >= 0 or i[at.S_PLANTED + s] >= frame
    muted, ramp = muting(i, channel), float(i[at.I_QUICK_RAMP])
    i[at.S_TOUCHED + s] = i[at.S_PLANTED + s] = -1
    i[at.S_MUTE + s] = muted
    if partial > 0:
        node = stopped + (1.0 - stopped) / partial
        ask_fully(d, i, frame, do.TOUCH, s, node, ramp, d[at.D_TOUCH], 0.0, 0.0)
        i[at.S_TOUCHED + s] = frame + late + i[at.I_LEAD] + i[at.I_TOUCH]
        ask(d, i, i[at.S_TOUCHED + s], do.TOUCH, s, 0.0, i[at.I_UNDAMP_RAMP])
    elif muted > 0:
        ask_fully(d, i, frame, do.TOUCH, s, at.MUTE_PLACE, ramp, d[at.D_MUTE + muted], 0.0, 0.0)
        i[at.S_TOUCHED + s] = at.UNTIL_DAMPED
    elif touched:
        ask(d, i, frame, do.TOUCH, s, 0.0, i[at.I_QUICK_RAMP])
