"""When to shed: the load of each block enters, the level that is wanted leaves."""

from ukrt.engine.kernels.jit import kernel


@kernel
def watch_load(si, sd, load):
    """Look at one more block's load [1]."""
