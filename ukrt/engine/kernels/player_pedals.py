"""The pedals that hold notes: which strings they hold when keys come up.

CC 64 holds every note of its channel. CC 66, sostenuto, holds those alone whose keys were down when it went down
(MIDI 1.0, "Sostenuto"), notes of the chord that is just being decided included.
"""

from ukrt.engine import player_layout as at
from ukrt.engine.kernels.jit import kernel


@kernel
def is_held_by_pedal(i, s):
    """Whether a pedal holds the note on string ``s`` though its key is up."""
    channel = i[at.S_CHANNEL + s]
    return i[at.C_PEDAL + channel] == 1 or (i[at.C_SOSTENUTO + channel] == 1 and i[at.S_CAUGHT + s] == 1)


@kernel
def set_sostenuto(i, channel, down):
    """Going down it catches what is held; staying down it catches nothing more; up it lets go of all."""
    if down == i[at.C_SOSTENUTO + channel]:
        return
    i[at.C_SOSTENUTO + channel] = down
    for s in range(i[at.I_STRINGS]):
        if i[at.S_CHANNEL + s] == channel:
            i[at.S_CAUGHT + s] = down if i[at.S_STATE + s] == at.HELD else 0
    for note in range(i[at.G_COUNT]):
        if i[at.G_CHANNEL + note] == channel:
            i[at.G_CAUGHT + note] = down if i[at.G_OFF + note] == 0 else 0
