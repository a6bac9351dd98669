"""Messages that say what channels are: zones of MPE (RPN 6), one voice or many (CC 126, 127), and a zone's controllers.

Enter every controller of a channel; leave the zones and modes as it asks, or hand it to ``control_change``, for all
channels of a zone if it came on its master.
"""

from ukrt.engine import controller_layout as cc
from ukrt.engine import player_layout as at
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.player_bend import follow_bend
from ukrt.engine.kernels.player_controllers import clear_channel, control_change, notes_off, set_pedals
from ukrt.engine.kernels.player_log import count
from ukrt.engine.kernels.player_mono import is_percussion, mode_string
from ukrt.engine.kernels.player_zones import LOWER, NO_ZONE, UPPER, master_of, zone_members, zone_of, zone_place


@kernel
def _size_zone(i, zone, members):
    """A zone gets its members, the other one what is left; of 16 channels two are then masters (M1-100-UM, 2.1.1)."""
    other = zone_members(i, LOWER if zone == UPPER else UPPER)
    if members > 0:
        other = max(0, min(other, at.CHANNELS - 2 - members))
    lower, upper = (members, other) if zone == LOWER else (other, members)
    i[at.I_LOWER], i[at.I_UPPER] = lower + 1, upper


@kernel
def _part(i, channel):
    """A number for the zone that a channel belongs to and for what it is there."""
    return 2 * zone_of(i, channel) + (1 if zone_place(i, channel) == 0 else 0)


@kernel
def _set_zone(d, i, frame, zone, members):
    """The MPE Configuration Message: channels that come to or leave a zone end their notes and are as at power-up, and
    the zone's bend ranges are what MPE begins with."""
    for channel in range(at.CHANNELS):
        i[at.X_REST + channel] = _part(i, channel)
    _size_zone(i, zone, members)
    for channel in range(at.CHANNELS):
        if _part(i, channel) != i[at.X_REST + channel]:
            chosen = i[at.C_RPN + channel]
            set_pedals(d, i, frame, channel, cc.RESET, 0)
            notes_off(d, i, frame, channel)
            clear_channel(d, i, channel)
            i[at.C_RPN + channel] = chosen
        if zone_of(i, channel) == zone:
            i[at.C_RANGE + channel] = -1
    for channel in range(at.CHANNELS):
        follow_bend(d, i, frame, channel)
    count(i, at.ZONES_SET)


@kernel
def _zone_asked(i, channel, members):
    """The zone that a data entry is about; none but on channels 1 and 16 with RPN 6 chosen, up to 15 members. In guitar
    mode channels are strings, whatever a message says."""
    if i[at.C_RPN + channel] != cc.ZONE_RPN or members > at.MOST_MEMBERS or i[at.I_MODE] == at.GUITAR:
        return NO_ZONE
    if channel == 0:
        return LOWER
    return UPPER if channel == at.LAST_CHANNEL else NO_ZONE


@kernel
def _set_voices(d, i, frame, channel, voices):
    """One voice (1 + the channel that said so) or many (-1) for a channel, whose keys come up."""
    notes_off(d, i, frame, channel)
    i[at.C_MONO + channel] = voices


@kernel
def _mono_or_poly(d, i, frame, channel, controller, value):
    """CC 126: as many channels as its value says, from its own on, have one voice each (0: as many as strings).
    CC 127: those that were made so with it have many. In a zone both are about its members."""
    zone, mono = zone_of(i, channel), controller == cc.MONO
    last = channel + (value if value > 0 else i[at.I_STRINGS]) - 1
    first_string = i[at.I_MODE] == at.GUITAR and channel == i[at.I_BASE]
    for other in range(at.CHANNELS):
        if zone != NO_ZONE:
            meant = zone_of(i, other) == zone and master_of(i, other) >= 0
        elif mono:
            meant = channel <= other <= last
        else:
            joined = i[at.C_MONO + other] == channel + 1 or (first_string and mode_string(i, other) > 0)
            meant = other == channel or joined
        if meant:
            _set_voices(d, i, frame, other, channel + 1 if mono else -1)


@kernel
def _is_for_zone(controller):
    """Whether a master's controller is as if each member had sent it. Parameters are the channel's that chooses them,
    and CC 74 is combined with the members' own."""
    parameter = controller in (cc.DATA_MSB, cc.DATA_LSB) or cc.INCREMENT <= controller <= cc.RPN_MSB
    return not parameter and controller != cc.PLACE


@kernel
def channel_control(d, i, frame, channel, controller, value):
    """One controller message of a channel."""
    zone = _zone_asked(i, channel, value) if controller == cc.DATA_MSB else NO_ZONE
    if zone != NO_ZONE:
        _set_zone(d, i, frame, zone, value)
    elif controller == cc.MONO or controller == cc.POLY:
        _mono_or_poly(d, i, frame, channel, controller, value)
    else:
        ignored = i[at.I_COUNTERS + at.CONTROLLERS_IGNORED]
        for other in range(at.CHANNELS if _is_for_zone(controller) else 0):
            if master_of(i, other) == channel:
                control_change(d, i, frame, other, controller, value)
        i[at.I_COUNTERS + at.CONTROLLERS_IGNORED] = ignored  # one message is counted once
        control_change(d, i, frame, channel, controller, value)


@kernel
def clear_zones(i):
    """Zones as the mode has them."""
    i[at.I_LOWER], i[at.I_UPPER] = 0, 0


@kernel
def adopt_mode(d, i, now, mode_before, base_before):
    """Another guitar goes on with what was played on one of another mode: zones and voices are as its own mode has
    them, and the keys of a channel 10 that has become the percussion's come up."""
    if i[at.I_MODE] != mode_before or i[at.I_BASE] != base_before:
        clear_zones(i)
        for channel in range(at.CHANNELS):
            i[at.C_MONO + channel] = 0
    if is_percussion(i, at.PERCUSSION_CHANNEL):
        set_pedals(d, i, now, at.PERCUSSION_CHANNEL, cc.RESET, 0)
        notes_off(d, i, now, at.PERCUSSION_CHANNEL)
