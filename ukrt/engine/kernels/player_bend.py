"""How far each sounding note is bent from its key: what its channel's pitch bend and fine tuning ask, as a ratio of
tensions; and the whole guitar's fine tuning.

Enter a channel's bend and range; leave the ratio that a note of that channel wants, and gestures on the strings
that sound when it changes. In a zone of MPE the master's bend is added, and all members have one range.
"""

from ukrt.engine import player_layout as at
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.player_log import count
from ukrt.engine.kernels.player_strings import bend_string, rest_ratio, set_tension, string_ratio
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
    """Work out the channel's bend and fine tuning and, if they have changed, bring its sounding strings to them."""
    cents = i[at.C_BEND + channel] * bend_range(i, channel) / 8192.0
    cents += (i[at.C_FINE + channel] - at.MIDDLE_FINE) * (100.0 / 8192.0)
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


@kernel
def follow_master(d, i, frame):
    """Bring all strings to a new fine tuning of the whole guitar; what is being damped gets there with its rest."""
    rest = rest_ratio(i)
    for s in range(i[at.I_STRINGS]):
        state = i[at.S_STATE + s]
        if state == at.HELD or state == at.PEDALLED:
            bend_string(d, i, s, frame, string_ratio(d, i, s))
        elif d[at.D_TENSION + s] != rest and i[at.S_TENSION_FRAME + s] > frame + i[at.I_LEAD]:
            set_tension(d, i, s, i[at.S_TENSION_FRAME + s], rest, i[at.I_BEND_RAMP], 0.0)
        elif d[at.D_TENSION + s] != rest:
            d[at.D_DEPTH + s] = 0.0
            bend_string(d, i, s, frame, rest)
