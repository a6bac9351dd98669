"""What hands begin to do to a string: pluck, press, hammer, lift, pull off, damp, slide, bend.

Enter gestures that are due; leave fingers, dampers and ramps under way, and notes of what is to be done about the
string's ports before the next sample (ramps.py does it). Energy enters a string only as the work of the pluck, of a
landing finger, of a shortened string or of a raised tension (ukrt/engine/README.md).
"""

import math

import numpy as np

from ukrt.engine import gestures as kinds
from ukrt.engine import layout as at
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.ports import port_motion
from ukrt.engine.kernels.sleep import wake_for_hands
from ukrt.engine.kernels.slide import begin_slide

SHORTEST_PLUCK = 2  # samples: what the hat that averages the force can resolve
MOST_SPEED = 20.0  # m/s of a finger that hammers, and
MOST_PULL = 100.0  # N of one that pulls off: beyond any hand, so that no gesture asks for the absurd (choices)
MOST_RESISTANCE = 100.0  # over the wave impedance, of a touch: as the preset's dampers may have
ONE_CONTACT = 3  # shedding level from which new fingers and dampers have one contact
RIGID_COMPLIANCE = 1e-9  # m/N in one step, of a rigid point that begins to let go: far stiffer than any string (choice)

# What is to be done about a string's ports before the next sample; bits of SI_CHANGED.
PORTS_CHANGED, LANDED, TOUCHED, RESISTANCE_CHANGED = 1, 2, 4, 8


@kernel
def move_row(d, s, source, target):
    """Take what belongs to contact ``source`` of string ``s`` to place ``target``."""
    for base in (at.FIN_Y, at.FIN_Z, at.FIN_Y1, at.FIN_Z1, at.FIN_A, at.FIN_B, at.FIN_G, at.LAND_Y, at.LAND_Z):
        d[base + target * at.LANES + s] = d[base + source * at.LANES + s]
        d[base + source * at.LANES + s] = 0.0


@kernel
def _contacts_to_set(d, i, table, count):
    """First and number of the ``count`` contacts of the preset that a new finger or damper gets.

    All, or from shedding level 3 on the one nearest the bridge: of a finger it is the one that sets the pitch.
    """
    if i[at.H_SHED] < ONE_CONTACT or count < 2:
        return 0, count
    best = 0
    for j in range(1, count):
        offset = d[at.CONTACTS + (table + j) * at.CONTACT_SIZE + at.C_OFFSET]
        if offset > d[at.CONTACTS + (table + best) * at.CONTACT_SIZE + at.C_OFFSET]:
            best = j
    return best, 1


@kernel
def _press(d, i, s, place, frames, speed):
    """The stopping finger comes down, at rest or with a speed [m/s] towards the soundboard."""
    own, own_i = at.STRING + s * at.STRING_D_SIZE, at.STRING_I + s * at.STRING_I_SIZE
    first, n_finger = _contacts_to_set(d, i, 0, i[at.H_FINGER])
    if i[own_i + at.SI_FINGER] > 0:
        remove_finger(d, i, s)
    for j in range(i[own_i + at.SI_DAMPER], 0, -1):
        move_row(d, s, j, j + n_finger)
    for j in range(n_finger):
        contact, row = at.CONTACTS + (first + j) * at.CONTACT_SIZE, (j + 1) * at.LANES + s
        d[at.FIN_A + row], d[at.FIN_B + row] = d[contact + at.C_A], d[contact + at.C_B]
        d[at.FIN_G + row] = d[contact + at.C_G]
        d[at.FIN_Y + row] = d[at.FIN_Z + row] = d[at.FIN_Y1 + row] = d[at.FIN_Z1 + row] = 0.0
    i[own_i + at.SI_FINGER], i[own_i + at.SI_FINGER_FROM] = n_finger, first
    d[own + at.S_FINGER_PLACE] = place
    i[own_i + at.SI_LAND_AT], i[own_i + at.SI_LAND_LENGTH] = 0, max(frames, 1)
    d[own + at.S_HAMMER] = min(max(speed, 0.0), MOST_SPEED)
    i[own_i + at.SI_MOVE_LENGTH] = 0
    i[own_i + at.SI_CHANGED] |= LANDED


