"""A string's ports: where bridge, fingers, dampers and the pluck act on it, and what the solver must know of them.

Enter a string whose set of ports changed; leave its port columns, pseudo-modes, W = A G A^T, V = W^-1 and fresh sums.
The motion (displacement at k and k - 1) is untouched.
"""

import math

from ukrt.engine import layout as at
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.linalg import ROW, cholesky, solve_lower, solve_upper
from ukrt.engine.kernels.motion import former_position, position
from ukrt.engine.kernels.residual import rebuild_residual, remember_residual
from ukrt.engine.kernels.residual_kept import keep_modes, remember_modes

_M = at.SCRATCH + 512
_UNIT = at.SCRATCH + 640


@kernel
def count_contacts(i, s):
    """How many contacts (finger and damper) string ``s`` has."""
    own_i = at.STRING_I + s * at.STRING_I_SIZE
    return i[own_i + at.SI_FINGER] + i[own_i + at.SI_DAMPER]


@kernel
def count_ports(i, s):
    """Bridge, contacts and, while it lasts, the pluck of string ``s``."""
    return 1 + count_contacts(i, s) + i[at.STRING_I + s * at.STRING_I_SIZE + at.SI_PLUCK]


@kernel
def contact_place(d, own, offset, place):
    """Where a finger's contact ``offset`` behind ``place`` [m] lies, kept on the string."""
    length = d[own + at.S_LENGTH]
    return min(max(place + offset, 0.002), 0.98 * length)


@kernel
def _list_ports(d, i, s):
    """Write the places of all ports; bridge, finger, damper, pluck."""
    own, own_i = at.STRING + s * at.STRING_D_SIZE, at.STRING_I + s * at.STRING_I_SIZE
    d[own + at.S_PORT_X] = d[own + at.S_LENGTH]
    n = 1
    for j in range(i[own_i + at.SI_FINGER]):
        contact = at.CONTACTS + (i[own_i + at.SI_FINGER_FROM] + j) * at.CONTACT_SIZE
        offset = d[contact + at.C_OFFSET]
        d[own + at.S_PORT_X + n] = contact_place(d, own, offset, d[own + at.S_FINGER_PLACE])
        n += 1
    for j in range(i[own_i + at.SI_DAMPER]):
        contact = at.CONTACTS + (at.MAX_CONTACTS + i[own_i + at.SI_DAMPER_FROM] + j) * at.CONTACT_SIZE
        touch = d[own + at.S_TOUCH_PLACE]
        share = touch if touch > 0.0 else d[contact + at.C_OFFSET]
        d[own + at.S_PORT_X + n] = share * d[own + at.S_LENGTH]
        n += 1
    if i[own_i + at.SI_PLUCK] == 1:
        d[own + at.S_PORT_X + n] = d[own + at.S_PLUCK_PLACE]
        n += 1
    return n


