"""What is least heard is left out while the computer is too slow."""

from ukrt.engine import layout as at
from ukrt.engine.kernels.jit import kernel


@kernel
def set_shed(d, i, v, vi, level):
    """Let ``level`` be shed from now on."""
    i[at.H_SHED] = level


@kernel
def tend_shed(d, i, now):
    """Look after what is shed; at multiples of 4096 frames."""
