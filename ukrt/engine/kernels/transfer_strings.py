"""A string's motion, from one instance to another.

Enter two instances and a string's number; leave in the second the string as it moves, with all that touches it. Either
``copy_string``, where the two strings are the same, or ``carry_string``; after the latter ``join_string`` must follow.
"""

import math

from ukrt.engine import layout as at
from ukrt.engine import player_layout as player
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.modes import tune_string
from ukrt.engine.kernels.motion import flow_back, foresee, position
from ukrt.engine.kernels.ports import refit_string
from ukrt.engine.kernels.residual import V_MOVED, X_OLD, cut_receptance, rebuild_residual, remember_residual
from ukrt.engine.kernels.transfer_hands import carry_hands, carry_slide
from ukrt.engine.kernels.transfer_modes import carry_mode

_FORCES = at.SCRATCH + 1024  # upon the new string at its ports: COLUMNS in Y, COLUMNS in Z
_TILES = (  # what of a string stands in tiles, and their sizes
    (at.STATE, at.STATE_TILE),
    (at.COEF, at.COEF_TILE),
    (at.ERROR, at.ERROR_TILE),
    (at.SLIDE, at.TILE * at.COLUMNS),
)
_FORMER = at.SCRATCH + 1056  # which port of the old string each was, -1: none


@kernel
def same_string(d0, i0, d1, i1, s):
    """Whether string ``s``, its frets and what can touch it are the same in both instances."""
    own, own_i = at.STRING + s * at.STRING_D_SIZE, at.STRING_I + s * at.STRING_I_SIZE
    same = d0[at.METER + at.M_RATE] == d1[at.METER + at.M_RATE] and i0[own_i + at.SI_MODES] == i1[own_i + at.SI_MODES]
    same = same and i0[at.H_FINGER] == i1[at.H_FINGER] and i0[at.H_DAMPER] == i1[at.H_DAMPER]
    same = same and d0[at.XI + s] == d1[at.XI + s] and d0[at.SIGMA + s] == d1[at.SIGMA + s]
    for k in range(at.S_LENGTH, at.S_BANDWIDTH + 1):
        same = same and d0[own + k] == d1[own + k]
    for k in range(2 * at.MAX_CONTACTS * at.CONTACT_SIZE):
        same = same and d0[at.CONTACTS + k] == d1[at.CONTACTS + k]
    for k in range(s * player.FRET_ROW, (s + 1) * player.FRET_ROW):
        same = same and d0[player.D_PLACES + k] == d1[player.D_PLACES + k]
    return same


@kernel
def copy_string(d0, i0, d1, i1, s):
    """To the bit: state, coefficients, ports, sums, fingers and ramps. Its tiles may lie elsewhere."""
    own, own_i = at.STRING + s * at.STRING_D_SIZE, at.STRING_I + s * at.STRING_I_SIZE
    tile0, tile1, tiles = i0[own_i + at.SI_TILE], i1[own_i + at.SI_TILE], i0[own_i + at.SI_TILES]
    for base, size in _TILES:
        for k in range(tiles * size):
            d1[base + tile1 * size + k] = d0[base + tile0 * size + k]
    for k in range(at.STRING_D_SIZE):
        d1[own + k] = d0[own + k]
    for k in range(at.STRING_I_SIZE):
        i1[own_i + k] = i0[own_i + k]
    i1[own_i + at.SI_TILE] = tile1
    i1[own_i + at.SI_END] += tile1 - tile0
    for place in range(at.SUMS):
        for k in range(at.ACC + place * at.ACC_STRIDE + 8 * s, at.ACC + place * at.ACC_STRIDE + 8 * s + 8):
            d1[k] = d0[k]
    for lane in range(at.V + s, at.SIGMA, at.LANES):  # V, forces, mu, psi
        d1[lane] = d0[lane]
    for lane in range(at.LAND_Y + s, at.SLIDE, at.LANES):  # landings and fingers
        d1[lane] = d0[lane]


@kernel
def carry_string(d0, i0, d1, i1, s, pace):
    """From the motion of one string to that of another in the same hands; ``pace`` is new sample rate over old."""
    own = at.STRING + s * at.STRING_D_SIZE
    longer = d1[own + at.S_LENGTH] / d0[own + at.S_LENGTH]
    stiffer = d1[own + at.S_TENSION] / d0[own + at.S_TENSION]
    spread = math.sqrt(longer / stiffer)  # how much larger a deflection of the same energy is
    d1[own + at.S_RATIO] = d0[own + at.S_RATIO]
    if d1[own + at.S_RATIO] != 1.0:
        tune_string(d1, i1, s)
    carry_hands(d0, i0, d1, i1, s, pace, longer, spread)
    refit_string(d1, i1, s)
    _carry_forces(d0, i0, d1, i1, s, spread)
    _carry_modes(d0, i0, d1, i1, s)
    _carry_residual(d0, i0, d1, i1, s, pace, spread)
    carry_slide(d0, i0, d1, i1, s, pace)


