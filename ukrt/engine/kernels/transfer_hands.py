"""What touches a string, from one instance to another: fingers, dampers, plucks and their ramps.

Enter two instances and a string's number; leave in the second, before its ports are made, what hands do to the string:
everything at its place on the new guitar, ramps as far as they had come.
"""

import math

from ukrt.engine import layout as at
from ukrt.engine import player_layout as player
from ukrt.engine.kernels.hands import SHORTEST_PLUCK, set_damper, set_grip
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.ramps import LEAST_GRIP
from ukrt.engine.kernels.slide import begin_slide
from ukrt.engine.kernels.transfer_modes import carry_mode, same_energy

SPRINGLESS = 1e-12  # 1 - a - b of a contact without a spring, up to rounding


@kernel
def scaled_frames(frames, pace):
    """A number of frames at ``pace`` times the sample rate."""
    return int(math.floor(frames * pace + 0.5))


@kernel
def carry_place(d0, i0, d1, i1, s, place):
    """A finger's place [m] on the other guitar: the same fret's where it is a fret's, else the same share of L."""
    row = player.D_PLACES + s * player.FRET_ROW
    for fret in range(1, 1 + min(i0[player.I_FRETS], i1[player.I_FRETS])):
        if d0[row + fret] == place:
            return d1[row + fret]
    own = at.STRING + s * at.STRING_D_SIZE
    return place * d1[own + at.S_LENGTH] / d0[own + at.S_LENGTH]


@kernel
def carry_hands(d0, i0, d1, i1, s, pace, longer, spread):
    """All of it; ``longer`` is the new string's length over the old one's, ``spread`` how much wider it swings."""
    own, own_i = at.STRING + s * at.STRING_D_SIZE, at.STRING_I + s * at.STRING_I_SIZE
    for k in (at.S_RATIO_FROM, at.S_RATIO_TO, at.S_DAMP_LEVEL, at.S_DAMP_FROM, at.S_DAMP_TO):
        d1[own + k] = d0[own + k]
    _carry_ramp(i0, i1, own_i + at.SI_TENSION_AT, pace)
    i1[own_i + at.SI_TENSION_STRAIGHT] = i0[own_i + at.SI_TENSION_STRAIGHT]
    _carry_finger(d0, i0, d1, i1, s, pace)
    _carry_damper(d0, i0, d1, i1, s, pace)
    _carry_pluck(d0, i0, d1, i1, s, pace, longer, spread)


@kernel
def carry_slide(d0, i0, d1, i1, s, pace):
    """A slide under way sets out anew, in the time it had left; the string's ports have been made."""
    own, own_i = at.STRING + s * at.STRING_D_SIZE, at.STRING_I + s * at.STRING_I_SIZE
    left = i0[own_i + at.SI_MOVE_LENGTH] - i0[own_i + at.SI_MOVE_AT]
    if i0[own_i + at.SI_MOVE_LENGTH] > 0 and i1[own_i + at.SI_FINGER] > 0:
        begin_slide(d1, i1, s, carry_place(d0, i0, d1, i1, s, d0[own + at.S_MOVE_TO]), scaled_frames(left, pace))


@kernel
def _carry_ramp(i0, i1, began, pace):
    """A ramp's count at ``began`` and, beside it, its length (0: none is under way)."""
    length = i0[began + 1]
    if length > 0:
        i1[began + 1] = max(1, scaled_frames(length, pace))
        i1[began] = min(scaled_frames(i0[began], pace), i1[began + 1] - 1)


@kernel
def _carry_pluck(d0, i0, d1, i1, s, pace, longer, spread):
    """A pluck under way goes on, with the force that holds the deflection there is now."""
    own, own_i = at.STRING + s * at.STRING_D_SIZE, at.STRING_I + s * at.STRING_I_SIZE
    i1[own_i + at.SI_RELEASE] = scaled_frames(i0[own_i + at.SI_RELEASE], pace)
    if i0[own_i + at.SI_PLUCK] == 0:
        return
    length, now, release = i0[own_i + at.SI_PLUCK_LENGTH], i0[own_i + at.SI_PLUCK_AT], i0[own_i + at.SI_PLUCK_RELEASE]
    i1[own_i + at.SI_PLUCK], i1[own_i + at.SI_PLUCK_LENGTH] = 1, max(SHORTEST_PLUCK, scaled_frames(length, pace))
    i1[own_i + at.SI_PLUCK_RELEASE] = scaled_frames(release, pace)
    i1[own_i + at.SI_PLUCK_SMOOTH] = i0[own_i + at.SI_PLUCK_SMOOTH]
    last = i1[own_i + at.SI_PLUCK_LENGTH] + i1[own_i + at.SI_PLUCK_RELEASE]
    over = 1 if now > length + release else 0  # its last sample has been: the next one lets go
    i1[own_i + at.SI_PLUCK_AT] = min(scaled_frames(now, pace), last) + over
    d1[own + at.S_PLUCK_PLACE] = longer * d0[own + at.S_PLUCK_PLACE]
    d1[own + at.S_PLUCK_FY] = d0[own + at.S_PLUCK_FY] / spread
    d1[own + at.S_PLUCK_FZ] = d0[own + at.S_PLUCK_FZ] / spread


