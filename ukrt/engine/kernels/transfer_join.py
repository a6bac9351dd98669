"""A string that has come from another guitar meets the bridge and the fingers of this one, without a jump.

Enter a string whose motion has been carried over; leave it with its end where the body is, fingers and dampers holding
it where it is, and the sums that the next sample needs.
"""

import math

from ukrt.engine import layout as at
from ukrt.engine import player_layout as player
from ukrt.engine.kernels.energy import total_energy
from ukrt.engine.kernels.hands import follow_string
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.motion import flow_back, former_position, place_mode, position
from ukrt.engine.kernels.ports import port_motion, sum_string
from ukrt.engine.kernels.transfer_hands import SPRINGLESS


@kernel
def join_string(d, i, s):
    """Make string ``s`` meet the bridge and its fingers where these are now, without a jump; then its sums."""
    place, before = _bridge_motion(d, s)
    _meet_bridge(d, i, s, 0, place, before)
    _meet_bridge(d, i, s, 4, 0.0, 0.0)
    _ease_finger(d, i, s)
    follow_string(d, i, s)
    d[at.MU + s], d[at.PSI + s] = 0.0, _stretching(d, i, s)
    sum_string(d, i, s)


@kernel
def _bridge_motion(d, s):
    """Where the body holds string ``s`` [m], now and one sample before."""
    now, before = 0.0, 0.0
    for n in range(at.MAX_BODY_MODES):
        a, b, x = d[at.BODY_A + n], d[at.BODY_B + n], d[at.BODY_X + n]
        if b != 0.0:
            shape = d[at.BODY_BASS + n] + d[at.XI + s] * d[at.BODY_SLOPE + n]
            now += shape * x
            before += shape * (d[at.BODY_XS + n] - a * x) / b
    return now, before


@kernel
def _meet_bridge(d, i, s, half, place, before):
    """Deflect the string as a force at the bridge would, so that its end is at ``place`` and was at ``before`` [m]."""
    own_i = at.STRING_I + s * at.STRING_I_SIZE
    first, last = i[own_i + at.SI_TILE], i[own_i + at.SI_TILE] + i[own_i + at.SI_TILES]
    compliance = 0.0
    for tile in range(first, last):
        for lane in range(4):
            c = at.COEF + tile * at.COEF_TILE + lane
            if d[c + at.COEF_COLUMNS] != 0.0:
                compliance += d[c + at.COEF_COLUMNS] ** 2 / (1.0 - d[c + at.COEF_A] - flow_back(d, c))
    now, earlier = port_motion(d, i, s, 0, half)
    force_now, force_before = (place - now) / compliance, (before - earlier) / compliance
    for tile in range(first, last):
        for lane in range(4):
            c, x = at.COEF + tile * at.COEF_TILE + lane, at.STATE + tile * at.STATE_TILE + half + lane
            if d[c + at.COEF_COLUMNS] != 0.0:
                share = d[c + at.COEF_COLUMNS] / (1.0 - d[c + at.COEF_A] - flow_back(d, c))
                there, earlier = position(d, x, c), former_position(d, x, c)
                place_mode(d, x, c, there + share * force_now, earlier + share * force_before)


@kernel
def _ease_finger(d, i, s):
    """What the string is away from the finger becomes an offset that is let go, as in a landing.

    A contact without a spring has no place of its own: it starts where the string is.
    """
    own, own_i = at.STRING + s * at.STRING_D_SIZE, at.STRING_I + s * at.STRING_I_SIZE
    if i[own_i + at.SI_FINGER] == 0:
        return
    i[own_i + at.SI_LAND_AT], i[own_i + at.SI_LAND_LENGTH] = 0, max(1, i[player.I_LANDING])
    for j in range(i[own_i + at.SI_FINGER]):
        row = (j + 1) * at.LANES + s
        a, b, g = d[at.FIN_A + row], d[at.FIN_B + row], d[at.FIN_G + row]
        for half in range(2):
            place, coming = (at.FIN_Y + row, at.FIN_Y1 + row) if half == 0 else (at.FIN_Z + row, at.FIN_Z1 + row)
            now, before = port_motion(d, i, s, j + 1, 4 * half)
            if g > 0.0 and 1.0 - a - b <= SPRINGLESS:
                d[place], d[coming] = now, a * now + b * before
                now, before = 0.0, 0.0
            else:
                earlier = (d[coming] - a * d[place]) / b if b < -1e-3 else d[place]
                now, before = now - d[place], before - earlier
            d[own + at.S_LAND_C + at.MAX_CONTACTS * half + j] = now
            d[own + at.S_LAND_V + at.MAX_CONTACTS * half + j] = now - before


@kernel
def _stretching(d, i, s):
    """What psi follows: the sum of kappa q[k] q[k-1] over both polarizations."""
    own_i = at.STRING_I + s * at.STRING_I_SIZE
    total = 0.0
    for n in range(i[own_i + at.SI_MODES]):
        tile = i[own_i + at.SI_TILE] + n // 4
        c, x = at.COEF + tile * at.COEF_TILE + n % 4, at.STATE + tile * at.STATE_TILE + n % 4
        for half in (0, 4):
            total += d[x + half] * former_position(d, x + half, c)
    return total


@kernel
def bound_energy(d, i, most):
    """Shrink all motion alike, so that every constraint still holds, where its energy would be above ``most`` [J].

    Guitars of one kind never come here. A string of rubber that becomes one of steel does: at the same deflection its
    stretching alone, psi^2 / 2, which goes with the fourth power, can hold a million times the energy.
    """
    energy, stretching = total_energy(d, i), 0.0
    for s in range(i[at.H_STRINGS]):
        stretching += 0.5 * d[at.PSI + s] ** 2 / d[at.SIGMA + s]
    if not energy > most:
        return
    linear = energy - stretching
    square = 2.0 * most / (linear + math.sqrt(linear * linear + 4.0 * stretching * most))
    _shrink(d, i, math.sqrt(square))


@kernel
def _shrink(d, i, share):
    for n in range(at.MAX_BODY_MODES):
        d[at.BODY_X + n] *= share
        d[at.BODY_XS + n] *= share
    d[at.BODY_W + 3] *= share
    d[at.BODY_W + 4] *= share
    for lane in range(at.LAND_Y, at.FIN_A):  # landings and fingers
        d[lane] *= share
    for s in range(i[at.H_STRINGS]):
        own, own_i = at.STRING + s * at.STRING_D_SIZE, at.STRING_I + s * at.STRING_I_SIZE
        first, tiles = i[own_i + at.SI_TILE], i[own_i + at.SI_TILES]
        for x in range(at.STATE + first * at.STATE_TILE, at.STATE + (first + tiles) * at.STATE_TILE):
            d[x] *= share
        for k in range(2 * at.MAX_CONTACTS):
            d[own + at.S_LAND_C + k] *= share
            d[own + at.S_LAND_V + k] *= share
        d[own + at.S_PLUCK_FY] *= share
        d[own + at.S_PLUCK_FZ] *= share
        d[at.PSI + s] *= share * share
        sum_string(d, i, s)
