"""How a channel's notes are to be played, as its controllers say: slurs, slides, vibrato, place and angle of the pluck.

Enter controllers and pressure; leave the channel's rows, which later notes (and the vibrato, at once) look at.
"""

import math

from ukrt.engine import controller_layout as cc
from ukrt.engine import player_layout as at
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.player_zones import timbre


@kernel
def set_expression(i, channel, controller, value):
    """One controller of a channel; returns whether it is one of those that say how notes are played."""
    if controller == cc.WHEEL:
        i[at.C_WHEEL + channel] = value
    elif controller == cc.GLIDE_TIME:
        i[at.C_GLIDE_TIME + channel] = value
    elif controller == cc.ANGLE:
        i[at.C_ANGLE + channel] = value
    elif controller == cc.GLIDE:
        i[at.C_GLIDES + channel] = 1 if value >= cc.DOWN else 0
    elif controller == cc.LEGATO:
        i[at.C_LEGATO + channel] = 1 if value >= cc.DOWN else -1
    elif controller == cc.HARMONIC:
        i[at.C_HARMONIC + channel] = 1 if value >= cc.DOWN else 0
    elif controller == cc.LOOSE:
        i[at.C_LOOSE + channel] = value
    elif controller == cc.FRETS:
        i[at.C_FRETS + channel] = 1 if value >= cc.DOWN else 0
    elif controller == cc.PLACE:
        i[at.C_PLACE + channel] = value
    elif controller == cc.SOFT:
        i[at.C_SOFT + channel] = 1 if value >= cc.DOWN else 0
    else:
        return False
    return True


@kernel
def set_key_pressure(i, channel, key, value):
    """Polyphonic pressure: of the strings that sound this key of this channel."""
    for s in range(i[at.I_STRINGS]):
        if i[at.S_CHANNEL + s] == channel and i[at.S_KEY + s] == key:
            i[at.S_PRESSURE + s] = value


@kernel
def reset_expression(i, channel):
    """CC121: no vibrato, slurs, slides, harmonics; the sound stays as it is set (MIDI practice RP-015)."""
    i[at.C_WHEEL + channel] = i[at.C_PRESSURE + channel] = i[at.C_SOFT + channel] = 0
    i[at.C_LEGATO + channel] = i[at.C_GLIDES + channel] = i[at.C_HARMONIC + channel] = 0
    i[at.C_LOOSE + channel] = i[at.C_FRETS + channel] = 0
    for s in range(i[at.I_STRINGS]):
        if i[at.S_CHANNEL + s] == channel:
            i[at.S_PRESSURE + s] = 0


@kernel
def clear_expression(i, channel):
    """As at power-up."""
    reset_expression(i, channel)
    i[at.C_GLIDE_TIME + channel] = -1
    i[at.C_PLACE + channel] = i[at.C_ANGLE + channel] = cc.MIDDLE


@kernel
def pluck_place(d, i, s, fret, channel):
    """Where string ``s`` is plucked, as a share of its length: the preset's place, or towards neck or bridge from it.

    Towards the neck it never comes nearer to the finger than LEAST_SHARE of what sounds.
    """
    place, value = d[at.D_PLUCK_PLACE], timbre(i, channel)
    if value > cc.MIDDLE:
        return place + (max(at.PLACE_BRIDGE, place) - place) * (value - cc.MIDDLE) / (127 - cc.MIDDLE)
    if value < cc.MIDDLE:
        stopped = d[at.D_PLACES + s * at.FRET_ROW + fret] / d[at.D_LENGTH + s]
        moved = place + (min(at.PLACE_NECK, place) - place) * (cc.MIDDLE - value) / cc.MIDDLE
        return min(place, max(moved, stopped + at.LEAST_SHARE * (1.0 - stopped)))
    return place


@kernel
def pluck_angle(d, i, channel):
    """Direction of the pluck [rad]: the preset's, or from it towards parallel (pi/2) or normal (0) to the top."""
    angle, value = d[at.D_PLUCK_ANGLE], i[at.C_ANGLE + channel]
    if value > cc.MIDDLE:
        return angle * (127 - value) / (127 - cc.MIDDLE)
    return angle + (0.5 * math.pi - angle) * (cc.MIDDLE - value) / cc.MIDDLE


@kernel
def pluck_force(d, i, channel, velocity):
    """Force of a pluck [N], less with the soft pedal."""
    return d[at.D_FORCE + velocity] * (at.SOFT_FORCE if i[at.C_SOFT + channel] == 1 else 1.0)


@kernel
def glide_frames(d, i, channel):
    """How long a slide takes."""
    value = i[at.C_GLIDE_TIME + channel]
    return i[at.I_SLIDE] if value < 0 else int(d[at.D_FRAMES_OF_SLIDE + value])
