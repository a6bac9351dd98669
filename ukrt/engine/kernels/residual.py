"""What the basis cuts off, given back to a string's ports: pseudo-modes with the right compliance, inertia, loss.

Enter the ports of one string (bridge, contacts, pluck); leave pseudo-modes in the string's last two tiles. Their static
compliance R is that of all cut modes, R = C C^T; each column of C is carried by one pseudo-mode, or, for the first two
columns of a string held at no more than one point, by two. C is turned to the axes in which C^-1 (.) C^-T, the whole
discrete receptance at the first matching frequency, is diagonal for bridge and contacts; with the right frequencies of
the pseudo-modes it is then right between all of them. Along these axes their losses, and of two the second frequency,
are right as well: the cut modes are added and what the step does wrong to the modes of the basis is taken out. In steps
a mode's receptance is the continuous one times rho = tan(w dt/2) / (w dt/2) near its pole; a factor common to all
subsystems moves no pole, so rho times the continuous receptance is what is aimed at.
"""

import math

from ukrt.engine import layout as at
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.linalg import (
    ROW,
    along_axis,
    cholesky,
    principal_axes,
    solve_lower,
    solve_upper,
    turn_rows,
    whiten,
)
from ukrt.engine.kernels.motion import former_position, place_mode, position, set_flow

M_STATIC, M_OLD, M_CROSS, M_REAL, M_LOSS = (at.SCRATCH + 64 * k for k in (0, 1, 2, 3, 5))  # the last two: MATCHES each
V_MOVED = at.SCRATCH + 448  # residual displacement of the old ports: Y now, Y before, Z now, Z before; 8 each
V_NEXT = at.SCRATCH + 480
X_OLD = at.SCRATCH + 512  # the old ports' places
HIGHEST = 3.96  # (2 sin(theta / 2))^2 of a pseudo-mode; 4 is the limit of the step
UPPER = 3.9  # the same of the upper one of two
MOST_DAMPED = 1.0  # decay of a pseudo-mode in one step [Np]


@kernel
def _table(d, table, distance, length):
    """Cubic interpolation of a residual table at ``distance`` in [0, 2 L]; the function is odd about L."""
    sign = 1.0
    if distance > length:
        distance, sign = 2.0 * length - distance, -1.0
    place = min(max(distance, 0.0) / length, 1.0) * (at.TABLE - 1)
    first = min(max(int(place) - 1, 0), at.TABLE - 4)
    u = place - first
    y0, y1, y2, y3 = d[table + first], d[table + first + 1], d[table + first + 2], d[table + first + 3]
    left = -y0 * (u - 1.0) * (u - 2.0) * (u - 3.0) / 6.0 + y1 * u * (u - 2.0) * (u - 3.0) / 2.0
    right = -y2 * u * (u - 1.0) * (u - 3.0) / 2.0 + y3 * u * (u - 1.0) * (u - 2.0) / 6.0
    return sign * (left + right)


@kernel
def cut_receptance(d, s, kind, x, y):
    """Table ``kind`` of what string ``s`` lacks, between places ``x`` and ``y`` [m], at the tension at rest."""
    table = at.TABLES_AT + (s * at.TABLES + kind) * at.TABLE
    length = d[at.STRING + s * at.STRING_D_SIZE + at.S_LENGTH]
    return 0.5 * (_table(d, table, abs(x - y), length) - _table(d, table, x + y, length))


@kernel
def _fill(d, s, kind, rows, n_rows, columns, n_columns, out, scale):
    for j in range(n_rows):
        for k in range(n_columns):
            d[out + ROW * j + k] = scale * cut_receptance(d, s, kind, d[rows + j], d[columns + k])


@kernel
def pseudo_places(i, s, j):
    """Offsets of pseudo-mode ``j`` in its state and coefficient tile."""
    own_i = at.STRING_I + s * at.STRING_I_SIZE
    tile = i[own_i + at.SI_TILE] + i[own_i + at.SI_TILES] - at.PSEUDO_TILES + j // 4
    return at.STATE + tile * at.STATE_TILE + j % 4, at.COEF + tile * at.COEF_TILE + j % 4


@kernel
def remember_residual(d, i, s, n_old):
    """Note the residual displacement of the ``n_old`` ports of string ``s``, at k and k - 1, and their places."""
    own = at.STRING + s * at.STRING_D_SIZE
    for port in range(n_old):
        d[X_OLD + port] = d[own + at.S_PORT_X + port]
        for k in range(4):
            d[V_MOVED + 8 * k + port] = 0.0
        for j in range(at.RESIDUAL_MODES):
            x, c = pseudo_places(i, s, j)
            column = d[c + at.COEF_COLUMNS + 4 * port]
            if column != 0.0:
                for half in range(2):
                    d[V_MOVED + 16 * half + port] += column * position(d, x + 4 * half, c)
                    d[V_MOVED + 16 * half + 8 + port] += column * former_position(d, x + 4 * half, c)


