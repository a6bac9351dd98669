"""What hands have begun goes on, sample by sample: pluck ramps, landings, lifts, dampers, slides and bends.

Enter strings with something under way; leave forces, offsets, coefficients and ports for the next sample.
"""

import math

from ukrt.engine import layout as at
from ukrt.engine.kernels.hands import (
    LANDED,
    PORTS_CHANGED,
    RESISTANCE_CHANGED,
    TOUCHED,
    catch_string,
    follow_string,
    pulls,
    remove_damper,
    remove_finger,
    set_damper,
    set_grip,
)
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.modes import tune_string
from ukrt.engine.kernels.ports import count_contacts, invert_ports, refit_string
from ukrt.engine.kernels.slide import follow_slide

# Chosen: finer steps cost more and change nothing that the tests of energy and of clicks can see.
DAMP_EVERY = 8  # samples between two steps of a damper's ramp
TOUCH_EVERY = 2  # of a touch's, which comes in a quarter of the time to a string that is to sound on
BEND_EVERY = 32  # samples between two steps of the tension
LIFT_EVERY = 4  # samples between two steps of a finger's grip
LEAST_GRIP = 1e-4  # of its mass, damping and stiffness that a finger still has when it lets go


@kernel
def _mark_busy(i):
    """Note whether any string has a ramp under way (HEAD's busy flag), so that quiet samples skip all of this."""
    busy = 0
    for s in range(i[at.H_STRINGS]):
        own_i = at.STRING_I + s * at.STRING_I_SIZE
        busy += i[own_i + at.SI_PLUCK] + i[own_i + at.SI_LAND_LENGTH] + i[own_i + at.SI_MOVE_LENGTH]
        busy += i[own_i + at.SI_LIFT_LENGTH] + i[own_i + at.SI_DAMP_LENGTH] + i[own_i + at.SI_TENSION_LENGTH]
        busy += i[own_i + at.SI_CHANGED]
    i[at.H_BUSY] = 1 if busy > 0 else 0


@kernel
def _smooth(u):
    return u * u * (3.0 - 2.0 * u)


@kernel
def _follow_landing(d, i, s):
    """The spring's offset one sample on: from the string's displacement and velocity to nothing (cubic Hermite)."""
    own, own_i = at.STRING + s * at.STRING_D_SIZE, at.STRING_I + s * at.STRING_I_SIZE
    length = i[own_i + at.SI_LAND_LENGTH]
    i[own_i + at.SI_LAND_AT] += 1
    u = i[own_i + at.SI_LAND_AT] / length
    stay, go = (2.0 * u - 3.0) * u * u + 1.0, length * u * (u - 1.0) * (u - 1.0)
    for j in range(i[own_i + at.SI_FINGER]):
        row = (j + 1) * at.LANES + s
        c, v = own + at.S_LAND_C + j, own + at.S_LAND_V + j
        d[at.LAND_Y + row] = stay * d[c] + go * d[v] if u < 1.0 else 0.0
        d[at.LAND_Z + row] = stay * d[c + at.MAX_CONTACTS] + go * d[v + at.MAX_CONTACTS] if u < 1.0 else 0.0
    if i[own_i + at.SI_LAND_AT] > length:
        i[own_i + at.SI_LAND_LENGTH] = 0


@kernel
def _follow_lift(d, i, s):
    own_i = at.STRING_I + s * at.STRING_I_SIZE
    i[own_i + at.SI_LIFT_AT] += 1
    now, length = i[own_i + at.SI_LIFT_AT], i[own_i + at.SI_LIFT_LENGTH]
    if now >= length:
        remove_finger(d, i, s)
    elif now % LIFT_EVERY == 0 and not pulls(d, s):
        set_grip(d, i, s, LEAST_GRIP ** (now / length))
        i[own_i + at.SI_CHANGED] |= RESISTANCE_CHANGED


