"""Keyswitches: keys outside the instrument's range that set their channel's controllers, and sound nothing.

Enter a note-on of such a key; leave what its row of I_SWITCHES says, by way of the same ``channel_control`` as any
message. A switch holds until another of its group is pressed, or the one that ends all; when its key comes up nothing
happens. Notes of its frame that came before it are played as it says: the caller recalls and plays their chord.
"""

from ukrt.engine import player_layout as at
from ukrt.engine.controller_layout import FLESH, LEGATO, MUTE
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.player_log import count
from ukrt.engine.kernels.player_loosen import follow_touches
from ukrt.engine.kernels.player_modes import channel_control
from ukrt.engine.kernels.player_touch import stopped_pitch
from ukrt.engine.kernels.player_tuning import transposed, within_keys

_ENDS_ALL = 0  # the group of playing/keyswitches.py's BACK


@kernel
def is_switch(i, key):
    """Whether a key is a keyswitch."""
    return i[at.I_SWITCH_KEY] <= key < i[at.I_SWITCH_KEY] + i[at.I_SWITCH_COUNT]


@kernel
def _set_all(d, i, frame, channel, switch, velocity):
    """Every controller of one switch: as without it (velocity 0), or as it says."""
    row = at.I_SWITCHES + switch * at.SWITCH_ROW
    for k in range(i[row + 1]):
        own = row + 2 + 4 * k
        value, soft, hard = i[own + 1], i[own + 2], i[own + 3]
        if velocity > 0:
            value = soft + (hard - soft) * (velocity - 1) // 126
        channel_control(d, i, frame, channel, i[own], value)
        if velocity == 0 and i[own] == LEGATO:
            i[at.C_LEGATO + channel] = 0  # as its mode has it
        elif velocity == 0 and i[own] == MUTE:
            i[at.C_MUTE + channel] = -1  # as the preset has it
        elif velocity == 0 and i[own] == FLESH:
            i[at.C_FLESH + channel] = -1


@kernel
def press_switch(d, i, frame, channel, key, velocity):
    """A switch's key goes down: the others of its group are ended, then it acts."""
    count(i, at.KEYSWITCHES)
    pressed = key - i[at.I_SWITCH_KEY]
    group = i[at.I_SWITCHES + pressed * at.SWITCH_ROW]
    for switch in range(i[at.I_SWITCH_COUNT]):
        if group == _ENDS_ALL or i[at.I_SWITCHES + switch * at.SWITCH_ROW] == group:
            _set_all(d, i, frame, channel, switch, 0)
    _set_all(d, i, frame, channel, pressed, velocity)
    _find_pitches(i, channel)
    follow_touches(d, i, frame)


@kernel
def _find_pitches(i, channel):
    """The channel's notes of this frame become harmonics, or are none any more."""
    for note in range(i[at.G_COUNT]):
        if i[at.G_CHANNEL + note] == channel:
            before, meant = i[at.G_WANTED + note], transposed(i, channel, i[at.G_KEY + note] + i[at.G_MOVED + note])
            wanted, partial = stopped_pitch(i, channel, within_keys(i, meant))
            if i[at.I_FOLD + wanted] >= 0:
                folds = int(i[at.I_FOLD + wanted] != wanted) - int(i[at.I_FOLD + before] != before)
                count(i, at.NOTES_FOLDED, folds if meant == within_keys(i, meant) else 0)
                i[at.G_WANTED + note], i[at.G_PARTIAL + note] = wanted, partial
