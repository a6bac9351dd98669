"""One string in the player's hands: starting a note on it, ending one, and its tension, as gestures on the timeline.

The player remembers what it has asked for (S_FINGER, S_DAMP, S_LIFT, S_UNDAMP); whether a gesture has been carried out
it learns by cancelling it: a gesture that can no longer be cancelled has happened.
"""

from ukrt.engine import gestures as do
from ukrt.engine import player_layout as at
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.player_log import count
from ukrt.engine.kernels.player_zones import bend_cents, share_kept
from ukrt.engine.kernels.timeline import timeline_add, timeline_cancel


@kernel
def ask_fully(d, i, frame, kind, s, p0, p1, p2, p3, p4):
    """Put a gesture on the timeline; a refusal (the timeline is full) is counted."""
    if timeline_add(d, i, frame, kind, s, p0, p1, p2, p3, p4) == 0:
        count(i, at.GESTURES_REFUSED)


@kernel
def ask(d, i, frame, kind, s, p0, p1):
    """A gesture of which nothing more need be said."""
    ask_fully(d, i, frame, kind, s, float(p0), float(p1), 0.0, 0.0, 0.0)


@kernel
def _cancel_ending(d, i, s, frame):
    """Cancel what is left of the string's damping from ``frame`` on and note what has happened of it.

    Returns 2 if the damper is on the string, 1 if it is just leaving it, 0 if it is off.
    """
    down = timeline_cancel(d, i, s, do.DAMP, frame) == 0 and i[at.S_DAMP + s] >= 0
    up = timeline_cancel(d, i, s, do.UNDAMP, frame) == 0 and i[at.S_UNDAMP + s] >= 0
    lifts = timeline_cancel(d, i, s, do.LIFT, frame)
    if lifts == 0 and (i[at.S_LIFT + s] >= 0 or i[at.S_LOOSE + s] > 0):
        i[at.S_FINGER + s] = 0
    i[at.S_LOOSE + s] = 0
    leaving = up and i[at.S_UNDAMP + s] + i[at.I_UNDAMP_RAMP] > frame
    i[at.S_DAMP + s] = i[at.S_DAMP + s] if down and not up else -1
    i[at.S_LIFT + s], i[at.S_UNDAMP + s] = -1, -1
    if down and not up:
        return 2
    return 1 if leaving else 0


@kernel
def set_tension(d, i, s, frame, ratio, ramp, straight):
    """Bring the tension of a string to ``ratio`` at ``frame``, in place of anything asked for that time or later."""
    waiting = timeline_cancel(d, i, s, do.TENSION, frame)
    if waiting > 0 or d[at.D_TENSION + s] != ratio:
        ask_fully(d, i, frame, do.TENSION, s, ratio, float(ramp), straight, 0.0, 0.0)
        count(i, at.TENSION_GESTURES)
        d[at.D_TENSION + s] = ratio
        i[at.S_TENSION_FRAME + s] = frame


@kernel
def note_cents(d, i, s, channel):
    """How far the note on string ``s`` is to sound from what its fret gives [cents]."""
    master = (i[at.I_MASTER_FINE] - at.MIDDLE_FINE) * at.FINE_UNITS
    return bend_cents(d, i, channel) + (i[at.S_TUNED + s] + master) / at.TUNING_UNIT


@kernel
def rest_ratio(i):
    """The tension ratio of a string without a note: the whole guitar's fine tuning."""
    return 2.0 ** ((i[at.I_MASTER_FINE] - at.MIDDLE_FINE) * at.FINE_UNITS / at.TUNING_UNIT / 600.0)


@kernel
def note_ratio(d, i, s, channel):
    """The tension ratio that takes a note of this channel there, which begins on string ``s``."""
    return _ratio(note_cents(d, i, s, channel))


@kernel
def string_ratio(d, i, s):
    """The tension ratio that the note on string ``s`` wants."""
    return _ratio(note_cents(d, i, s, i[at.S_CHANNEL + s]) + share_kept(i, s))


@kernel
def _ratio(cents):
    """Frequency goes with the root of the tension; an octave either way is the most."""
    return 2.0 ** (max(-at.MAX_BEND_CENTS, min(at.MAX_BEND_CENTS, cents)) / 600.0)


@kernel
def bend_string(d, i, s, frame, ratio):
    """Follow a pitch bend on a sounding string: one gesture per slot of time at most, the latest target wins.

    A string in vibrato follows with the vibrato's next gesture.
    """
    if d[at.D_TENSION + s] == ratio or d[at.D_DEPTH + s] > 0.0:
        return
    time = frame + i[at.I_LEAD]
    last = i[at.S_TENSION_FRAME + s]
    if time - last < i[at.I_BEND_SLOT]:
        time = last if last > frame else last + i[at.I_BEND_SLOT]
    set_tension(d, i, s, time, ratio, i[at.I_BEND_RAMP], 0.0)