@kernel
def _follow_pull(d, i, s):
    """The offset of a finger that draws the string aside before it lets go, on top of a landing's."""
    own, own_i = at.STRING + s * at.STRING_D_SIZE, at.STRING_I + s * at.STRING_I_SIZE
    share = _smooth(i[own_i + at.SI_LIFT_AT] / i[own_i + at.SI_LIFT_LENGTH])
    for j in range(i[own_i + at.SI_FINGER]):
        row = (j + 1) * at.LANES + s
        if i[own_i + at.SI_LAND_LENGTH] == 0:
            d[at.LAND_Y + row] = d[at.LAND_Z + row] = 0.0
        d[at.LAND_Y + row] += share * d[own + at.S_PULL_Y]
        d[at.LAND_Z + row] += share * d[own + at.S_PULL_Z]


@kernel
def _follow_damper(d, i, s):
    own, own_i = at.STRING + s * at.STRING_D_SIZE, at.STRING_I + s * at.STRING_I_SIZE
    i[own_i + at.SI_DAMP_AT] += 1
    now, length = i[own_i + at.SI_DAMP_AT], i[own_i + at.SI_DAMP_LENGTH]
    every = TOUCH_EVERY if d[own + at.S_TOUCH_PLACE] > 0.0 else DAMP_EVERY
    if now < length and now % every != 0:
        return
    start, end = d[own + at.S_DAMP_FROM], d[own + at.S_DAMP_TO]
    if now >= length:
        i[own_i + at.SI_DAMP_LENGTH] = 0
        if end == 0.0:
            remove_damper(d, i, s)
            return
    set_damper(d, i, s, start + (end - start) * _smooth(min(now / length, 1.0)))
    i[own_i + at.SI_CHANGED] |= RESISTANCE_CHANGED


@kernel
def _follow_tension(d, i, s):
    own, own_i = at.STRING + s * at.STRING_D_SIZE, at.STRING_I + s * at.STRING_I_SIZE
    i[own_i + at.SI_TENSION_AT] += 1
    now, length = i[own_i + at.SI_TENSION_AT], i[own_i + at.SI_TENSION_LENGTH]
    if now < length and now % BEND_EVERY != 0:
        return
    start, end = d[own + at.S_RATIO_FROM], d[own + at.S_RATIO_TO]
    share = min(now / length, 1.0)
    d[own + at.S_RATIO] = start + (end - start) * (share if i[own_i + at.SI_TENSION_STRAIGHT] == 1 else _smooth(share))
    tune_string(d, i, s)
    i[own_i + at.SI_CHANGED] |= PORTS_CHANGED
    if now >= length:
        i[own_i + at.SI_TENSION_LENGTH] = 0


@kernel
def _settle_changes(d, i, s):
    """Let the string's ports be what the hands have made of them."""
    own_i = at.STRING_I + s * at.STRING_I_SIZE
    changed = i[own_i + at.SI_CHANGED]
    i[own_i + at.SI_CHANGED] = 0
    if changed == RESISTANCE_CHANGED:
        invert_ports(d, i, s)
        return
    refit_string(d, i, s)
    if changed & LANDED:
        catch_string(d, i, s)
    if changed & TOUCHED:
        follow_string(d, i, s)


@kernel
def pluck_force(now, length, release, smooth):
    """Share of the peak force that sample ``now`` of a ramp over ``length`` samples feels.

    The ramp that is cut to nothing at its end, averaged with a hat of two samples' width: exact for every free mode. Or
    it falls along half a cosine over ``release`` samples, as flesh lets a string slip. A ``smooth`` one rises along
    half a cosine too: its slope is nothing at both ends, so the hat changes it by less than 1 / length^2.
    """
    if release > 0 and now >= length:
        return 0.5 + 0.5 * math.cos(math.pi * (now - length) / (release + 1))
    if smooth == 1:
        return 0.5 - 0.5 * math.cos(math.pi * now / length) if now < length else 0.5
    if now == 0:
        return 1.0 / (6.0 * length)
    if now < length:
        return now / length
    return 0.5 - 1.0 / (6.0 * length)


