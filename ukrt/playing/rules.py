"""A guitarist's rules as numbers: how hard each velocity plucks, what an unreachable note becomes, how long hands take.

Enter a preset's values, leave plain tables; how they reach the compiled player is the engine's business.
"""

import numpy as np

SETTLE_TIME = 0.15  # s from the damper's arrival to the finger's lift: the string is silent by then (estimate)
GAP_TIME = 0.02  # s from the finger's lift to the damper's (estimate)
LIFT_TIME = 0.003  # s in which a finger lets go of a string (estimate)
QUICK_TIME = 0.002  # s for a damper that must go, or come, at once (estimate)
BEND_RAMP_TIME = 0.005  # s over which the tension follows one bend message
BEND_SLOT_TIME = 0.0025  # s: messages nearer than this are one bend
LEVEL_TIME = 0.01  # s, at least, in which the volume comes to a new value: steps 10 ms apart are one slope (choice)
EASE_TIME = 0.02  # s in which a hand comes to lie on a sounding string, or leaves it (estimate)
VIBRATO_SLOT_TIME = 0.01  # s, about, between two points of a vibrato's curve: 20 in a period of 5 Hz
SHORTEST_GLIDE, LONGEST_GLIDE = 0.03, 2.0  # s, of CC 5 (choices)
LIGHTEST_MUTE = 0.05  # of the preset's, at value 1 of CC 19 (choice)
SHORTEST_ATTACK = 5e-4  # s, of CC 22: a plectrum's snap (estimate)
SHORTEST_STRUM, LONGEST_STRUM = 0.005, 0.4  # s, of CC 23 (choices)
JOIN_TIME = 0.05  # s for which notes join a stroke: what a chord on a keyboard is spread by (estimate)
HOLD_TIME = 0.1  # s that a strummed string sounds at least, where its key was down that long (choice)
TIGHT, LOOSE = 100.0, 2.0  # over the wave impedance, at values 1 and 127 of CC 27: see loose_curve
DAMP_SPEED = 4.0  # how much quicker, or slower, the damper comes at the utmost release velocities (choice)
SOFT_VELOCITY, STRONG_VELOCITY = 20, 127


def force_curve(pluck):
    """Peak force of each MIDI velocity: even steps in dB, through ``force_soft`` at 20 and ``force_strong`` at 127.

    Parameters
    ----------
    pluck : Pluck

    Returns
    -------
    ndarray (128,) [N]
        Strictly rising where the two forces differ; element 0 (a note-off) is 0.
    """
    steps = (np.arange(128) - SOFT_VELOCITY) / (STRONG_VELOCITY - SOFT_VELOCITY)
    force = pluck.force_soft * (pluck.force_strong / pluck.force_soft) ** steps
    force[0] = 0.0
    return force


def glide_times():
    """Time of a slide for each value of CC 5: even steps of ratio.

    Returns
    -------
    ndarray (128,) [s]
    """
    return SHORTEST_GLIDE * (LONGEST_GLIDE / SHORTEST_GLIDE) ** (np.arange(128) / 127.0)


def mute_curve(most):
    """Resistance of the hand's edge for each value of CC 19, of a planted finger of CC 26: even steps in dB up to
    ``most``, none at 0.

    Parameters
    ----------
    most : float
        Over the wave impedance.

    Returns
    -------
    ndarray (128,)
    """
    curve = most * LIGHTEST_MUTE ** (1.0 - np.arange(128) / 127.0)
    curve[0] = 0.0
    return curve


def attack_times(pluck):
    """Time for which a finger pulls for each value of CC 22: even steps of ratio either way from the preset's at 64.

    Parameters
    ----------
    pluck : Pluck

    Returns
    -------
    ndarray (128,) [s]
        From SHORTEST_ATTACK, or the preset's if that is shorter, to all of the pluck's duration.
    """
    usual, value = pluck.attack * pluck.duration, np.arange(128)
    shortest = min(SHORTEST_ATTACK, usual)
    shorter = usual * (shortest / usual) ** ((64 - value) / 64.0)
    longer = usual * (pluck.duration / usual) ** ((value - 64) / 63.0)
    return np.where(value < 64, shorter, np.where(value > 64, longer, usual))


def strum_times():
    """Time of a sweep over all strings for each value of CC 23: even steps of ratio, none at 0.

    Returns
    -------
    ndarray (128,) [s]
    """
    times = SHORTEST_STRUM * (LONGEST_STRUM / SHORTEST_STRUM) ** ((np.arange(128) - 1) / 126.0)
    times[0] = 0.0
    return times


def loose_curve():
    """Resistance of a half-lifted fingertip for each value of CC 27: even steps in dB down from TIGHT to LOOSE.

    A resistance R on a string of wave impedance Z takes 4 R Z / (R + 2 Z)^2 of the energy of a wave that meets it: 4 %
    at 100 Z, where it still stops the string, and a half at 2 Z, the most there is.

    Returns
    -------
    ndarray (128,)
        Over the wave impedance, 0 at 0.
    """
    curve = TIGHT * (LOOSE / TIGHT) ** ((np.arange(128) - 1) / 126.0)
    curve[0] = 0.0
    return curve


def damp_times(attack_time):
    """Time in which the damper comes down for each release velocity: even steps of ratio around the preset's at 64.

    Parameters
    ----------
    attack_time : float [s]

    Returns
    -------
    ndarray (128,) [s]
        Velocity 0, which many keyboards and programs send for want of one, is as 64.
    """
    times = attack_time * DAMP_SPEED ** ((64 - np.arange(128)) / 63.0)
    times[0] = attack_time
    return times


def fold_table(open_keys, frets, repeat=12, plays=None):
    """The key that is played for each key: itself, or the nearest octave of it that some string has.

    Parameters
    ----------
    open_keys : sequence of int
        Keys (MIDI notes) of the open strings.
    frets : int
        Each one key higher.
    repeat : int
        Keys in an octave, or in whatever interval the scale repeats at.
    plays : sequence (128,) of bool, optional
        Which keys the scale has a note for; by default all.

    Returns
    -------
    ndarray (128,) of int
        -1 where no octave of the key can be played.
    """
    plays = np.ones(128, bool) if plays is None else plays
    reach = {key + fret for key in open_keys for fret in range(frets + 1)}
    playable = [key for key in sorted(reach) if key < 128 and plays[key]]
    table = np.full(128, -1, dtype=np.int64)
    for key in np.flatnonzero(plays):
        octaves = [other for other in playable if (other - key) % repeat == 0]
        if octaves:
            table[key] = min(octaves, key=lambda other: (abs(other - key), other))
    return table