@kernel
def catch_string(d, i, s):
    """Once its contacts are ports: the finger's spring is let go from where the string is, and as fast as it moves.

    A finger that hammers has its own speed instead, towards the soundboard (Y).
    """
    own, own_i = at.STRING + s * at.STRING_D_SIZE, at.STRING_I + s * at.STRING_I_SIZE
    for j in range(i[own_i + at.SI_FINGER]):
        for half in range(2):
            now, before = port_motion(d, i, s, j + 1, 4 * half)
            d[own + at.S_LAND_C + at.MAX_CONTACTS * half + j] = now
            d[own + at.S_LAND_V + at.MAX_CONTACTS * half + j] = now - before
        if d[own + at.S_HAMMER] > 0.0:
            d[own + at.S_LAND_V + j] = d[own + at.S_HAMMER] / d[at.METER + at.M_RATE]


@kernel
def _lift(d, i, s, frames, pull, angle):
    """The stopping finger begins to leave: gently, or drawing the string aside as far as the force ``pull`` would."""
    own, own_i = at.STRING + s * at.STRING_D_SIZE, at.STRING_I + s * at.STRING_I_SIZE
    place, length = d[own + at.S_FINGER_PLACE], d[own + at.S_LENGTH]
    tension = d[own + at.S_TENSION] * d[own + at.S_RATIO]
    way = min(max(pull, 0.0), MOST_PULL) * place * (length - place) / (tension * length)
    d[own + at.S_PULL_Y], d[own + at.S_PULL_Z] = way * math.cos(angle), way * math.sin(angle)
    i[own_i + at.SI_LIFT_AT], i[own_i + at.SI_LIFT_LENGTH] = 0, frames


@kernel
def pulls(d, s):
    """Whether the finger on string ``s`` that is about to leave draws it aside."""
    own = at.STRING + s * at.STRING_D_SIZE
    return d[own + at.S_PULL_Y] != 0.0 or d[own + at.S_PULL_Z] != 0.0


@kernel
def set_grip(d, i, s, grip):
    """Scale the finger's mass, damping and stiffness by ``grip``: only its compliance changes, energy leaves.

    A rigid point has no compliance to scale; it becomes the spring 1 / g.
    """
    own_i = at.STRING_I + s * at.STRING_I_SIZE
    for j in range(i[own_i + at.SI_FINGER]):
        compliance = d[at.CONTACTS + (i[own_i + at.SI_FINGER_FROM] + j) * at.CONTACT_SIZE + at.C_G]
        if compliance == 0.0:
            compliance = RIGID_COMPLIANCE
        d[at.FIN_G + (1 + j) * at.LANES + s] = compliance / grip


@kernel
def remove_finger(d, i, s):
    """The finger is gone; what energy it still holds goes with it."""
    own_i = at.STRING_I + s * at.STRING_I_SIZE
    n_finger = i[own_i + at.SI_FINGER]
    for j in range(1, n_finger + 1):
        move_row(d, s, j, 0)
    for j in range(1, i[own_i + at.SI_DAMPER] + 1):
        move_row(d, s, j + n_finger, j)
    i[own_i + at.SI_FINGER] = i[own_i + at.SI_LAND_LENGTH] = i[own_i + at.SI_MOVE_LENGTH] = 0
    i[own_i + at.SI_LIFT_LENGTH] = 0
    i[own_i + at.SI_CHANGED] = (i[own_i + at.SI_CHANGED] | PORTS_CHANGED) & ~LANDED


@kernel
def set_damper(d, i, s, level):
    """Give the damping finger ``level`` of its resistance, a touch ``level`` wave impedances: g = 2 dt / c."""
    own, own_i = at.STRING + s * at.STRING_D_SIZE, at.STRING_I + s * at.STRING_I_SIZE
    d[own + at.S_DAMP_LEVEL] = level
    for j in range(i[own_i + at.SI_DAMPER]):
        contact = at.CONTACTS + (at.MAX_CONTACTS + i[own_i + at.SI_DAMPER_FROM] + j) * at.CONTACT_SIZE
        ratio = d[contact + at.C_DAMPER] if d[own + at.S_TOUCH_PLACE] == 0.0 else 1.0
        resistance = max(level, 1e-4) * ratio * d[own + at.S_IMPEDANCE]
        d[at.FIN_G + (1 + i[own_i + at.SI_FINGER] + j) * at.LANES + s] = 2.0 / (d[at.METER + at.M_RATE] * resistance)