@kernel
def _carry_damper(d0, i0, d1, i1, s, pace):
    """The new guitar's damper with the old one's level; it takes hold of the string in ``join_string``."""
    own_i = at.STRING_I + s * at.STRING_I_SIZE
    if i0[own_i + at.SI_DAMPER] == 0:
        return
    touch = d0[at.STRING + s * at.STRING_D_SIZE + at.S_TOUCH_PLACE]
    if touch > 0.0 and i1[at.H_FINGER] >= at.MAX_CONTACTS:
        return
    d1[at.STRING + s * at.STRING_D_SIZE + at.S_TOUCH_PLACE] = touch
    i1[own_i + at.SI_DAMPER] = 1 if touch > 0.0 else i1[at.H_DAMPER]
    _carry_ramp(i0, i1, own_i + at.SI_DAMP_AT, pace)
    for j in range(i1[own_i + at.SI_DAMPER]):
        row = (1 + i1[own_i + at.SI_FINGER] + j) * at.LANES + s
        d1[at.FIN_A + row], d1[at.FIN_B + row] = 0.0, 1.0
    set_damper(d1, i1, s, d1[at.STRING + s * at.STRING_D_SIZE + at.S_DAMP_LEVEL])


@kernel
def _carry_finger(d0, i0, d1, i1, s, pace):
    """The new guitar's finger at the place of the old one; each contact's spring keeps its energy, as a mode does."""
    own, own_i = at.STRING + s * at.STRING_D_SIZE, at.STRING_I + s * at.STRING_I_SIZE
    n_old, n_new = i0[own_i + at.SI_FINGER], i1[at.H_FINGER]
    if n_old == 0 or n_new == 0:
        return
    i1[own_i + at.SI_FINGER] = n_new
    d1[own + at.S_FINGER_PLACE] = carry_place(d0, i0, d1, i1, s, d0[own + at.S_FINGER_PLACE])
    for j in range(n_new):
        contact, row = at.CONTACTS + j * at.CONTACT_SIZE, (j + 1) * at.LANES + s
        a1, b1, g1 = d1[contact + at.C_A], d1[contact + at.C_B], d1[contact + at.C_G]
        d1[at.FIN_A + row], d1[at.FIN_B + row], d1[at.FIN_G + row] = a1, b1, g1
        a0, b0, g0 = d0[contact + at.C_A], d0[contact + at.C_B], d0[contact + at.C_G]
        if j < n_old and g0 > 0.0 and g1 > 0.0 and 1.0 - a0 - b0 > SPRINGLESS and 1.0 - a1 - b1 > SPRINGLESS:
            softer = math.sqrt(g1 / g0)
            for half in range(2):
                now, coming = (at.FIN_Y + row, at.FIN_Y1 + row) if half == 0 else (at.FIN_Z + row, at.FIN_Z1 + row)
                held = -g0 * d0[(at.LAM_Y if half == 0 else at.LAM_Z) + row] / (1.0 - a0 - b0)
                held1 = same_energy(a0, b0, a1, b1) * held
                x, xs = carry_mode(d0[now], d0[coming], held, held1, a0, b0, a1, b1)
                d1[now], d1[coming] = softer * x, softer * xs
    _carry_ramp(i0, i1, own_i + at.SI_LIFT_AT, pace)
    if i1[own_i + at.SI_LIFT_LENGTH] > 0:
        set_grip(d1, i1, s, LEAST_GRIP ** (i1[own_i + at.SI_LIFT_AT] / i1[own_i + at.SI_LIFT_LENGTH]))
