"""Strings that sleep (only while H_SHED is above 0): one that is nearly silent costs nothing until a hand touches it.

Enter an instance between two samples; leave one string hushed (losing its motion quickly), asleep or awake. Asleep it
is to the bridge what it is to slow motion: a spring, its lane of the solver holding the stiffness and nothing else.
That is a mode with a = b = 0 and g = 1 / stiffness, so that the energy of the whole still cannot grow
(ukrt/engine/README.md). Awake again its modes have the shape that such a spring stands for, with the bridge where it
is at k and k - 1: no constraint is violated and no force jumps.
"""

from ukrt.engine import gestures as kinds
from ukrt.engine import layout as at
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.linalg import ROW, cholesky, solve_lower, solve_upper
from ukrt.engine.kernels.modes import tune_string
from ukrt.engine.kernels.motion import flow_back, place_mode
from ukrt.engine.kernels.ports import (
    count_contacts,
    invert_ports,
    port_motion,
    refit_string,
    set_solver_ports,
    sum_string,
)

HUSH_LOSS = 200.0  # 1/s: every mode loses 74 dB in 85 ms (choice: quick, and no sound of its own)
SETTLE = 0.99  # per sample, of the sleeping spring's offset: gone after some ms (choice)
_R = at.SCRATCH + 704  # static compliance between the ports
_FORCES = at.SCRATCH + 768  # at the ports, for a bridge moved by 1 m
_TINY = 1e-12  # of 1 - a - b: a contact that holds nothing in place (a damper, a free mass)


@kernel
def _tune_anew(d, i, s, loss):
    """Give string ``s`` a ``loss`` [1/s] on top of its own; its motion stays."""
    d[at.STRING + s * at.STRING_D_SIZE + at.S_HUSH] = loss
    tune_string(d, i, s)
    refit_string(d, i, s)


@kernel
def hush_string(d, i, s, looks):
    """Begin to put string ``s`` to sleep: its modes lose their motion until shed.py has looked ``looks`` times more."""
    own_i = at.STRING_I + s * at.STRING_I_SIZE
    i[own_i + at.SI_SLEEP], i[own_i + at.SI_LOOKS] = at.HUSHED, looks
    _tune_anew(d, i, s, HUSH_LOSS)


@kernel
def sleep_string(d, i, s):
    """Put string ``s`` to sleep: what still moves is forgotten, a spring stays at the bridge.

    The spring's far end starts where the force does not jump, and is let go by `rest_string`: work of at most force^2 /
    (2 stiffness), as small as the string is silent, once.
    """
    own_i = at.STRING_I + s * at.STRING_I_SIZE
    force = d[at.LAM_Y + s]
    first = at.STATE + i[own_i + at.SI_TILE] * at.STATE_TILE
    for k in range(first, first + i[own_i + at.SI_TILES] * at.STATE_TILE):
        d[k] = 0.0
    for j in range(at.PORTS):
        row = j * at.LANES + s
        d[at.FIN_Y + row] = d[at.FIN_Z + row] = d[at.FIN_Y1 + row] = d[at.FIN_Z1 + row] = 0.0
        d[at.LAND_Y + row] = d[at.LAND_Z + row] = d[at.LAM_Y + row] = d[at.LAM_Z + row] = 0.0
    d[at.PSI + s] = d[at.MU + s] = 0.0
    if i[own_i + at.SI_SLEEP] == at.HUSHED:
        _tune_anew(d, i, s, 0.0)
    i[own_i + at.SI_SLEEP] = at.ASLEEP
    set_solver_ports(i)
    sum_string(d, i, s)
    _static_forces(d, i, s)
    for k in range(at.PORTS * at.PORTS):
        d[at.V + k * at.LANES + s] = 0.0
    d[at.V + s] = d[_FORCES]
    d[at.ACC + 8 * s] = bridge_motion(d, i, s)[0] - force / d[_FORCES]


@kernel
def rest_string(d, s):
    """One sample of a string that sleeps, in place of its sweep."""
    d[at.ACC + 8 * s] *= SETTLE


@kernel
def wake_for_hands(d, i, kind, s):
    """A hand comes to string ``s``: wake it, and at the lowest level whatever might begin to ring along."""
    wake_string(d, i, s)
    if i[at.H_SHED] == 1 and (kind == kinds.PLUCK or kind == kinds.PRESS):
        for other in range(i[at.H_STRINGS]):
            wake_string(d, i, other)