@kernel
def remove_damper(d, i, s):
    """The damping finger, or what touches in its stead, is gone."""
    own, own_i = at.STRING + s * at.STRING_D_SIZE, at.STRING_I + s * at.STRING_I_SIZE
    for j in range(i[own_i + at.SI_DAMPER]):
        move_row(d, s, 1 + i[own_i + at.SI_FINGER] + j, 0)
    i[own_i + at.SI_DAMPER] = i[own_i + at.SI_DAMP_LENGTH] = 0
    d[own + at.S_DAMP_LEVEL] = d[own + at.S_TOUCH_PLACE] = 0.0
    i[own_i + at.SI_CHANGED] = (i[own_i + at.SI_CHANGED] | PORTS_CHANGED) & ~TOUCHED


@kernel
def _come_down(d, i, s, contact, n_damper):
    """Dampers come to a string that has none, without resistance as yet."""
    own_i = at.STRING_I + s * at.STRING_I_SIZE
    first = 1 + i[own_i + at.SI_FINGER]
    i[own_i + at.SI_DAMPER], i[own_i + at.SI_DAMPER_FROM] = n_damper, contact
    set_damper(d, i, s, 0.0)
    for j in range(first, first + n_damper):
        row = j * at.LANES + s
        d[at.FIN_A + row], d[at.FIN_B + row] = 0.0, 1.0
        d[at.LAND_Y + row] = d[at.LAND_Z + row] = 0.0
    i[own_i + at.SI_CHANGED] |= TOUCHED


@kernel
def _bear(d, i, s, level, frames):
    """What damps the string moves towards ``level`` of its resistance."""
    own, own_i = at.STRING + s * at.STRING_D_SIZE, at.STRING_I + s * at.STRING_I_SIZE
    d[own + at.S_DAMP_FROM], d[own + at.S_DAMP_TO] = d[own + at.S_DAMP_LEVEL], level
    i[own_i + at.SI_DAMP_AT], i[own_i + at.SI_DAMP_LENGTH] = 0, max(frames, 1)


@kernel
def _damp(d, i, s, level, frames):
    """The damping finger moves towards ``level`` of its resistance; if it was not there it comes, a touch then goes.

    A touch that has come in its stead stays when the damping finger is asked to leave: it has left already.
    """
    own, own_i = at.STRING + s * at.STRING_D_SIZE, at.STRING_I + s * at.STRING_I_SIZE
    if d[own + at.S_TOUCH_PLACE] > 0.0 and i[at.H_DAMPER] > 0:
        if level <= 0.0:
            return
        remove_damper(d, i, s)
    if i[own_i + at.SI_DAMPER] == 0:
        if level <= 0.0 or i[at.H_DAMPER] == 0:
            return
        contact, n_damper = _contacts_to_set(d, i, at.MAX_CONTACTS, i[at.H_DAMPER])
        _come_down(d, i, s, contact, n_damper)
    _bear(d, i, s, level, frames)


@kernel
def _touch(d, i, s, place, resistance, frames):
    """A finger or the hand's edge damps the string at ``place`` (share of L), or leaves it; the damper gives way to it.

    Where the finger has every contact that a string may have there is no room for a touch: it is counted as dropped.
    """
    own, own_i = at.STRING + s * at.STRING_D_SIZE, at.STRING_I + s * at.STRING_I_SIZE
    if resistance <= 0.0:
        if d[own + at.S_TOUCH_PLACE] > 0.0:
            _bear(d, i, s, 0.0, frames)
        return
    if i[at.H_FINGER] >= at.MAX_CONTACTS:
        i[at.H_GESTURES_DROPPED] += 1
        return
    place = min(max(place, 0.01), 0.99)
    if i[own_i + at.SI_DAMPER] > 0 and d[own + at.S_TOUCH_PLACE] != place:
        remove_damper(d, i, s)
    if i[own_i + at.SI_DAMPER] == 0:
        d[own + at.S_TOUCH_PLACE] = place
        _come_down(d, i, s, np.int64(0), np.int64(1))
    _bear(d, i, s, min(resistance, MOST_RESISTANCE), frames)


