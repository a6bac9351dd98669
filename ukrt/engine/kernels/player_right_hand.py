"""What a channel's controllers ask of the right hand: attack, release, muting, planting, strums, variation.

Enter controllers; leave the channel's rows, and what they mean for a note to come: the controller's value, or the
preset's where none has been sent (-1).
"""

from ukrt.engine import controller_layout as cc
from ukrt.engine import player_layout as at
from ukrt.engine.kernels.jit import kernel


@kernel
def set_right_hand(i, channel, controller, value):
    """One controller of a channel; returns whether it is one of the right hand's."""
    if controller == cc.FLESH:
        i[at.C_FLESH + channel] = value
    elif controller == cc.MUTE:
        i[at.C_MUTE + channel] = value
    elif controller == cc.ATTACK:
        i[at.C_ATTACK + channel] = value
    elif controller == cc.STRUM:
        i[at.C_STRUM + channel] = value
    elif controller == cc.DIRECTION:
        i[at.C_DIRECTION + channel] = value
    elif controller == cc.VARIATION:
        i[at.C_VARIATION + channel] = value
    elif controller == cc.PLANTING:
        i[at.C_PLANTING + channel] = value
    else:
        return False
    return True


@kernel
def reset_right_hand(i, channel):
    """CC121: muting, planting, strums and variation as the preset has them; the attack stays, which is sound."""
    i[at.C_MUTE + channel] = i[at.C_PLANTING + channel] = -1
    i[at.C_STRUM + channel] = i[at.C_DIRECTION + channel] = i[at.C_VARIATION + channel] = -1


@kernel
def clear_right_hand(i, channel):
    """As at power-up."""
    reset_right_hand(i, channel)
    i[at.C_FLESH + channel], i[at.C_ATTACK + channel] = -1, cc.MIDDLE


@kernel
def _chosen(i, row, channel, usual):
    value = i[row + channel]
    return value if value >= 0 else i[usual]


@kernel
def muting(i, channel):
    """How much the hand's edge mutes, 0 to 127."""
    return _chosen(i, at.C_MUTE, channel, at.I_USUAL_MUTE)


@kernel
def planting(i, channel):
    """How firmly fingers are planted, 0 to 127."""
    return _chosen(i, at.C_PLANTING, channel, at.I_USUAL_PLANTING)


@kernel
def release_frames(i, channel):
    """How long a pluck takes to let go, longer with the soft pedal; 0: it does so at once."""
    flesh = _chosen(i, at.C_FLESH, channel, at.I_USUAL_FLESH) + at.SOFT_FLESH * i[at.C_SOFT + channel]
    return min(127, flesh) * i[at.I_FLESH] // 127


@kernel
def pull_frames(d, i, channel):
    """How long a pluck pulls; LEAD at the most."""
    return int(d[at.D_FRAMES_OF_PULL + i[at.C_ATTACK + channel]])


@kernel
def strum_frames(d, i, channel):
    """How long the hand takes to sweep over all strings; 0: it does not."""
    value = i[at.C_STRUM + channel]
    return int(d[at.D_FRAMES_OF_STRUM + value]) if value >= 0 else i[at.I_USUAL_STRUM]


@kernel
def direction(i, channel):
    """Where strums begin, as CC 24 has it."""
    return _chosen(i, at.C_DIRECTION, channel, at.I_USUAL_DIRECTION)


@kernel
def variation(i, channel):
    """How much plucks vary, 0 to 127."""
    return _chosen(i, at.C_VARIATION, channel, at.I_USUAL_VARIATION)