@kernel
def set_columns(d, i, s, first, last):
    """Columns ``first`` to below ``last`` of the free modes: sqrt(g) phi(x), Eq. 19."""
    own, own_i = at.STRING + s * at.STRING_D_SIZE, at.STRING_I + s * at.STRING_I_SIZE
    for port in range(first, last):
        angle = math.pi * d[own + at.S_PORT_X + port] / (2.0 * d[own + at.S_LENGTH])
        for n in range(i[own_i + at.SI_MODES]):
            c = at.COEF + (i[own_i + at.SI_TILE] + n // 4) * at.COEF_TILE + at.COEF_COLUMNS + n % 4
            d[c + 4 * port] = abs(d[c]) * math.sin((2 * n + 1) * angle)


@kernel
def measure_ports(d, i, s):
    """W of bridge and contacts, and A G phi of the pluck, from the columns."""
    own, own_i = at.STRING + s * at.STRING_D_SIZE, at.STRING_I + s * at.STRING_I_SIZE
    n_rows = 1 + count_contacts(i, s)
    first, last = i[own_i + at.SI_TILE], i[own_i + at.SI_TILE] + i[own_i + at.SI_TILES]
    for j in range(count_ports(i, s)):
        for k in range(min(j + 1, n_rows)):
            value = 0.0
            for tile in range(first, last):
                c = at.COEF + tile * at.COEF_TILE + at.COEF_COLUMNS
                for lane in range(4):
                    value += d[c + 4 * j + lane] * d[c + 4 * k + lane]
            if j < n_rows:
                d[own + at.S_W + at.PORTS * j + k] = value
            else:
                d[own + at.S_PLUCK_W + k] = value


@kernel
def invert_ports(d, i, s):
    """V = (A G A^T)^-1 of string ``s`` with its contacts' own part, into the solver's lanes."""
    own = at.STRING + s * at.STRING_D_SIZE
    n = 1 + count_contacts(i, s)
    for j in range(n):
        for k in range(j + 1):
            d[_M + ROW * j + k] = d[own + at.S_W + at.PORTS * j + k]
        if j > 0:
            d[_M + ROW * j + j] += d[at.FIN_G + j * at.LANES + s]
    cholesky(d, _M, n)
    for j in range(at.PORTS):
        for k in range(at.PORTS):
            d[_UNIT + k] = 1.0 if k == j else 0.0
        if j < n:
            solve_lower(d, _M, n, _UNIT, 1)
            solve_upper(d, _M, n, _UNIT, 1)
        for k in range(at.PORTS):
            d[at.V + (at.PORTS * j + k) * at.LANES + s] = d[_UNIT + k] if j < n and k < n else 0.0


@kernel
def sum_string(d, i, s):
    """The sums that the last sweep would have left, had the columns been what they are now."""
    own_i = at.STRING_I + s * at.STRING_I_SIZE
    for place in range(at.SUMS):
        for lane in range(8):
            d[at.ACC + place * at.ACC_STRIDE + 8 * s + lane] = 0.0
    n_ports = count_ports(i, s)
    for tile in range(i[own_i + at.SI_TILE], i[own_i + at.SI_TILE] + i[own_i + at.SI_TILES]):
        x, c = at.STATE + tile * at.STATE_TILE, at.COEF + tile * at.COEF_TILE
        for lane in range(8):
            out = at.ACC + 8 * s + lane
            predicted = d[x + 8 + lane]
            weighted = d[x + lane] if d[c + at.COEF_D + lane % 4] != 0.0 else 0.0
            for port in range(n_ports):
                column = d[c + at.COEF_COLUMNS + 4 * port + lane % 4]
                d[out + 2 * port * at.ACC_STRIDE] += column * predicted
                d[out + (2 * port + 1) * at.ACC_STRIDE] += column * weighted
            d[out + at.SUM_HH * at.ACC_STRIDE] += weighted * weighted
            d[out + at.SUM_HX * at.ACC_STRIDE] += weighted * predicted


@kernel
def set_solver_ports(i):
    """How many ports a string the solver must look at: the most that any string has that is not asleep."""
    most = 0
    for s in range(i[at.H_STRINGS]):
        if i[at.STRING_I + s * at.STRING_I_SIZE + at.SI_SLEEP] != at.ASLEEP:
            most = max(most, count_contacts(i, s))
    i[at.H_PORTS] = 1 + most


@kernel
def refit_string(d, i, s):
    """Everything that follows from a new set of ports, or from a new tension; the old ports' places still stand."""
    own_i = at.STRING_I + s * at.STRING_I_SIZE
    n_old = i[own_i + at.SI_PORTS]
    remember_residual(d, i, s, n_old)
    n_new = _list_ports(d, i, s)
    i[own_i + at.SI_PORTS] = n_new
    for tile in range(i[own_i + at.SI_TILE], i[own_i + at.SI_TILE] + i[own_i + at.SI_TILES]):
        for k in range(4 * n_new, 4 * at.COLUMNS):
            d[at.COEF + tile * at.COEF_TILE + at.COEF_COLUMNS + k] = 0.0
    set_columns(d, i, s, 1, n_new)
    remember_modes(d, i, s)
    n_pseudo = rebuild_residual(d, i, s, n_old, n_new)
    keep_modes(d, i, s, n_old, n_new)
    spare = 1 if n_pseudo <= at.TILE else 0  # the second tile of pseudo-modes is empty
    i[own_i + at.SI_END] = i[own_i + at.SI_TILE] + i[own_i + at.SI_TILES] - spare
    i[own_i + at.SI_EXTRA] = n_new - 1
    if i[own_i + at.SI_MOVE_LENGTH] > 0:  # a slide under way: the finger is at its segment's end already
        for k in range(4 * at.COLUMNS * i[own_i + at.SI_TILES]):
            d[at.SLIDE + 4 * at.COLUMNS * i[own_i + at.SI_TILE] + k] = 0.0
    measure_ports(d, i, s)
    invert_ports(d, i, s)
    sum_string(d, i, s)
    set_solver_ports(i)


@kernel
def port_motion(d, i, s, port, half):
    """Displacement [m] of a port at k and at k - 1; ``half`` is 0 for Y, 4 for Z."""
    own_i = at.STRING_I + s * at.STRING_I_SIZE
    now, before = 0.0, 0.0
    for tile in range(i[own_i + at.SI_TILE], i[own_i + at.SI_TILE] + i[own_i + at.SI_TILES]):
        x, c = at.STATE + tile * at.STATE_TILE + half, at.COEF + tile * at.COEF_TILE
        for lane in range(4):
            column = d[c + at.COEF_COLUMNS + 4 * port + lane]
            if column != 0.0:
                now += column * position(d, x + lane, c + lane)
                before += column * former_position(d, x + lane, c + lane)
    return now, before
