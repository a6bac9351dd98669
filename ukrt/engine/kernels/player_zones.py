"""The zones of MPE: which channels are masters and members, and what a master's messages add to a member's.

Enter the sizes of the zones; leave every channel's part in them. The lower zone has channel 1 as its master and members
from 2 up, the upper one channel 16 and members from 15 down (MIDI Polyphonic Expression, M1-100-UM v1.1, 2.1). A zone
without members is off, and channels outside zones mean what they mean without MPE.
"""

from ukrt.engine import controller_layout as cc
from ukrt.engine import player_layout as at
from ukrt.engine.kernels.jit import kernel

NO_ZONE, LOWER, UPPER = range(3)


@kernel
def zone_members(i, zone):
    """How many members a zone has; before any message the lower one has what the mode gives it."""
    if zone == UPPER:
        return i[at.I_UPPER]
    if i[at.I_LOWER] > 0:
        return i[at.I_LOWER] - 1
    if i[at.I_MODE] == at.GUITAR_MPE:
        return i[at.I_STRINGS]
    return at.MOST_MEMBERS if i[at.I_MODE] == at.MPE else 0


@kernel
def zone_of(i, channel):
    """The zone that a channel belongs to, as master or member."""
    lower, upper = zone_members(i, LOWER), zone_members(i, UPPER)
    if lower > 0 and channel <= lower:
        return LOWER
    return UPPER if upper > 0 and channel >= at.LAST_CHANNEL - upper else NO_ZONE


@kernel
def zone_place(i, channel):
    """0 for the master of a zone, 1, 2, ... for its members in their order, -1 for a channel outside."""
    zone = zone_of(i, channel)
    if zone == NO_ZONE:
        return -1
    return channel if zone == LOWER else at.LAST_CHANNEL - channel


@kernel
def master_of(i, channel):
    """The master of a member channel, -1 for all others."""
    if zone_place(i, channel) < 1:
        return -1
    return 0 if zone_of(i, channel) == LOWER else at.LAST_CHANNEL


@kernel
def bend_range(i, channel):
    """The channel's bend range [cents]: what RPN 0 has set, else MPE's or, outside its zones, the preset's."""
    if i[at.C_RANGE + channel] >= 0:
        return i[at.C_RANGE + channel]
    place = zone_place(i, channel)
    if place < 0:
        return i[at.I_BEND_RANGE]
    return at.MEMBER_RANGE_CENTS if place > 0 else at.MASTER_RANGE_CENTS


@kernel
def bend_cents(d, i, channel):
    """What pitch bends ask of a channel's notes: its own, and its master's on top (M1-100-UM, 2.4)."""
    master = master_of(i, channel)
    return d[at.D_BEND + channel] + (d[at.D_BEND + master] if master >= 0 else 0.0)


@kernel
def share_kept(i, s):
    """Cents by which a string's own bend differs from its channel's: a member's note that only the pedal holds keeps
    the bend that it had when its key came up, as the channel may have another note by now (M1-100-UM, 3.3.3)."""
    if i[at.S_LET + s] == 0:
        return 0.0
    channel = i[at.S_CHANNEL + s]
    kept, moved = i[at.S_LET_BEND + s] * (i[at.S_LET + s] - 1), i[at.C_BEND + channel] * bend_range(i, channel)
    return (kept - moved) / 8192.0


@kernel
def vibrato_asked(i, s):
    """The largest of wheel, channel and key pressure that hold for the string's note, and of its master's."""
    channel, most = i[at.S_CHANNEL + s], 0
    if i[at.S_LET + s] == 0:
        most = max(i[at.C_WHEEL + channel], max(i[at.C_PRESSURE + channel], i[at.S_PRESSURE + s]))
    master = master_of(i, channel)
    if master >= 0:
        most = max(most, max(i[at.C_WHEEL + master], i[at.C_PRESSURE + master]))
    return most


@kernel
def timbre(i, channel):
    """CC 74 of a channel, moved by as much as its master's is off the middle."""
    value, master = i[at.C_PLACE + channel], master_of(i, channel)
    if master >= 0:
        value += i[at.C_PLACE + master] - cc.MIDDLE
    return max(0, min(127, value))
