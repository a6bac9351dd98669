"""What the basis cuts off, given back to a string's ports: pseudo-modes with the right compliance, inertia, loss.

Enter the ports of one string (bridge, contacts, pluck); leave one pseudo-mode per port, in the string's last two
tiles. Their static compliance R is that of all cut modes, R = C C^T with C lower triangular and the bridge first; each
pseudo-mode is a column of C. Frequency and damping of each are chosen so that, along the diagonal of C^-1 (.) C^-T,
the whole discrete receptance (cut modes, plus what the step does wrong to the modes it has) is right at zero and at
the matching frequency. The discrete receptance of every exact mode is the continuous one times rho = tan(w dt/2) / (w
dt/2) near its pole; a factor common to all subsystems moves no pole, so rho times the continuous receptance is what is
aimed at.
"""

import math

from ukrt.engine import layout as at
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.linalg import ROW, cholesky, solve_lower, solve_upper, whiten

M_STATIC, M_MATCHED, M_LOSS, M_OLD, M_CROSS = (at.SCRATCH + 64 * k for k in range(5))
V_MOVED = at.SCRATCH + 320  # residual displacement of the old ports: Y now, Y before, Z now, Z before; 8 each
V_NEXT = at.SCRATCH + 352
X_OLD = at.SCRATCH + 384  # the old ports' places
HIGHEST = 3.96  # (2 sin(theta/2))^2 of a pseudo-mode; 4 is the limit of the step
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
def _pseudo_places(i, s, j):
    """Offsets of pseudo-mode ``j`` in its state and coefficient tile."""
    own_i = at.STRING_I + s * at.STRING_I_SIZE
    tile = i[own_i + at.SI_TILE] + i[own_i + at.SI_TILES] - 2 + j // 4
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
            x, c = _pseudo_places(i, s, j)
            column = d[c + at.COEF_COLUMNS + 4 * port]
            if column != 0.0:
                for half in range(2):
                    now = d[x + 4 * half]
                    before = (d[x + 8 + 4 * half] - d[c + at.COEF_A] * now) / d[c + at.COEF_B]
                    d[V_MOVED + 16 * half + port] += column * now
                    d[V_MOVED + 16 * half + 8 + port] += column * before


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
    """R, and what the receptance should add at the matching frequency and in loss, the basis' own error taken out."""
    own, own_i = at.STRING + s * at.STRING_D_SIZE, at.STRING_I + s * at.STRING_I_SIZE
    places, ratio = own + at.S_PORT_X, d[own + at.S_RATIO]
    _fill(d, s, 0, places, n_ports, places, n_ports, M_STATIC, 1.0 / ratio)
    _fill(d, s, 1, places, n_ports, places, n_ports, M_MATCHED, 1.0 / (ratio * ratio))
    _fill(d, s, 2, places, n_ports, places, n_ports, M_LOSS, 1.0 / (ratio * math.sqrt(ratio)))
    rate, match = d[at.METER + at.M_RATE], d[at.METER + at.M_MATCH]
    half = 0.5 * match / rate
    rho, square = math.tan(half) / half, (2.0 * rate * math.sin(half)) ** 2
    first, modes = i[own_i + at.SI_TILE], i[own_i + at.SI_TILES] - 2
    for j in range(n_ports):
        for k in range(j + 1):
            static, loss = 0.0, 0.0
            for tile in range(first, first + modes):
                c = at.COEF + tile * at.COEF_TILE
                for lane in range(4):
                    both = d[c + at.COEF_COLUMNS + 4 * j + lane] * d[c + at.COEF_COLUMNS + 4 * k + lane]
                    static += both * d[c + at.COEF_STATIC + lane]
                    loss += both * d[c + at.COEF_LOSS + lane]
            cut = d[M_STATIC + ROW * j + k]
            wanted = rho * (cut + match * match * d[M_MATCHED + ROW * j + k]) - cut
            d[M_MATCHED + ROW * j + k] = wanted / square - static
            d[M_LOSS + ROW * j + k] -= loss
            d[M_MATCHED + ROW * k + j], d[M_LOSS + ROW * k + j] = d[M_MATCHED + ROW * j + k], d[M_LOSS + ROW * j + k]
    for j in range(i[own_i + at.SI_FINGER]):
        contact = at.CONTACTS + j * at.CONTACT_SIZE
        d[M_MATCHED + (ROW + 1) * (j + 1)] -= d[contact + at.C_STATIC]
        d[M_LOSS + (ROW + 1) * (j + 1)] -= d[contact + at.C_LOSS]


@kernel
def rebuild_residual(d, i, s, n_old, n_new):
    """Make the pseudo-modes of string ``s`` for its ``n_new`` ports and give them the displacement noted before."""
    own = at.STRING + s * at.STRING_D_SIZE
    _carry_over(d, s, n_old, n_new)
    _matrices(d, i, s, n_new)
    rate, match = d[at.METER + at.M_RATE], d[at.METER + at.M_MATCH]
    square = (2.0 * math.sin(0.5 * match / rate)) ** 2
    lowest = (2.0 * math.sin(min(math.pi * d[own + at.S_BANDWIDTH] / rate, 1.4))) ** 2
    cholesky(d, M_STATIC, n_new)
    whiten(d, M_STATIC, n_new, M_MATCHED)
    whiten(d, M_STATIC, n_new, M_LOSS)
    for k in range(4):
        solve_lower(d, M_STATIC, n_new, V_MOVED + 8 * k, 1)
    for j in range(at.RESIDUAL_MODES):
        x, c = _pseudo_places(i, s, j)
        for k in range(at.COEF_TILE // 4):
            d[c + 4 * k] = 0.0
        for k in range(4):
            d[x + 4 * k] = 0.0
        if j < n_new and d[M_STATIC + (ROW + 1) * j] > 0.0:
            wanted = d[M_MATCHED + (ROW + 1) * j] * rate * rate
            theta_square = (1.0 + wanted * square) / wanted if wanted > 0.0 else HIGHEST
            theta_square = min(max(theta_square, lowest), HIGHEST)
            sigma = min(0.5 * max(d[M_LOSS + (ROW + 1) * j], 0.0) * theta_square * rate, MOST_DAMPED)
            a = 2.0 * math.exp(-sigma) * (1.0 - 0.5 * theta_square)
            b = -math.exp(-2.0 * sigma)
            root = math.sqrt(1.0 - a - b)
            d[c + at.COEF_A], d[c + at.COEF_B] = a, b
            for port in range(n_new):
                d[c + at.COEF_COLUMNS + 4 * port] = root * d[M_STATIC + ROW * port + j]
            for half in range(2):
                now, before = d[V_MOVED + 16 * half + j] / root, d[V_MOVED + 16 * half + 8 + j] / root
                d[x + 4 * half] = now
                d[x + 8 + 4 * half] = a * now + b * before