@kernel
def wake_string(d, i, s):
    """String ``s`` moves again, from where the bridge holds it; its fingers follow."""
    own_i = at.STRING_I + s * at.STRING_I_SIZE
    was = i[own_i + at.SI_SLEEP]
    i[own_i + at.SI_SLEEP] = at.AWAKE
    if was == at.HUSHED:
        _tune_anew(d, i, s, 0.0)
    elif was == at.ASLEEP:
        invert_ports(d, i, s)
        set_solver_ports(i)
        _follow_bridge(d, i, s)
        _follow_shape(d, i, s)
        sum_string(d, i, s)


@kernel
def bridge_motion(d, i, s):
    """Displacement [m] of the bridge at string ``s``, at k and at k - 1."""
    now, before = 0.0, 0.0
    for n in range(8 * i[at.H_BODY]):
        shape, b = d[at.BODY_BASS + n] + d[at.XI + s] * d[at.BODY_SLOPE + n], d[at.BODY_B + n]
        now += shape * d[at.BODY_X + n]
        if b != 0.0:
            before += shape * (d[at.BODY_XS + n] - d[at.BODY_A + n] * d[at.BODY_X + n]) / b
    return now, before


@kernel
def _static_forces(d, i, s):
    """Forces at bridge and contacts that hold the string with its bridge end moved by 1 m, at rest."""
    own_i = at.STRING_I + s * at.STRING_I_SIZE
    n = 1 + count_contacts(i, s)
    for j in range(n):
        for k in range(j + 1):
            value = 0.0
            for tile in range(i[own_i + at.SI_TILE], i[own_i + at.SI_TILE] + i[own_i + at.SI_TILES]):
                c = at.COEF + tile * at.COEF_TILE
                for lane in range(4):
                    both = d[c + at.COEF_COLUMNS + 4 * j + lane] * d[c + at.COEF_COLUMNS + 4 * k + lane]
                    value += both / (1.0 - d[c + at.COEF_A + lane] - flow_back(d, c + lane))
            d[_R + ROW * j + k] = value
        d[_FORCES + j] = 1.0 if j == 0 else 0.0
    for j in range(1, n):
        row = j * at.LANES + s
        held = 1.0 - d[at.FIN_A + row] - d[at.FIN_B + row]
        if held > _TINY:
            d[_R + ROW * j + j] += d[at.FIN_G + row] / held
        else:
            for k in range(n):
                d[_R + ROW * max(j, k) + min(j, k)] = 1.0 if j == k else 0.0
    cholesky(d, _R, n)
    solve_lower(d, _R, n, _FORCES, 1)
    solve_upper(d, _R, n, _FORCES, 1)


@kernel
def _follow_bridge(d, i, s):
    """Give the modes the shape that the string has at rest with its end where the bridge is, at k and k - 1."""
    own_i = at.STRING_I + s * at.STRING_I_SIZE
    _static_forces(d, i, s)
    now, before = bridge_motion(d, i, s)
    n = 1 + count_contacts(i, s)
    for tile in range(i[own_i + at.SI_TILE], i[own_i + at.SI_TILE] + i[own_i + at.SI_TILES]):
        x, c = at.STATE + tile * at.STATE_TILE, at.COEF + tile * at.COEF_TILE
        for lane in range(4):
            a, b, pushed = d[c + at.COEF_A + lane], flow_back(d, c + lane), 0.0
            for j in range(n):
                pushed += d[c + at.COEF_COLUMNS + 4 * j + lane] * d[_FORCES + j]
            shape = pushed / (1.0 - a - b)
            place_mode(d, x + lane, c + lane, shape * now, shape * before)
            d[x + 4 + lane] = d[x + 12 + lane] = 0.0


@kernel
def _follow_shape(d, i, s):
    """Put the contacts where the string is."""
    for j in range(1, 1 + count_contacts(i, s)):
        row = j * at.LANES + s
        now, before = port_motion(d, i, s, j, 0)
        d[at.FIN_Y + row] = now
        d[at.FIN_Y1 + row] = d[at.FIN_A + row] * now + d[at.FIN_B + row] * before
