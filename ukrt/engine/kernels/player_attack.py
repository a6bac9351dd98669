"""The right hand plucks one string: when it begins to pull, where, how hard and which way, and how it lets go.

Enter a note that the left hand has been told to stop; leave its pluck on the timeline, and before it, if the finger is
planted, its touch. The release always falls LEAD frames after the note-on, or after the hand has come to the string
(player_strum.py): what pulls for a shorter time begins later.
"""

from ukrt.engine import gestures as do
from ukrt.engine import player_layout as at
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.player_expression import pluck_angle, pluck_place
from ukrt.engine.kernels.player_log import log_pluck
from ukrt.engine.kernels.player_right_hand import muting, planting, pull_frames, release_frames, variation
from ukrt.engine.kernels.player_strings import ask, ask_fully, ask_pluck
from ukrt.engine.kernels.player_variation import varied_angle, varied_force, varied_place


@kernel
def _tell_release(d, i, s, frame, channel):
    """How the string's plucks let go, where that changes."""
    release = release_frames(i, channel)
    if i[at.S_RELEASE + s] != release:
        i[at.S_RELEASE + s] = release
        ask(d, i, frame, do.RELEASE, s, 0.0, release)


@kernel
def _plant(d, i, s, frame, place, channel):
    """The finger lies on the string from the note-on until just before the release, beside the place it plucks at.

    What it takes is the flesh's: a resistance. It leaves while it still pulls, so that the string is let go freely.
    """
    place = max(place - at.PLANT_BESIDE, 0.5 * place)
    resistance, ramp = d[at.D_PLANT + planting(i, channel)], i[at.I_QUICK_RAMP]
    ask_fully(d, i, frame, do.TOUCH, s, place, float(ramp), resistance, 0.0, 0.0)
    i[at.S_PLANTED + s] = frame + i[at.I_LEAD] - ramp
    ask(d, i, i[at.S_PLANTED + s], do.TOUCH, s, 0.0, ramp)


@kernel
def pluck_string(d, i, s, frame, fret, force, seq, channel, late, finger):
    """Pluck string ``s`` for note ``seq`` of the log, which begins at ``frame``; the hand comes ``late`` frames later.

    Returns the place [share of L].
    """
    i[at.S_SEQ + s] = seq
    _tell_release(d, i, s, frame, channel)
    place, angle = pluck_place(d, i, s, fret, channel), pluck_angle(d, i, channel)
    share = variation(i, channel) / 127.0
    if share > 0.0:
        place = varied_place(d, i, s, fret, place, share, seq, finger)
        angle = varied_angle(i, angle, share, seq, finger)
        force = varied_force(i, force, share, seq, finger)
    pull = pull_frames(d, i, channel)
    i[at.S_LATE + s], i[at.S_PULL + s], i[at.S_PLUCK + s] = late, pull, frame + late + i[at.I_LEAD] - pull
    d[at.D_PLUCKED_PLACE + s], d[at.D_PLUCKED_FORCE + s], d[at.D_PLUCKED_ANGLE + s] = place, force, angle
    ask_pluck(d, i, s)
    log_pluck(i, seq, late, finger)
    return place


@kernel
def attack_note(d, i, s, frame, fret, force, note):
    """Pluck string ``s`` for a note of the chord that begins at ``frame``."""
    channel, late = i[at.G_CHANNEL + note], max(0, i[at.X_LATE + note])
    seq, finger = i[at.G_SEQ + note], i[at.X_FINGER + note]
    place = pluck_string(d, i, s, frame, fret, force, seq, channel, late, finger)
    touched = i[at.G_PARTIAL + note] > 0 or muting(i, channel) > 0
    if planting(i, channel) > 0 and i[at.X_LATE + note] == at.BY_FINGER and not touched:
        _plant(d, i, s, frame, place, channel)