@kernel
def press_string(d, i, s, frame):
    """Ask for the finger to come to its fret, when and how the string's S_PRESS, S_LANDING and S_SPEED say.

    Of a glissando over frets (S_STEP) the frets that are reached at ``frame`` or later.
    """
    landing, speed = float(i[at.S_LANDING + s]), 1e-6 * i[at.S_SPEED + s]
    last, time, step = i[at.S_FINGER + s], i[at.S_PRESS + s], i[at.S_STEP + s]
    fret, way = last, 0
    if step > 0:
        way = 1 if last > i[at.S_STAYS + s] else -1
        fret = i[at.S_STAYS + s] + way
    while True:
        if time >= frame:
            place = d[at.D_PLACES + s * at.FRET_ROW + fret]
            ask_fully(d, i, time, do.PRESS, s, place, landing, speed, 0.0, 0.0)
        if fret == last:
            return
        fret, time = fret + way, time + step


@kernel
def fret_reached(i, s, frame):
    """Where the finger of a glissando over frets is just before ``frame``."""
    first, last, begun = i[at.S_STAYS + s], i[at.S_FINGER + s], i[at.S_PRESS + s]
    if frame <= begun:
        return first
    steps = min(abs(last - first), (frame - 1 - begun) // i[at.S_STEP + s] + 1)
    return first + steps if last > first else first - steps


@kernel
def pull_string(d, i, s, force):
    """Ask for the finger to pull off at S_PULLED, as hard as goes with a pluck of ``force`` [N]."""
    pull = force / d[at.D_FORCE + 127] * d[at.D_PULL_FORCE]
    ask_fully(d, i, i[at.S_PULLED + s], do.LIFT, s, 0.0, float(i[at.I_LEAD]), pull, d[at.D_PULL_ANGLE], 0.0)


@kernel
def free_string(d, i, s, frame):
    """The damper off a string that is to sound, what is left of its damping cancelled.

    Returns
    -------
    finger, delay : int
        The fret of the finger that is on the string (0: none), and frames until one that was on its way to another
        fret has left; it does not land any more.
    """
    if _cancel_ending(d, i, s, frame) > 0:
        ask(d, i, frame, do.UNDAMP, s, 0.0, i[at.I_QUICK_RAMP])
    i[at.S_DAMP + s] = -1
    waiting = timeline_cancel(d, i, s, do.PRESS, frame)
    if i[at.S_PULLED + s] >= frame:
        i[at.S_PULLED + s] = -1
        return i[at.S_PULLED_FROM + s], 0
    if waiting == 0:
        return i[at.S_FINGER + s], 0
    if i[at.S_STEP + s] > 0:
        reached, i[at.S_STEP + s] = fret_reached(i, s, frame), 0
        return reached, 0
    stays = i[at.S_STAYS + s]
    return stays, (0 if stays > 0 else i[at.I_LIFT_RAMP])


@kernel
def mark_begun(i, s):
    """A note has begun on string ``s``, after all others."""
    i[at.S_PRESSURE + s] = i[at.S_LET + s] = 0
    i[at.S_DAMPS + s], i[at.S_EASED + s], i[at.S_RESUMED + s] = i[at.I_DAMP_RAMP], -1, -1
    i[at.I_PLUCKS] += 1
    i[at.S_ORDER + s] = i[at.I_PLUCKS]


@kernel
def start_note(d, i, s, frame, fret, channel):
    """The left hand's part of a note: damper off, finger to its fret (or off), tension as the note's bend has it."""
    finger, landing = free_string(d, i, s, frame)
    if finger > 0 and finger != fret:
        ask(d, i, frame, do.LIFT, s, 0.0, i[at.I_LIFT_RAMP])
        landing = i[at.I_LIFT_RAMP]
    i[at.S_FINGER + s] = fret
    if fret > 0 and finger != fret:
        i[at.S_PRESS + s], i[at.S_LANDING + s] = frame + landing, i[at.I_LANDING]
        i[at.S_STAYS + s] = i[at.S_SPEED + s] = i[at.S_STEP + s] = 0
        press_string(d, i, s, frame)
    set_tension(d, i, s, frame, note_ratio(d, i, s, channel), i[at.I_BEND_RAMP], 0.0)
    d[at.D_DEPTH + s] = d[at.D_PHASE + s] = 0.0
    mark_begun(i, s)


@kernel
def ask_pluck(d, i, s):
    """Ask for the pluck that the string's S_PLUCK, S_PULL and D_PLUCKED_* describe."""
    place, force, angle = d[at.D_PLUCKED_PLACE + s], d[at.D_PLUCKED_FORCE + s], d[at.D_PLUCKED_ANGLE + s]
    seq = float(i[at.S_SEQ + s])
    ask_fully(d, i, i[at.S_PLUCK + s], do.PLUCK, s, place, force, angle, float(i[at.S_PULL + s]), seq)


@kernel
def drop_pluck(d, i, s, frame):
    """The hand does not come to the string any more if it has not begun to pluck it; returns whether it had yet to."""
    i[at.S_LATE + s] = 0
    if timeline_cancel(d, i, s, do.PLUCK, frame) == 0:
        return False
    i[at.S_PLUCK + s] = -1
    return True


@kernel
def withdraw_note(d, i, s, frame):
    """Take back every gesture but tension that a note starting at ``frame`` has put on the timeline, from there on."""
    for kind in (do.PLUCK, do.PRESS, do.LIFT, do.DAMP, do.UNDAMP, do.TOUCH, do.RELEASE):
        timeline_cancel(d, i, s, kind, frame)


@kernel
def restore_ending(d, i, s, frame):
    """Put the string's remembered landing, pluck and damping back on the timeline, what lies at ``frame`` or later."""
    if i[at.S_PLUCK + s] >= frame:
        ask_pluck(d, i, s)
    if i[at.S_PLANTED + s] >= frame:
        ask(d, i, i[at.S_PLANTED + s], do.TOUCH, s, 0.0, i[at.I_QUICK_RAMP])
    if i[at.S_DAMP + s] >= frame:
        ask(d, i, i[at.S_DAMP + s], do.DAMP, s, 1.0, i[at.S_DAMPS + s])
    if i[at.S_PULLED + s] >= frame:
        pull_string(d, i, s, d[at.D_LOG_FORCE + i[at.S_SEQ + s] % at.LOG_CAPACITY])
    if i[at.S_FINGER + s] > 0:
        press_string(d, i, s, frame)
    if i[at.S_LIFT + s] >= frame:
        ask(d, i, i[at.S_LIFT + s], do.LIFT, s, 0.0, i[at.I_LIFT_RAMP])
    if frame <= i[at.S_TOUCHED + s] < at.UNTIL_DAMPED:
        ask(d, i, i[at.S_TOUCHED + s], do.TOUCH, s, 0.0, i[at.I_UNDAMP_RAMP])
    if i[at.S_UNDAMP + s] >= frame:
        ask(d, i, i[at.S_UNDAMP + s], do.UNDAMP, s, 0.0, i[at.I_UNDAMP_RAMP])


@kernel
def damp_string(d, i, s, now, frame, ramp):
    """The damper comes down at ``frame`` (``now`` or later); when the string is at rest the finger lifts, then, where
    strings idle open, the damper."""
    on = _cancel_ending(d, i, s, now + 1) == 2
    if i[at.S_TOUCHED + s] >= 0:  # a planted finger leaves when it plucks
        timeline_cancel(d, i, s, do.TOUCH, now + 1)
    i[at.S_TOUCHED + s] = i[at.S_EASED + s] = -1  # the damper comes in its place
    lifting = frame + i[at.I_SETTLE] + max(0, ramp - i[at.I_DAMP_RAMP])
    if i[at.S_STEP + s] > 0 and timeline_cancel(d, i, s, do.PRESS, now + 1) > 0:
        i[at.S_FINGER + s] = fret_reached(i, s, now + 1)
    i[at.S_STEP + s] = 0
    if not on:
        i[at.S_DAMPS + s] = ramp
        ask(d, i, frame, do.DAMP, s, 1.0, ramp)
        i[at.S_DAMP + s] = frame
    i[at.S_STATE + s] = at.DAMPING
    if i[at.S_FINGER + s] > 0:
        ask(d, i, lifting, do.LIFT, s, 0.0, i[at.I_LIFT_RAMP])
        i[at.S_LIFT + s] = lifting
    if i[at.I_DAMPED_IDLE] == 0:
        i[at.S_UNDAMP + s] = lifting + i[at.I_GAP]
        ask(d, i, i[at.S_UNDAMP + s], do.UNDAMP, s, 0.0, i[at.I_UNDAMP_RAMP])
    set_tension(d, i, s, lifting, rest_ratio(i), i[at.I_BEND_RAMP], 0.0)


@kernel
def settle_string(i, s, frame):
    """A damped string whose finger (and damper, where strings idle open) have left it is idle from ``frame`` on."""
    if i[at.S_STATE + s] != at.DAMPING:
        return
    last = max(i[at.S_DAMP + s], max(i[at.S_LIFT + s], i[at.S_UNDAMP + s]))
    if last < frame:
        i[at.S_STATE + s] = at.IDLE