@kernel
def _carry_forces(d0, i0, d1, i1, s, spread):
    """What bridge, fingers, dampers and pluck last did to the string goes to their places on the new one.

    Divided by ``spread`` these forces hold the deflection they held before.
    """
    own_i = at.STRING_I + s * at.STRING_I_SIZE
    for port in range(at.COLUMNS):
        d1[_FORCES + port] = d1[_FORCES + at.COLUMNS + port] = 0.0
        d1[_FORMER + port] = -1.0
    port0, port1 = 0, 0
    for kind in (-1, at.SI_FINGER, at.SI_DAMPER, at.SI_PLUCK):  # in the order of the ports, the bridge first
        n0, n1 = (1, 1) if kind < 0 else (i0[own_i + kind], i1[own_i + kind])
        for j in range(min(n0, n1)):
            row = (port0 + j) * at.LANES + s
            d1[_FORCES + port1 + j] = d0[at.LAM_Y + row] / spread
            d1[_FORCES + at.COLUMNS + port1 + j] = d0[at.LAM_Z + row] / spread
            d1[_FORMER + port1 + j] = float(port0 + j)
        port0, port1 = port0 + n0, port1 + n1


@kernel
def _held(d, c, forces, step):
    """Where a mode (coefficients at ``c``) would stand still under the ports' forces, ``step`` apart."""
    total = 0.0
    for port in range(at.COLUMNS):
        column = d[c + at.COEF_COLUMNS + 4 * port]
        if column != 0.0:
            total += column * d[forces + port * step]
    return total / (1.0 - d[c + at.COEF_A] - flow_back(d, c))


@kernel
def _carry_modes(d0, i0, d1, i1, s):
    """Modes of the same number swing on; those that only the new string has stand where the forces hold them.

    So what the forces bend, a kink at the finger above all, is bent at their new places from the start.
    """
    own_i = at.STRING_I + s * at.STRING_I_SIZE
    common = min(i0[own_i + at.SI_MODES], i1[own_i + at.SI_MODES])
    for n in range(i1[own_i + at.SI_MODES]):
        tile0, tile1 = i0[own_i + at.SI_TILE] + n // 4, i1[own_i + at.SI_TILE] + n // 4
        c0, c1 = at.COEF + tile0 * at.COEF_TILE + n % 4, at.COEF + tile1 * at.COEF_TILE + n % 4
        x0, x1 = at.STATE + tile0 * at.STATE_TILE + n % 4, at.STATE + tile1 * at.STATE_TILE + n % 4
        a1, b1 = d1[c1 + at.COEF_A], flow_back(d1, c1)
        for half in range(2):
            held1 = _held(d1, c1, _FORCES + at.COLUMNS * half, 1)
            now, coming = held1, (a1 + b1) * held1
            if n < common:
                held0 = _held(d0, c0, (at.LAM_Y if half == 0 else at.LAM_Z) + s, at.LANES)
                now, coming = position(d0, x0 + 4 * half, c0), d0[x0 + 8 + 4 * half]
                a0, b0 = d0[c0 + at.COEF_A], flow_back(d0, c0)
                now, coming = carry_mode(now, coming, held0, held1, a0, b0, a1, b1)
            foresee(d1, x1 + 4 * half, c1, now, coming)


@kernel
def _deflection(d, s, forces, step, port, n_ports):
    """How far the forces at its ports deflect the modes that string ``s`` lacks, at one of the ports [m]."""
    own, total = at.STRING + s * at.STRING_D_SIZE, 0.0
    for other in range(n_ports):
        x, y = d[own + at.S_PORT_X + port], d[own + at.S_PORT_X + other]
        total += d[forces + other * step] * cut_receptance(d, s, 0, x, y)
    return total / d[own + at.S_RATIO]


@kernel
def _carry_residual(d0, i0, d1, i1, s, pace, spread):
    """Pseudo-modes: where the forces hold what both bases lack, and at each port what it was away from there."""
    own_i = at.STRING_I + s * at.STRING_I_SIZE
    n0, n1 = i0[own_i + at.SI_PORTS], i1[own_i + at.SI_PORTS]
    remember_residual(d0, i0, s, n0)
    for port in range(n1):
        d1[X_OLD + port] = d1[at.STRING + s * at.STRING_D_SIZE + at.S_PORT_X + port]
        former = int(d1[_FORMER + port])
        for half in range(2):
            moved = V_MOVED + 16 * half
            held = _deflection(d1, s, _FORCES + at.COLUMNS * half, 1, port, n1)
            d1[moved + port] = d1[moved + 8 + port] = held
            if former >= 0:
                now, before = d0[moved + former], d0[moved + 8 + former]
                away = now - _deflection(d0, s, (at.LAM_Y if half == 0 else at.LAM_Z) + s, at.LANES, former, n0)
                d1[moved + port] += spread * away
                d1[moved + 8 + port] += spread * (away + (before - now) / pace)
    rebuild_residual(d1, i1, s, n1, n1)


