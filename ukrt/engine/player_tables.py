"""What the compiled player must know of a guitar: its tables, made once from the preset and the intonation.

Enter a ``Guitar``, its ``Intonation`` and the sample rate; leaves the constant part of the player's sections of ``d``
and ``i``.
"""

import numpy as np

from ukrt.engine import layout
from ukrt.engine import player_layout as at
from ukrt.engine.controller_layout import ALTERNATE, MIDDLE
from ukrt.model.fingerboard import fingerboard, key_cents, key_pitches, repeat_keys
from ukrt.model.parameters import MIDI_MODES
from ukrt.playing.keyswitches import KEYSWITCHES, switches_of
from ukrt.playing.rules import (
    BEND_RAMP_TIME,
    BEND_SLOT_TIME,
    EASE_TIME,
    GAP_TIME,
    HOLD_TIME,
    JOIN_TIME,
    LEVEL_TIME,
    LIFT_TIME,
    QUICK_TIME,
    SETTLE_TIME,
    VIBRATO_SLOT_TIME,
    attack_times,
    damp_times,
    fold_table,
    force_curve,
    glide_times,
    loose_curve,
    mute_curve,
    strum_times,
)


def make_player_tables(guitar, intonation, sample_rate, d, i):
    """Fill the player's tables.

    Parameters
    ----------
    guitar : Guitar
    intonation : Intonation
        Its ``places`` (strings, frets + 1) [m] say where each fret stops each string, both from the capo.
    sample_rate : float [Hz]
    d, i : ndarray
        The instance's flat arrays, float64 and int64.
    """
    board = fingerboard(guitar)
    lead = max(1, round(guitar.pluck.duration * sample_rate))
    damp = _frames(guitar.damper.attack_time, sample_rate)
    i[at.I_STRINGS] = len(guitar.strings)
    i[at.I_FRETS] = board.frets
    i[at.I_SPAN] = guitar.playing.hand_span_frets
    i[at.I_LEAD] = lead
    lift = min(_frames(LIFT_TIME, sample_rate), max(1, lead // 3))
    i[at.I_LIFT_RAMP] = lift
    i[at.I_LANDING] = min(_frames(guitar.finger.landing_time, sample_rate), max(1, lead - lift - 1))
    i[at.I_DAMP_RAMP] = damp
    i[at.I_UNDAMP_RAMP] = _frames(guitar.damper.release_time, sample_rate)
    i[at.I_QUICK_RAMP] = min(_frames(QUICK_TIME, sample_rate), max(1, lead // 2))
    i[at.I_SETTLE] = damp + _frames(SETTLE_TIME, sample_rate)
    i[at.I_GAP] = max(_frames(GAP_TIME, sample_rate), lift + 1)
    i[at.I_DAMPED_IDLE] = guitar.playing.idle_strings == "damped"
    i[at.I_BEND_RANGE] = round(100 * guitar.playing.bend_range_semitones)
    i[at.I_MODE] = MIDI_MODES.index(guitar.playing.midi_mode)
    i[at.I_BASE] = guitar.playing.base_channel - 1
    i[at.I_BEND_RAMP] = _frames(BEND_RAMP_TIME, sample_rate)
    i[at.I_LEVEL_RAMP] = max(_frames(LEVEL_TIME, sample_rate), lead)
    i[at.I_BEND_SLOT] = max(_frames(BEND_SLOT_TIME, sample_rate), -(-lead // 4))
    i[at.I_EASE_RAMP] = _frames(EASE_TIME, sample_rate)
    _make_articulation(guitar.articulation, sample_rate, d, i)
    _make_right_hand(guitar, sample_rate, d, i)
    _make_switches(guitar, i)
    keys, repeat = board.open_keys, repeat_keys(guitar.tuning)
    i[at.I_REPEAT] = repeat
    i[at.I_OPEN : at.I_OPEN + at.ROW] = 0
    i[at.I_OPEN : at.I_OPEN + len(keys)] = keys
    i[at.I_FOLD : at.I_FOLD + 128] = fold_table(keys, board.frets, repeat, key_cents(guitar.tuning)[1])
    i[at.I_KEY_PITCH : at.I_KEY_PITCH + 128] = np.rint(key_pitches(guitar.tuning) * at.TUNING_UNIT)
    i[at.I_DAMP_OF : at.I_DAMP_OF + 128] = [_frames(t, sample_rate) for t in damp_times(guitar.damper.attack_time)]
    d[at.D_PLUCK_PLACE] = board.guitar.pluck.place
    d[at.D_PLUCK_ANGLE] = guitar.pluck.angle
    d[at.D_FORCE : at.D_FORCE + 128] = force_curve(guitar.pluck)
    places = np.asarray(intonation.places)
    for s in range(len(keys)):
        row = at.D_PLACES + s * at.FRET_ROW
        d[row : row + places.shape[1]] = places[s]
        d[at.D_LENGTH + s] = board.guitar.strings[s].length


def _make_switches(guitar, i):
    """Which keys say how notes are played, and by which controllers."""
    i[at.I_SWITCH_KEY], i[at.I_SWITCH_COUNT] = min(switches_of(guitar), default=128), len(KEYSWITCHES)
    for n, switch in enumerate(KEYSWITCHES):
        numbers = [switch.group, len(switch.sets), *(number for one in switch.sets for number in one)]
        row = at.I_SWITCHES + n * at.SWITCH_ROW
        i[row : row + len(numbers)] = numbers


def _make_articulation(articulation, sample_rate, d, i):
    """What the player must know of slurs, slides, vibrato, harmonics, muting and soft plucks."""
    i[at.I_HAMMER] = _frames(articulation.hammer_time, sample_rate)
    i[at.I_SLIDE] = _frames(articulation.slide_time, sample_rate)
    chunks = _frames(VIBRATO_SLOT_TIME, sample_rate / layout.CHUNK)
    i[at.I_VIBRATO_SLOT] = chunks * layout.CHUNK
    i[at.I_FLESH] = _frames(articulation.flesh_time, sample_rate)
    i[at.I_TOUCH] = _frames(articulation.touch_time, sample_rate)
    d[at.D_TOUCH] = articulation.touch_resistance
    d[at.D_MUTE : at.D_MUTE + 128] = mute_curve(articulation.mute_resistance)
    d[at.D_LOOSE : at.D_LOOSE + 128] = loose_curve()
    d[at.D_HAMMER_SPEED] = articulation.hammer_speed
    d[at.D_PULL_FORCE] = articulation.pull_force
    d[at.D_PULL_ANGLE] = articulation.pull_angle
    d[at.D_VIBRATO_CENTS] = articulation.vibrato_depth
    d[at.D_VIBRATO_STEP] = 2.0 * np.pi * articulation.vibrato_rate * i[at.I_VIBRATO_SLOT] / sample_rate
    d[at.D_FRAMES_OF_SLIDE : at.D_FRAMES_OF_SLIDE + 128] = np.round(glide_times() * sample_rate)


def _make_right_hand(guitar, sample_rate, d, i):
    """What the player must know of attacks, planting, strums and variations, and where controllers begin."""
    articulation = guitar.articulation
    pulls = np.round(attack_times(guitar.pluck) * sample_rate)
    d[at.D_FRAMES_OF_PULL : at.D_FRAMES_OF_PULL + 128] = np.clip(pulls, 1, i[at.I_LEAD])
    d[at.D_FRAMES_OF_STRUM : at.D_FRAMES_OF_STRUM + 128] = np.round(strum_times() * sample_rate)
    d[at.D_PLANT : at.D_PLANT + 128] = mute_curve(articulation.plant_resistance)
    i[at.I_USUAL_FLESH] = round(127 * articulation.flesh)
    i[at.I_USUAL_MUTE] = round(127 * articulation.muting)
    i[at.I_USUAL_PLANTING] = round(127 * articulation.planting)
    i[at.I_USUAL_VARIATION] = round(127 * articulation.variation)
    i[at.I_USUAL_STRUM] = round(articulation.strum_time * sample_rate)
    i[at.I_USUAL_DIRECTION] = {"down": 0, "up": MIDDLE, "alternate": ALTERNATE}[articulation.strum_direction]
    i[at.I_SEED] = articulation.seed
    i[at.I_STROKE_JOIN] = _frames(JOIN_TIME, sample_rate)
    i[at.I_STROKE_HOLD] = _frames(HOLD_TIME, sample_rate)


def _frames(seconds, sample_rate):
    return max(1, round(seconds * sample_rate))
