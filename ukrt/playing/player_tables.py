"""What the compiled player must know of a guitar: its tables, made once from the preset and the intonation.

Enter a ``Guitar``, its ``Intonation`` and the sample rate; leaves the constant part of the player's sections of ``d``
and ``i``.
"""

import numpy as np

from ..engine import player_layout as at

SETTLE_TIME = 0.15  # s from the damper's arrival to the finger's lift: the string is silent by then (estimate)
GAP_TIME = 0.02  # s from the finger's lift to the damper's (estimate)
QUICK_TIME = 0.002  # s for a damper that must go, or come, at once (estimate)
BEND_RAMP_TIME = 0.005  # s over which the tension follows one bend message
BEND_SLOT_TIME = 0.0025  # s: messages nearer than this are one bend
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


def fold_table(open_notes, frets):
    """The pitch that is played for each MIDI note: itself, or the nearest octave of it that some string has.

    Parameters
    ----------
    open_notes : sequence of int
        MIDI notes of the open strings.
    frets : int

    Returns
    -------
    ndarray (128,) of int
        -1 where no octave of the note can be played.
    """
    playable = sorted({note + fret for note in open_notes for fret in range(frets + 1) if note + fret < 128})
    table = np.full(128, -1, dtype=np.int64)
    for note in range(128):
        octaves = [pitch for pitch in playable if (pitch - note) % 12 == 0]
        if octaves:
            table[note] = min(octaves, key=lambda pitch: (abs(pitch - note), pitch))
    return table


def make_player_tables(guitar, intonation, sample_rate, d, i):
    """Fill the player's tables.

    Parameters
    ----------
    guitar : Guitar
    intonation : Intonation
        Its ``places`` (strings, frets + 1) [m] say where each fret stops each string.
    sample_rate : float [Hz]
    d, i : ndarray
        The instance's flat arrays, float64 and int64.
    """
    lead = max(1, round(guitar.pluck.duration * sample_rate))
    damp = _frames(guitar.damper.attack_time, sample_rate)
    i[at.I_STRINGS] = len(guitar.strings)
    i[at.I_FRETS] = guitar.playing.frets
    i[at.I_SPAN] = guitar.playing.hand_span_frets
    i[at.I_LEAD] = lead
    i[at.I_LANDING] = min(_frames(guitar.finger.landing_time, sample_rate), max(1, lead - 1))
    i[at.I_DAMP_RAMP] = damp
    i[at.I_UNDAMP_RAMP] = _frames(guitar.damper.release_time, sample_rate)
    i[at.I_QUICK_RAMP] = min(_frames(QUICK_TIME, sample_rate), max(1, lead // 2))
    i[at.I_SETTLE] = damp + _frames(SETTLE_TIME, sample_rate)
    i[at.I_GAP] = _frames(GAP_TIME, sample_rate)
    i[at.I_DAMPED_IDLE] = guitar.playing.idle_strings == "damped"
    i[at.I_BEND_RANGE] = round(100 * guitar.playing.bend_range_semitones)
    i[at.I_BEND_RAMP] = _frames(BEND_RAMP_TIME, sample_rate)
    i[at.I_BEND_SLOT] = max(_frames(BEND_SLOT_TIME, sample_rate), -(-lead // 4))
    notes = [string.note for string in guitar.strings]
    i[at.I_OPEN : at.I_OPEN + at.ROW] = 0
    i[at.I_OPEN : at.I_OPEN + len(notes)] = notes
    i[at.I_FOLD : at.I_FOLD + 128] = fold_table(notes, guitar.playing.frets)
    d[at.D_PLUCK_PLACE] = guitar.pluck.place
    d[at.D_PLUCK_ANGLE] = guitar.pluck.angle
    d[at.D_FORCE : at.D_FORCE + 128] = force_curve(guitar.pluck)
    places = np.asarray(intonation.places)
    for s in range(len(notes)):
        row = at.D_PLACES + s * at.FRET_ROW
        d[row : row + places.shape[1]] = places[s]


def _frames(seconds, sample_rate):
    return max(1, round(seconds * sample_rate))
