"""Channels with one voice: the strings of a MIDI guitar, and channels that CC 126 has made mono (mode 4 of MIDI 1.0).

Enter the mode and what CC 20, 68, 126 and 127 have said; leave a channel's string, and which notes end or go over into
the next because their channel has but one voice. Notes of one moment are a chord, even on such a channel.
"""

from ukrt.engine import player_layout as at
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.player_zones import NO_ZONE, zone_of, zone_place


@kernel
def mode_string(i, channel):
    """The string that the mode gives a channel, 1 the highest; 0: none."""
    number = 0
    if i[at.I_MODE] == at.GUITAR:
        number = channel - i[at.I_BASE] + 1
    elif i[at.I_MODE] == at.GUITAR_MPE:
        number = zone_place(i, channel)
    return number if 1 <= number <= i[at.I_STRINGS] else 0


@kernel
def is_beyond(i, channel):
    """Whether a channel has no string although the mode gives strings to channels."""
    guitar = i[at.I_MODE] == at.GUITAR or i[at.I_MODE] == at.GUITAR_MPE
    return guitar and mode_string(i, channel) == 0


@kernel
def is_percussion(i, channel):
    """Channel 10, unless it is a string's or belongs to a zone."""
    return channel == at.PERCUSSION_CHANNEL and mode_string(i, channel) == 0 and zone_of(i, channel) == NO_ZONE


@kernel
def is_mono(i, channel):
    """Whether a channel has one voice."""
    said = i[at.C_MONO + channel]
    return said > 0 or (said == 0 and mode_string(i, channel) > 0)


@kernel
def is_legato(i, channel):
    """Whether overlapping notes of a channel are slurred: as CC 68 has said, and before that where it has one voice."""
    said = i[at.C_LEGATO + channel]
    return said > 0 or (said == 0 and is_mono(i, channel))


@kernel
def string_wanted(i, channel):
    """The string for a channel's notes to come, 1 the highest: CC 20's, else a string's own channel's; 0: any."""
    if i[at.C_STRING + channel] > 0:
        return i[at.C_STRING + channel]
    return mode_string(i, channel) if is_mono(i, channel) else 0


@kernel
def find_monos(i):
    """After repeats and slurs have been found: held notes whose channel has one voice give way to its new ones
    (X_FREED), which take their string if it has them (G_REPEAT)."""
    for s in range(i[at.I_STRINGS]):
        channel = i[at.S_CHANNEL + s]
        if i[at.X_FREED + s] != at.KEPT or i[at.S_STATE + s] != at.HELD or not is_mono(i, channel):
            continue
        for note in range(i[at.G_COUNT]):
            if i[at.G_CHANNEL + note] == channel:
                i[at.X_FREED + s] = at.REPEATING
                if i[at.G_REPEAT + note] < 0:
                    i[at.G_REPEAT + note] = s


@kernel
def gives_way(i, s):
    """Whether the note on string ``s`` ends though no note of the chord has been given its string."""
    if i[at.X_TAKER + s] >= 0:
        return False
    freed = i[at.X_FREED + s]
    return freed == at.REPEATING or (freed == at.SLURRING and is_mono(i, i[at.S_CHANNEL + s]))