@kernel
def _carry_over(d, s, n_old, n_new):
    """Residual displacement of the new ports: r_new = R[new, old] R[old, old]^-1 r_old, of least energy."""
    own = at.STRING + s * at.STRING_D_SIZE
    _fill(d, s, 0, X_OLD, n_old, X_OLD, n_old, M_OLD, 1.0)
    cholesky(d, M_OLD, n_old)
    _fill(d, s, 0, own + at.S_PORT_X, n_new, X_OLD, n_old, M_CROSS, 1.0)
    for k in range(4):
        solve_lower(d, M_OLD, n_old, V_MOVED + 8 * k, 1)
        solve_upper(d, M_OLD, n_old, V_MOVED + 8 * k, 1)
        for port in range(n_new):
            value = 0.0
            for old in range(n_old):
                value += d[M_CROSS + ROW * port + old] * d[V_MOVED + 8 * k + old]
            d[V_NEXT + 8 * k + port] = value
    for k in range(4):
        for port in range(n_new):
            d[V_MOVED + 8 * k + port] = d[V_NEXT + 8 * k + port]


@kernel
def _matrices(d, i, s, n_ports):
    """R, and what the receptance lacks at the matching frequencies, real part and loss."""
    own, own_i = at.STRING + s * at.STRING_D_SIZE, at.STRING_I + s * at.STRING_I_SIZE
    places, scale = own + at.S_PORT_X, 1.0 / d[own + at.S_RATIO]
    _fill(d, s, 0, places, n_ports, places, n_ports, M_STATIC, scale)
    first, modes = i[own_i + at.SI_TILE], i[own_i + at.SI_TILES] - at.PSEUDO_TILES
    for match in range(at.MATCHES):
        real, loss = M_REAL + 64 * match, M_LOSS + 64 * match
        _fill(d, s, 1 + 2 * match, places, n_ports, places, n_ports, real, scale)
        _fill(d, s, 2 + 2 * match, places, n_ports, places, n_ports, loss, scale)
        for j in range(n_ports):
            for k in range(j + 1):
                error, lost = 0.0, 0.0
                for tile in range(first, first + modes):
                    c = at.COEF + tile * at.COEF_TILE + at.COEF_COLUMNS
                    wrong = at.ERROR + tile * at.ERROR_TILE + 8 * match
                    for lane in range(4):
                        both = d[c + 4 * j + lane] * d[c + 4 * k + lane]
                        error += both * d[wrong + lane]
                        lost += both * d[wrong + 4 + lane]
                d[real + ROW * j + k] -= error
                d[loss + ROW * j + k] -= lost
                d[real + ROW * k + j], d[loss + ROW * k + j] = d[real + ROW * j + k], d[loss + ROW * j + k]


@kernel
def _one_mode(real, loss, q, sine, lowest):
    """Theta^2 and decay per step of one pseudo-mode of unit compliance that is right at one frequency."""
    square = real * q / (real - 1.0) if real > 1.0 else HIGHEST
    square = min(max(square, lowest), HIGHEST)
    return square, loss * (square - q) ** 2 / (2.0 * square * sine)


@kernel
def _two_modes(real_1, real_2, q_1, q_2):
    """Share and theta^2 of the lower of two pseudo-modes right at two frequencies; share 0: there is no such pair."""
    k_1 = (real_1 * (1.0 - q_1 / UPPER) - 1.0) / q_1
    k_2 = (real_2 * (1.0 - q_2 / UPPER) - 1.0) / q_2
    below = k_1 * q_1 - k_2 * q_2
    inverse = (k_1 - k_2) / below if below != 0.0 else 0.0
    if not (inverse * 1.2 * q_2 < 1.0 and inverse * (UPPER - 0.1) > 1.0):
        return 0.0, 0.0
    share = k_1 * (1.0 - q_1 * inverse) / (inverse - 1.0 / UPPER)
    if not (share > 0.0 and share < 1.0):
        return 0.0, 0.0
    return share, 1.0 / inverse


@kernel
def _two_losses(loss_1, loss_2, q_1, q_2, sine_1, sine_2, share, square):
    """Decays per step of two pseudo-modes whose losses are right at two frequencies, neither below zero."""
    a_1 = share * 2.0 * square * sine_1 / (square - q_1) ** 2
    a_2 = share * 2.0 * square * sine_2 / (square - q_2) ** 2
    b_1 = (1.0 - share) * 2.0 * UPPER * sine_1 / (UPPER - q_1) ** 2
    b_2 = (1.0 - share) * 2.0 * UPPER * sine_2 / (UPPER - q_2) ** 2
    scale = a_1 * b_2 - a_2 * b_1
    lower, upper = loss_1 / a_1, 0.0
    if scale != 0.0:
        first, second = (loss_1 * b_2 - loss_2 * b_1) / scale, (loss_2 * a_1 - loss_1 * a_2) / scale
        if first >= 0.0 and second >= 0.0:
            lower, upper = first, second
        elif first < 0.0:
            lower, upper = 0.0, loss_1 / b_1
    return lower, upper


