"""How far each sounding note is bent from its key: what its channel's pitch bend asks, as a ratio of tensions.

Enter a channel's bend and range; leave the ratio that a note of that channel and key wants, and gestures on the strings
that sound when it changes.
"""

from ukrt.engine import player_layout as at
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.player_log import count
from ukrt.engine.kernels.player_strings import bend_string, note_ratio


@kernel
def bend_range(i, channel):
    """The channel's bend range [cents]: what RPN 0 has set, else the preset's."""
    return i[at.C_RANGE + channel] if i[at.C_RANGE + channel] >= 0 else i[at.I_BEND_RANGE]


@kernel
def follow_tuning(d, i, frame, channel):
    """Bring the channel's sounding strings to what their notes want now."""
    for s in range(i[at.I_STRINGS]):
        sounding = i[at.S_STATE + s] == at.HELD or i[at.S_STATE + s] == at.PEDALLED
        if sounding and i[at.S_CHANNEL + s] == channel:
            bend_string(d, i, s, frame, note_ratio(d, i, channel, i[at.S_KEY + s]))


@kernel
def follow_bend(d, i, frame, channel):
    """Work out the channel's bend and, if it has changed, bring its sounding strings to it."""
    cents = i[at.C_BEND + channel] * bend_range(i, channel) / 8192.0
    if d[at.D_BEND + channel] == cents:
        return
    count(i, at.BENDS_LIMITED, 1 if abs(cents) > at.MAX_BEND_CENTS else 0)
    d[at.D_BEND + channel] = cents
    follow_tuning(d, i, frame, channel)