@kernel
def begin_sample(d, i):
    """Bring every ramp one sample on, before the solver; adds the pluck's part to the sums."""
    for s in range(i[at.H_STRINGS]):
        own, own_i = at.STRING + s * at.STRING_D_SIZE, at.STRING_I + s * at.STRING_I_SIZE
        if i[own_i + at.SI_TENSION_LENGTH] > 0:
            _follow_tension(d, i, s)
        if i[own_i + at.SI_LIFT_LENGTH] > 0:
            _follow_lift(d, i, s)
        if i[own_i + at.SI_DAMP_LENGTH] > 0:
            _follow_damper(d, i, s)
        plucked = i[own_i + at.SI_PLUCK] == 1
        length, release = i[own_i + at.SI_PLUCK_LENGTH], i[own_i + at.SI_PLUCK_RELEASE]
        if plucked and i[own_i + at.SI_PLUCK_AT] > length + release:
            i[own_i + at.SI_PLUCK] = 0
            i[own_i + at.SI_CHANGED] |= PORTS_CHANGED
        if i[own_i + at.SI_CHANGED] != 0:
            _settle_changes(d, i, s)
        if i[own_i + at.SI_LAND_LENGTH] > 0:
            _follow_landing(d, i, s)
        if i[own_i + at.SI_LIFT_LENGTH] > 0 and pulls(d, s):
            _follow_pull(d, i, s)
        if i[own_i + at.SI_PLUCK] == 1:
            share = pluck_force(i[own_i + at.SI_PLUCK_AT], length, release, i[own_i + at.SI_PLUCK_SMOOTH])
            _add_pluck(d, i, s, share * d[own + at.S_PLUCK_FY], share * d[own + at.S_PLUCK_FZ])
            i[own_i + at.SI_PLUCK_AT] += 1


@kernel
def _add_pluck(d, i, s, force_y, force_z):
    """The pluck moves the contacts' rows by A G phi f and the tension's row by u f."""
    own = at.STRING + s * at.STRING_D_SIZE
    n = 1 + count_contacts(i, s)
    d[own + at.S_PLUCK_Y], d[own + at.S_PLUCK_Z] = force_y, force_z
    for j in range(n):
        row = at.ACC + 2 * j * at.ACC_STRIDE + 8 * s
        d[row] += d[own + at.S_PLUCK_W + j] * force_y
        d[row + 4] += d[own + at.S_PLUCK_W + j] * force_z
    pushed = at.ACC + (2 * n + 1) * at.ACC_STRIDE + 8 * s
    tension = at.ACC + at.SUM_HX * at.ACC_STRIDE + 8 * s
    for lane in range(4):
        d[tension] += d[pushed + lane] * force_y + d[pushed + 4 + lane] * force_z


@kernel
def push_strings(d, i):
    """After the solver: give the sweep the pluck's force as one more column."""
    for s in range(i[at.H_STRINGS]):
        if i[at.STRING_I + s * at.STRING_I_SIZE + at.SI_PLUCK] == 1:
            own, column = at.STRING + s * at.STRING_D_SIZE, 1 + count_contacts(i, s)
            d[at.LAM_Y + column * at.LANES + s] = d[own + at.S_PLUCK_Y]
            d[at.LAM_Z + column * at.LANES + s] = d[own + at.S_PLUCK_Z]


@kernel
def end_sample(d, i):
    """After the sweep: slides move their columns; the busy flag falls when nothing is under way any more."""
    for s in range(i[at.H_STRINGS]):
        if i[at.STRING_I + s * at.STRING_I_SIZE + at.SI_MOVE_LENGTH] > 0:
            follow_slide(d, i, s)
    _mark_busy(i)
