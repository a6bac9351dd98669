"""Pseudo-modes of ports that have stayed where they were: each goes on by itself, not only their sum.

Enter a string before and after its pseudo-modes are made anew (residual.py). Two of them share one column at an open
string's bridge; divided anew with every step of a bend or a vibrato they would be heard, 65 dB below the note.
"""

from ukrt.engine import layout as at
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.motion import former_position, place_mode, position
from ukrt.engine.kernels.residual import X_OLD, pseudo_places

_KEPT = at.SCRATCH + 832  # of each pseudo-mode: its column, then Y now, Y before, Z now, Z before
_MOTION, _SIZE = 8, 12
PARALLEL = 1.0 - 1e-12  # square of the cosine between two columns that are one and the same, but for rounding


@kernel
def remember_modes(d, i, s):
    """Note each pseudo-mode's column, and where it is at k and k - 1."""
    for mode in range(at.RESIDUAL_MODES):
        x, c = pseudo_places(i, s, mode)
        kept = _KEPT + _SIZE * mode
        for port in range(at.COLUMNS):
            d[kept + port] = d[c + at.COEF_COLUMNS + 4 * port]
        for half in range(2):
            d[kept + _MOTION + 2 * half] = position(d, x + 4 * half, c)
            d[kept + _MOTION + 1 + 2 * half] = former_position(d, x + 4 * half, c)


@kernel
def _same_ports(d, s, n_old, n_new):
    """Whether the ports of string ``s`` are where ``remember_residual`` found them."""
    own = at.STRING + s * at.STRING_D_SIZE
    for port in range(max(n_old, n_new)):
        if port >= min(n_old, n_new) or d[X_OLD + port] != d[own + at.S_PORT_X + port]:
            return False
    return True


@kernel
def _column_scale(d, i, s, mode):
    """What the old column of a pseudo-mode is to its new one; 0 if they are not parallel, 1 if there is neither."""
    kept, c = _KEPT + _SIZE * mode, pseudo_places(i, s, mode)[1]
    old, new, both = 0.0, 0.0, 0.0
    for port in range(at.COLUMNS):
        column = d[c + at.COEF_COLUMNS + 4 * port]
        old, new, both = old + d[kept + port] ** 2, new + column**2, both + column * d[kept + port]
    if old == 0.0 and new == 0.0:
        return 1.0
    return both / new if both * both > PARALLEL * old * new else 0.0


@kernel
def keep_modes(d, i, s, n_old, n_new):
    """Put every pseudo-mode where it was, if ports and columns are what they were: so the ports do not move."""
    if not _same_ports(d, s, n_old, n_new):
        return
    for mode in range(at.RESIDUAL_MODES):
        if _column_scale(d, i, s, mode) == 0.0:
            return
    for mode in range(at.RESIDUAL_MODES):
        x, c = pseudo_places(i, s, mode)
        kept, scale = _KEPT + _SIZE * mode + _MOTION, _column_scale(d, i, s, mode)
        for half in range(2):
            now, before = scale * d[kept + 2 * half], scale * d[kept + 1 + 2 * half]
            place_mode(d, x + 4 * half, c, now, before)
