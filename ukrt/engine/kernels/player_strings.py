"""One string in the player's hands: starting a note on it, ending one, and its tension, as gestures on the timeline.

The player remembers what it has asked for (S_FINGER, S_DAMP, S_LIFT, S_UNDAMP); whether a gesture has been carried out
it learns by cancelling it: a gesture that can no longer be cancelled has happened.
"""

from ukrt.engine import gestures as do
from ukrt.engine import player_layout as at
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.player_log import count
from ukrt.engine.kernels.timeline import timeline_add, timeline_cancel


@kernel
def ask(d, i, frame, kind, s, p0, p1):
    """Put a gesture on the timeline; a refusal (the timeline is full) is counted."""
    if timeline_add(d, i, frame, kind, s, float(p0), float(p1), 0.0, 0.0, 0.0) == 0:
        count(i, at.GESTURES_REFUSED)


@kernel
def _cancel_ending(d, i, s, frame):
    """Cancel what is left of the string's damping from ``frame`` on and note what has happened of it.

    Returns 2 if the damper is on the string, 1 if it is just leaving it, 0 if it is off.
    """
    down = timeline_cancel(d, i, s, do.DAMP, frame) == 0 and i[at.S_DAMP + s] >= 0
    up = timeline_cancel(d, i, s, do.UNDAMP, frame) == 0 and i[at.S_UNDAMP + s] >= 0
    if timeline_cancel(d, i, s, do.LIFT, frame) == 0 and i[at.S_LIFT + s] >= 0:
        i[at.S_FINGER + s] = 0
    leaving = up and i[at.S_UNDAMP + s] + i[at.I_UNDAMP_RAMP] > frame
    i[at.S_DAMP + s] = i[at.S_DAMP + s] if down and not up else -1
    i[at.S_LIFT + s], i[at.S_UNDAMP + s] = -1, -1
    if down and not up:
        return 2
    return 1 if leaving else 0


@kernel
def set_tension(d, i, s, frame, ratio, ramp):
    """Bring the tension of a string to ``ratio`` at ``frame``, in place of anything asked for that time or later."""
    waiting = timeline_cancel(d, i, s, do.TENSION, frame)
    if waiting > 0 or d[at.D_TENSION + s] != ratio:
        ask(d, i, frame, do.TENSION, s, ratio, ramp)
        count(i, at.TENSION_GESTURES)
        d[at.D_TENSION + s] = ratio
        i[at.S_TENSION_FRAME + s] = frame


@kernel
def bend_string(d, i, s, frame, ratio):
    """Follow a pitch bend on a sounding string: one gesture per slot of time at most, the latest target wins."""
    if d[at.D_TENSION + s] == ratio:
        return
    time = frame + i[at.I_LEAD]
    last = i[at.S_TENSION_FRAME + s]
    if time - last < i[at.I_BEND_SLOT]:
        time = last if last > frame else last + i[at.I_BEND_SLOT]
    set_tension(d, i, s, time, ratio, i[at.I_BEND_RAMP])


@kernel
def _press(d, i, s):
    """Ask for the finger to land at its fret, when the string's S_PRESS says."""
    place = d[at.D_PLACES + s * at.FRET_ROW + i[at.S_FINGER + s]]
    ask(d, i, i[at.S_PRESS + s], do.PRESS, s, place, i[at.I_LANDING])


@kernel
def start_note(d, i, s, frame, pitch, force, seq, ratio):
    """Damper off, finger to its fret (or off), tension as the channel's bend has it, and the pluck that begins now."""
    fret = pitch - i[at.I_OPEN + s]
    if _cancel_ending(d, i, s, frame) > 0:
        ask(d, i, frame, do.UNDAMP, s, 0.0, i[at.I_QUICK_RAMP])
    i[at.S_DAMP + s] = -1
    finger, landing = i[at.S_FINGER + s], 0
    if timeline_cancel(d, i, s, do.PRESS, frame) > 0:  # it was still in the air, on its way from another fret
        finger, landing = 0, i[at.I_LIFT_RAMP]
    if finger > 0 and finger != fret:
        ask(d, i, frame, do.LIFT, s, 0.0, i[at.I_LIFT_RAMP])
        landing = i[at.I_LIFT_RAMP]
    i[at.S_FINGER + s] = fret
    if fret > 0 and finger != fret:
        i[at.S_PRESS + s] = frame + landing
        _press(d, i, s)
    set_tension(d, i, s, frame, ratio, i[at.I_BEND_RAMP])
    ramp = float(i[at.I_LEAD])
    if timeline_add(d, i, frame, do.PLUCK, s, d[at.D_PLUCK_PLACE], force, d[at.D_PLUCK_ANGLE], ramp, float(seq)) == 0:
        count(i, at.GESTURES_REFUSED)
    i[at.I_PLUCKS] += 1
    i[at.S_ORDER + s] = i[at.I_PLUCKS]


@kernel
def withdraw_note(d, i, s, frame):
    """Take back every gesture but tension that a note starting at ``frame`` has put on the timeline, from there on."""
    for kind in (do.PLUCK, do.PRESS, do.LIFT, do.DAMP, do.UNDAMP):
        timeline_cancel(d, i, s, kind, frame)


@kernel
def restore_ending(d, i, s, frame):
    """Put the string's remembered landing and damping back on the timeline, what lies at ``frame`` or later."""
    if i[at.S_DAMP + s] >= frame:
        ask(d, i, i[at.S_DAMP + s], do.DAMP, s, 1.0, i[at.I_DAMP_RAMP])
    if i[at.S_PRESS + s] >= frame and i[at.S_FINGER + s] > 0:
        _press(d, i, s)
    if i[at.S_LIFT + s] >= frame:
        ask(d, i, i[at.S_LIFT + s], do.LIFT, s, 0.0, i[at.I_LIFT_RAMP])
    if i[at.S_UNDAMP + s] >= frame:
        ask(d, i, i[at.S_UNDAMP + s], do.UNDAMP, s, 0.0, i[at.I_UNDAMP_RAMP])


@kernel
def damp_string(d, i, s, now, frame, ramp):
    """The damper comes down at ``frame`` (``now`` or later); when the string is at rest the finger lifts, then, where
    strings idle open, the damper."""
    on = _cancel_ending(d, i, s, now + 1) == 2
    lifting = frame + i[at.I_SETTLE]
    if not on:
        ask(d, i, frame, do.DAMP, s, 1.0, ramp)
        i[at.S_DAMP + s] = frame
    i[at.S_STATE + s] = at.DAMPING
    if i[at.S_FINGER + s] > 0:
        ask(d, i, lifting, do.LIFT, s, 0.0, i[at.I_LIFT_RAMP])
        i[at.S_LIFT + s] = lifting
    if i[at.I_DAMPED_IDLE] == 0:
        i[at.S_UNDAMP + s] = lifting + i[at.I_GAP]
        ask(d, i, i[at.S_UNDAMP + s], do.UNDAMP, s, 0.0, i[at.I_UNDAMP_RAMP])
    set_tension(d, i, s, lifting, 1.0, i[at.I_BEND_RAMP])


@kernel
def settle_string(i, s, frame):
    """A damped string whose finger (and damper, where strings idle open) have left it is idle from ``frame`` on."""
    if i[at.S_STATE + s] != at.DAMPING:
        return
    last = max(i[at.S_DAMP + s], max(i[at.S_LIFT + s], i[at.S_UNDAMP + s]))
    if last < frame:
        i[at.S_STATE + s] = at.IDLE
