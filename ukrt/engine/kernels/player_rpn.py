"""Registered parameters of 14 bits, kept by channel: fine tuning (1), coarse tuning (2), depth of vibrato (5).

Enter data entries (CC 6, 38, 96, 97); leave the channel's rows. Strings that sound follow fine tuning, since
``follow_bend`` comes after every controller.
"""

from ukrt.engine import controller_layout as cc
from ukrt.engine import player_layout as at
from ukrt.engine.kernels.jit import kernel


@kernel
def vibrato_depth(d, i, channel):
    """Vibrato of the channel at full wheel or pressure [cents]: what RPN 5 has set, else the preset's."""
    depth = i[at.C_DEPTH + channel]
    return depth * 100.0 / 128.0 if depth >= 0 else d[at.D_VIBRATO_CENTS]


@kernel
def _entered(value, controller, data):
    """A value of 14 bits after a data entry."""
    if controller == cc.DATA_MSB:
        return data * 128 + value % 128
    if controller == cc.DATA_LSB:
        return value - value % 128 + data
    return max(0, min(16383, value + (1 if controller == cc.INCREMENT else -1)))


@kernel
def enter_parameter(d, i, channel, controller, data):
    """A data entry for the RPN that the channel has chosen; returns whether it is one of these."""
    rpn = i[at.C_RPN + channel]
    if rpn == at.RPN_FINE:
        i[at.C_FINE + channel] = _entered(i[at.C_FINE + channel], controller, data)
    elif rpn == at.RPN_COARSE:
        if controller == cc.DATA_MSB:
            i[at.C_COARSE + channel] = data
        elif controller != cc.DATA_LSB:
            step = 1 if controller == cc.INCREMENT else -1
            i[at.C_COARSE + channel] = max(0, min(127, i[at.C_COARSE + channel] + step))
    elif rpn == at.RPN_DEPTH:
        now = int(vibrato_depth(d, i, channel) * 128.0 / 100.0 + 0.5)
        i[at.C_DEPTH + channel] = min(at.MAX_DEPTH, _entered(now, controller, data))
    else:
        return False
    return True


@kernel
def clear_parameters(i, channel):
    """As at power-up."""
    i[at.C_FINE + channel], i[at.C_COARSE + channel] = at.MIDDLE_FINE, at.MIDDLE_COARSE
    i[at.C_DEPTH + channel] = -1
