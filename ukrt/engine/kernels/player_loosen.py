"""What touches a sounding string, as its channel's controllers change: the hand's edge (CC19), and the left hand's own
finger, half lifted (CC27): it presses no more, but its flesh still lies on the string behind the fret and damps it.

Enter a channel's controllers; leave touches on the strings that sound, LEAD frames later as all is, and fingers that
lift or come down again. One touch has room on a string: the half-lifted finger goes before the hand's edge.
"""

from ukrt.engine import gestures as do
from ukrt.engine import player_layout as at
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.player_right_hand import muting
from ukrt.engine.kernels.player_strings import ask, ask_fully, press_string
from ukrt.engine.kernels.timeline import timeline_cancel


@kernel
def _ask_touch(d, i, s, time):
    """What S_MUTE and S_LOOSE say, from ``time`` on."""
    place, resistance = at.MUTE_PLACE, d[at.D_MUTE + i[at.S_MUTE + s]]
    if i[at.S_LOOSE + s] > 0:
        fret = d[at.D_PLACES + s * at.FRET_ROW + i[at.S_FINGER + s]]
        place, resistance = (fret + at.LOOSE_OFFSET) / d[at.D_LENGTH + s], d[at.D_LOOSE + i[at.S_LOOSE + s]]
    ask_fully(d, i, time, do.TOUCH, s, place, float(i[at.I_EASE_RAMP]), resistance, 0.0, 0.0)
    i[at.S_TOUCHED + s] = at.UNTIL_DAMPED


@kernel
def _when(i, s, frame):
    """LEAD frames after ``frame``, behind the finger's landing and a node's touch, and one touch in a slot of time."""
    time = frame + i[at.I_LEAD]
    if i[at.S_TOUCHED + s] < at.UNTIL_DAMPED:
        time = max(time, i[at.S_TOUCHED + s] + i[at.I_UNDAMP_RAMP] + 1)
    last = i[at.S_EASED + s]
    if last >= 0 and time - last < i[at.I_BEND_SLOT]:
        time = last if last > frame else last + i[at.I_BEND_SLOT]
    return max(time, max(i[at.S_PRESS + s] + 1, i[at.S_PLUCK + s] + i[at.S_PULL + s]))


@kernel
def follow_touch(d, i, s, frame):
    """Bring what touches a sounding string to what its channel's controllers say now."""
    channel, before = i[at.S_CHANNEL + s], i[at.S_LOOSE + s]
    loose = i[at.C_LOOSE + channel] if i[at.S_FINGER + s] > 0 else 0
    mute = muting(i, channel)
    if i[at.S_MUTE + s] == mute and before == loose:
        return
    time = _when(i, s, frame)
    i[at.S_MUTE + s], i[at.S_LOOSE + s], i[at.S_EASED + s] = mute, loose, time
    timeline_cancel(d, i, s, do.TOUCH, time)
    _ask_touch(d, i, s, time)
    if (loose > 0) != (before > 0):
        _move_finger(d, i, s, frame)


@kernel
def _move_finger(d, i, s, frame):
    """The finger lifts, or comes down again, at S_EASED; a glissando goes no further.

    One that has not lifted yet does not: it stays, or goes on to its fret.
    """
    time = i[at.S_EASED + s]
    is_down = timeline_cancel(d, i, s, do.LIFT, frame + 1) > 0
    timeline_cancel(d, i, s, do.PRESS, time)
    i[at.S_STEP + s] = 0
    if i[at.S_LOOSE + s] > 0:
        ask(d, i, time, do.LIFT, s, 0.0, i[at.I_EASE_RAMP])
        return
    i[at.S_PRESS + s], i[at.S_LANDING + s] = time, i[at.I_LANDING]
    i[at.S_STAYS + s], i[at.S_SPEED + s] = i[at.S_FINGER + s] if is_down else 0, 0
    press_string(d, i, s, time)


@kernel
def follow_touches(d, i, frame):
    """Likewise for all strings that sound."""
    for s in range(i[at.I_STRINGS]):
        if i[at.S_STATE + s] == at.HELD or i[at.S_STATE + s] == at.PEDALLED:
            follow_touch(d, i, s, frame)


@kernel
def leave_touch(d, i, s, frame):
    """The half-lifted finger of a note that is slurred at ``frame`` goes away; the hand's edge takes its place."""
    timeline_cancel(d, i, s, do.TOUCH, frame)
    i[at.S_EASED + s] = frame + i[at.I_LEAD]
    _ask_touch(d, i, s, i[at.S_EASED + s])


@kernel
def restore_touch(d, i, s, frame):
    """Put back on the timeline what was asked for and lies at ``frame`` or later."""
    if i[at.S_EASED + s] < frame:
        return
    _ask_touch(d, i, s, i[at.S_EASED + s])
    if i[at.S_LOOSE + s] > 0:
        ask(d, i, i[at.S_EASED + s], do.LIFT, s, 0.0, i[at.I_EASE_RAMP])
