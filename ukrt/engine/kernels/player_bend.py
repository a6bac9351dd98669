"""How far each sounding note is bent from its key: what its channel's pitch bend asks, as a ratio of tensions.

Enter a channel's bend and range; leave the ratio that a note of that channel and key wants, and gestures on the strings
that sound when it changes. In a zone of MPE the master's bend is added, and all members have one range.
"""

from ukrt.engine import player_layout as at
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.player_log import count
from ukrt.engine.kernels.player_strings import bend_string, string_ratio
from ukrt.engine.kernels.player_zones import NO_ZONE, bend_cents, bend_range, master_of, zone_of


@kernel
def set_bend_range(i, channel, cents):
    """RPN 0: for the channel, and with a member for all members of its zone (M1-100-UM, 2.4)."""
    master = master_of(i, channel)
    for other in range(at.CHANNELS):
        if other == channel or (master >= 0 and master_of(i, other) == master):
            i[at.C_RANGE + other] = cents


@kernel
def let_go(i, s):
    """The key of the string's note has come up, the pedal holds it: a member's note no longer follows its channel."""
    channel = i[at.S_CHANNEL + s]
    if master_of(i, channel) >= 0:
        i[at.S_LET + s] = 1 + bend_range(i, channel)
        i[at.S_LET_BEND + s] = i[at.C_BEND + channel]


@kernel
def follow_tuning(d, i, frame, channel):
    """Bring the channel's sounding strings, and a master's members', to what their notes want now."""
    for s in range(i[at.I_STRINGS]):
        sounding = i[at.S_STATE + s] == at.HELD or i[at.S_STATE + s] == at.PEDALLED
        own = i[at.S_CHANNEL + s]
        if sounding and (own == channel or master_of(i, own) == channel):
            bend_string(d, i, s, frame, string_ratio(d, i, s))


@kernel
def _is_limited(d, i, channel):
    """Whether the notes of a channel, or of one of a master's members, would be bent further than strings can be."""
    for other in range(at.CHANNELS):
        if other == channel or master_of(i, other) == channel:
            if abs(bend_cents(d, i, other)) > at.MAX_BEND_CENTS:
                return True
    return False


@kernel
def _follow_own(d, i, frame, channel):
    """Work out the channel's bend and, if it has changed, bring its sounding strings to it."""
    cents = i[at.C_BEND + channel] * bend_range(i, channel) / 8192.0
    if d[at.D_BEND + channel] == cents:
        return
    d[at.D_BEND + channel] = cents
    count(i, at.BENDS_LIMITED, 1 if _is_limited(d, i, channel) else 0)
    follow_tuning(d, i, frame, channel)


@kernel
def follow_bend(d, i, frame, channel):
    """After a message of a channel: follow its bend, and those of its zone, which may have another range now."""
    zone = zone_of(i, channel)
    for other in range(at.CHANNELS):
        if other == channel or (zone != NO_ZONE and zone_of(i, other) == zone):
            _follow_own(d, i, frame, other)
