"""A finger that slides along a sounding string: its columns move every sample, exact every sixteenth, straight between.

Enter a target place and a duration; leave, sample by sample, columns, W, V and sums at the finger's next place. The
modes and the finger keep their motion; the string is shortened by real work of the finger. The pseudo-modes keep their
axes and frequencies until the string's ports change again: anew they would weigh the velocity anew, 1e-6 of the energy.
"""

from ukrt.engine import layout as at
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.linalg import ROW, cholesky, turn_rows
from ukrt.engine.kernels.ports import (
    contact_place,
    count_contacts,
    count_ports,
    invert_ports,
    measure_ports,
    set_columns,
    sum_string,
)  # fmt: skip
from ukrt.engine.kernels.residual import M_STATIC, cut_receptance, pseudo_places

SEGMENT = 16


@kernel
def begin_slide(d, i, s, place, frames):
    """The finger on string ``s`` sets out for ``place`` [m], to arrive after ``frames`` samples."""
    own, own_i = at.STRING + s * at.STRING_D_SIZE, at.STRING_I + s * at.STRING_I_SIZE
    d[own + at.S_MOVE_FROM], d[own + at.S_MOVE_TO] = d[own + at.S_FINGER_PLACE], place
    i[own_i + at.SI_MOVE_AT] = 0
    i[own_i + at.SI_MOVE_LENGTH] = max(1, (frames + SEGMENT - 1) // SEGMENT) * SEGMENT


@kernel
def _place_at(d, i, s, now):
    own, own_i = at.STRING + s * at.STRING_D_SIZE, at.STRING_I + s * at.STRING_I_SIZE
    u = min(now / i[own_i + at.SI_MOVE_LENGTH], 1.0)
    return d[own + at.S_MOVE_FROM] + (d[own + at.S_MOVE_TO] - d[own + at.S_MOVE_FROM]) * u * u * (3.0 - 2.0 * u)


@kernel
def _aim_pseudo_columns(d, i, s, n_ports):
    """Columns of the pseudo-modes at the ports' new places: the factor of R there, axes and frequencies kept."""
    own = at.STRING + s * at.STRING_D_SIZE
    x = own + at.S_PORT_X
    for j in range(n_ports):
        for k in range(n_ports):
            d[M_STATIC + ROW * j + k] = cut_receptance(d, s, 0, d[x + j], d[x + k]) / d[own + at.S_RATIO]
    cholesky(d, M_STATIC, n_ports)
    turn_rows(d, M_STATIC, n_ports, 1 + count_contacts(i, s), own + at.S_PSEUDO_AXES)
    for mode in range(at.RESIDUAL_MODES):
        weight, j = d[own + at.S_PSEUDO_WEIGHT + mode], int(d[own + at.S_PSEUDO + mode])
        _, c = pseudo_places(i, s, mode)
        for port in range(1, n_ports):
            d[c + at.COEF_COLUMNS + 4 * port] = weight * d[M_STATIC + ROW * port + j]


@kernel
def _aim(d, i, s):
    """At the start of a segment: find the columns at its end, and from them the change per sample."""
    own, own_i = at.STRING + s * at.STRING_D_SIZE, at.STRING_I + s * at.STRING_I_SIZE
    first, last = i[own_i + at.SI_TILE], i[own_i + at.SI_TILE] + i[own_i + at.SI_TILES]
    n_ports = count_ports(i, s)
    for tile in range(first, last):
        for k in range(4, 4 * n_ports):
            d[at.SLIDE + tile * 4 * at.COLUMNS + k] = d[at.COEF + tile * at.COEF_TILE + at.COEF_COLUMNS + k]
    place = _place_at(d, i, s, i[own_i + at.SI_MOVE_AT] + SEGMENT)
    d[own + at.S_FINGER_PLACE] = place
    for j in range(i[own_i + at.SI_FINGER]):
        offset = d[at.CONTACTS + (i[own_i + at.SI_FINGER_FROM] + j) * at.CONTACT_SIZE + at.C_OFFSET]
        d[own + at.S_PORT_X + 1 + j] = contact_place(d, own, offset, place)
    set_columns(d, i, s, 1, 1 + i[own_i + at.SI_FINGER])
    _aim_pseudo_columns(d, i, s, n_ports)
    for tile in range(first, last):
        for k in range(4, 4 * n_ports):
            now, goal = at.SLIDE + tile * 4 * at.COLUMNS + k, at.COEF + tile * at.COEF_TILE + at.COEF_COLUMNS + k
            change = (d[goal] - d[now]) / SEGMENT
            d[goal] = d[now]
            d[now] = change


@kernel
def follow_slide(d, i, s):
    """Move the columns of string ``s`` to where the finger will be at the next sample."""
    own_i = at.STRING_I + s * at.STRING_I_SIZE
    if i[own_i + at.SI_MOVE_AT] % SEGMENT == 0:
        _aim(d, i, s)
    n_ports = count_ports(i, s)
    for tile in range(i[own_i + at.SI_TILE], i[own_i + at.SI_TILE] + i[own_i + at.SI_TILES]):
        for k in range(4, 4 * n_ports):
            column = at.COEF + tile * at.COEF_TILE + at.COEF_COLUMNS + k
            d[column] += d[at.SLIDE + tile * 4 * at.COLUMNS + k]
    i[own_i + at.SI_MOVE_AT] += 1
    if i[own_i + at.SI_MOVE_AT] == i[own_i + at.SI_MOVE_LENGTH]:
        i[own_i + at.SI_MOVE_LENGTH] = 0
    measure_ports(d, i, s)
    invert_ports(d, i, s)
    sum_string(d, i, s)
