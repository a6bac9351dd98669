"""What sounds and is held goes over from one instance to another."""

from ukrt.engine import player_layout as player
from ukrt.engine.kernels.jit import kernel


@kernel
def transfer_state(d0, i0, v0, vi0, d1, i1, v1, vi1, now):
    """Take player's state, strings, fingers and body over from instance 0 to instance 1."""
    for k in range(player.I_STATE, player.I_END):
        i1[k] = i0[k]
    for k in range(player.D_STATE, player.D_END):
        d1[k] = d0[k]