@kernel
def follow_string(d, i, s):
    """Once its places are ports: the damping finger starts where the string is, so that nothing is stretched."""
    own_i = at.STRING_I + s * at.STRING_I_SIZE
    first = 1 + i[own_i + at.SI_FINGER]
    for j in range(first, first + i[own_i + at.SI_DAMPER]):
        row = j * at.LANES + s
        d[at.FIN_Y + row], d[at.FIN_Y1 + row] = port_motion(d, i, s, j, 0)
        d[at.FIN_Z + row], d[at.FIN_Z1 + row] = port_motion(d, i, s, j, 4)


@kernel
def _pluck(d, i, s, place, force, angle, frames):
    """Begin a force ramp at ``place`` (share of L); one that still runs on this string ends as it is let go."""
    own, own_i = at.STRING + s * at.STRING_D_SIZE, at.STRING_I + s * at.STRING_I_SIZE
    d[own + at.S_PLUCK_PLACE] = min(max(place, 0.01), 0.99) * d[own + at.S_LENGTH]
    d[own + at.S_PLUCK_FY], d[own + at.S_PLUCK_FZ] = force * math.cos(angle), force * math.sin(angle)
    i[own_i + at.SI_PLUCK], i[own_i + at.SI_PLUCK_AT] = 1, 0
    i[own_i + at.SI_PLUCK_LENGTH] = max(frames, SHORTEST_PLUCK)
    i[own_i + at.SI_PLUCK_RELEASE], i[own_i + at.SI_PLUCK_SMOOTH] = i[own_i + at.SI_RELEASE], i[at.H_SMOOTH]
    i[own_i + at.SI_CHANGED] |= PORTS_CHANGED


@kernel
def perform(d, i, kind, s, p0, p1, p2, p3):
    """Begin one gesture on string ``s`` (see gestures.py for the parameters); it acts from the next sample on."""
    if s < 0 or s >= i[at.H_STRINGS]:
        i[at.H_GESTURES_DROPPED] += 1
        return
    own, own_i = at.STRING + s * at.STRING_D_SIZE, at.STRING_I + s * at.STRING_I_SIZE
    if i[at.H_SHED] > 0:
        wake_for_hands(d, i, kind, s)
    frames = int(max(p1, 1.0))
    if kind == kinds.PLUCK:
        _pluck(d, i, s, p0, p1, p2, int(max(p3, 1.0)))
    elif kind == kinds.PRESS or kind == kinds.MOVE:
        hammers = kind == kinds.PRESS and p2 > 0.0
        if i[own_i + at.SI_FINGER] > 0 and i[own_i + at.SI_LIFT_LENGTH] == 0 and not hammers:
            begin_slide(d, i, s, p0, frames)
        elif kind == kinds.PRESS and i[at.H_FINGER] > 0:
            _press(d, i, s, p0, frames, p2)
    elif kind == kinds.LIFT:
        if i[own_i + at.SI_FINGER] > 0 and i[own_i + at.SI_LIFT_LENGTH] == 0:
            _lift(d, i, s, frames, p2, p3)
    elif kind == kinds.DAMP:
        _damp(d, i, s, min(max(p0, 0.0), 1.0), frames)
    elif kind == kinds.UNDAMP:
        _damp(d, i, s, 0.0, frames)
    elif kind == kinds.TOUCH:
        _touch(d, i, s, p0, p2, frames)
    elif kind == kinds.RELEASE:
        i[own_i + at.SI_RELEASE] = frames if frames > 1 else 0
    elif kind == kinds.TENSION:
        d[own + at.S_RATIO_FROM], d[own + at.S_RATIO_TO] = d[own + at.S_RATIO], min(max(p0, 0.25), 4.0)
        i[own_i + at.SI_TENSION_AT], i[own_i + at.SI_TENSION_LENGTH] = 0, frames
        i[own_i + at.SI_TENSION_STRAIGHT] = 1 if p2 > 0.0 else 0
    i[at.H_GESTURES_DONE] += 1
    i[at.H_BUSY] = 1