@kernel
def _place_mode(d, i, s, mode, j, n_ports, share, square, decay):
    """Write pseudo-mode ``mode``: ``share`` of column ``j`` of C, with its part of the displacement carried over."""
    x, c = pseudo_places(i, s, mode)
    decay = min(max(decay, 0.0), MOST_DAMPED)
    a, b = 2.0 * math.exp(-decay) * (1.0 - 0.5 * square), -math.exp(-2.0 * decay)
    root, part = math.sqrt(1.0 - a - b), math.sqrt(share)
    own = at.STRING + s * at.STRING_D_SIZE
    d[own + at.S_PSEUDO + mode], d[own + at.S_PSEUDO_WEIGHT + mode] = float(j), root * part
    set_flow(d, c, a, b, 0.0)
    for port in range(n_ports):
        d[c + at.COEF_COLUMNS + 4 * port] = root * part * d[M_STATIC + ROW * port + j]
    for half in range(2):
        now, before = part * d[V_MOVED + 16 * half + j] / root, part * d[V_MOVED + 16 * half + 8 + j] / root
        place_mode(d, x + 4 * half, c, now, before)


@kernel
def _clear_modes(d, i, s):
    for mode in range(at.RESIDUAL_MODES):
        x, c = pseudo_places(i, s, mode)
        d[at.STRING + s * at.STRING_D_SIZE + at.S_PSEUDO_WEIGHT + mode] = 0.0
        for k in range(at.COEF_TILE // 4):
            d[c + 4 * k] = 0.0
        for k in range(4):
            d[x + 4 * k] = 0.0


@kernel
def _carries(d, n, j):
    """Whether column ``j`` of C (at M_STATIC) is there at all: not where two ports are one."""
    total = 0.0
    for port in range(n):
        total += d[M_STATIC + ROW * port + j] ** 2
    return total > 0.0


@kernel
def _turn_to_axes(d, axes, n, n_ports):
    """Turn C (at M_STATIC), the displacement and what the receptance lacks to the axes of its first real part.

    Only the first ``n`` columns are, those of bridge and contacts: the last belongs to the pluck alone, so that its
    coming and going changes nothing about the others.
    """
    principal_axes(d, M_REAL, n, axes)
    for m in (M_REAL + 64, M_LOSS, M_LOSS + 64):
        for j in range(n):
            d[V_NEXT + j] = along_axis(d, m, n, axes, j)
        for j in range(n):
            d[m + (ROW + 1) * j] = d[V_NEXT + j]
    turn_rows(d, M_STATIC, n_ports, n, axes)
    turn_rows(d, V_MOVED, 4, n, axes)


@kernel
def rebuild_residual(d, i, s, n_old, n_new):
    """Make the pseudo-modes of string ``s`` for its ``n_new`` ports and give them the motion; returns how many."""
    own, own_i = at.STRING + s * at.STRING_D_SIZE, at.STRING_I + s * at.STRING_I_SIZE
    _carry_over(d, s, n_old, n_new)
    _matrices(d, i, s, n_new)
    bend = math.sqrt(d[own + at.S_RATIO])
    phase_1, phase_2 = d[own + at.S_MATCH_1] * bend, d[own + at.S_MATCH_2] * bend
    q_1, q_2 = (2.0 * math.sin(0.5 * phase_1)) ** 2, (2.0 * math.sin(0.5 * phase_2)) ** 2
    lowest = (2.0 * math.sin(min(math.pi * d[own + at.S_BANDWIDTH] / d[at.METER + at.M_RATE], 1.4))) ** 2
    cholesky(d, M_STATIC, n_new)
    for match in range(at.MATCHES):
        whiten(d, M_STATIC, n_new, M_REAL + 64 * match)
        whiten(d, M_STATIC, n_new, M_LOSS + 64 * match)
    for k in range(4):
        solve_lower(d, M_STATIC, n_new, V_MOVED + 8 * k, 1)
    n_contacts = i[own_i + at.SI_FINGER] + i[own_i + at.SI_DAMPER]
    _turn_to_axes(d, own + at.S_PSEUDO_AXES, 1 + n_contacts, n_new)
    _clear_modes(d, i, s)
    mode = 0
    for j in range(n_new):
        place = (ROW + 1) * j
        if not _carries(d, n_new, j):
            continue
        share, square = 0.0, 0.0
        if j < 2 and n_contacts < 2:
            share, square = _two_modes(d[M_REAL + place], d[M_REAL + 64 + place], q_1, q_2)
        if share > 0.0:
            lower, upper = _two_losses(
                d[M_LOSS + place], d[M_LOSS + 64 + place], q_1, q_2, math.sin(phase_1), math.sin(phase_2), share, square
            )
            _place_mode(d, i, s, mode, j, n_new, share, square, lower)
            _place_mode(d, i, s, mode + 1, j, n_new, 1.0 - share, UPPER, upper)
            mode += 2
        else:
            square, decay = _one_mode(d[M_REAL + place], d[M_LOSS + place], q_1, math.sin(phase_1), lowest)
            _place_mode(d, i, s, mode, j, n_new, 1.0, square, decay)
            mode += 1
    return mode
