"""Where a string's mode is: the one place that knows how a state tile keeps it.

The sweep wants D x[k], which the tension modulation of the next sample pushes along; so that is what is kept, and the
coefficient of x[k] in the free flow is kept as b / D. Pseudo-modes feel no tension: D is 0, and x[k] itself is kept.
``x`` is the place of a mode in its state tile (plus 4 for Z), ``c`` in its coefficient tile.
"""

from ukrt.engine import layout as at
from ukrt.engine.kernels.jit import kernel


@kernel
def flow_back(d, c):
    """b of the free flow x*[k+1] = a x[k] + b x[k-1]; 0 where there is no mode."""
    weight = d[c + at.COEF_D]
    return d[c + at.COEF_BACK] * weight if weight != 0.0 else d[c + at.COEF_BACK]


@kernel
def position(d, x, c):
    """x[k] = q[k] / sqrt(g) of one mode."""
    weight = d[c + at.COEF_D]
    return d[x] / weight if weight != 0.0 else d[x]


@kernel
def former_position(d, x, c):
    """x[k-1], told from x[k] and x*[k+1]; 0 where there is no mode."""
    b = flow_back(d, c)
    return (d[x + 8] - d[c + at.COEF_A] * position(d, x, c)) / b if b != 0.0 else 0.0


@kernel
def place_mode(d, x, c, now, before):
    """Put a mode at x[k] = ``now``, x[k-1] = ``before``."""
    foresee(d, x, c, now, d[c + at.COEF_A] * now + flow_back(d, c) * before)


@kernel
def foresee(d, x, c, now, coming):
    """Put a mode at x[k] = ``now``, x*[k+1] = ``coming``."""
    weight = d[c + at.COEF_D]
    d[x] = now * weight if weight != 0.0 else now
    d[x + 8] = coming


@kernel
def set_flow(d, c, a, b, weight):
    """Let a mode flow freely by ``a, b`` and feel tension by D = ``weight`` (0: a pseudo-mode); its place is to be set.
    """
    d[c + at.COEF_A], d[c + at.COEF_D] = a, weight
    d[c + at.COEF_BACK] = b / weight if weight != 0.0 else b
