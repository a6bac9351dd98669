"""Slurs: a note that begins while another of its channel sounds goes on, on that string, without the right hand.

Enter a chord's notes and what the strings are doing; leave which string a note can be slurred on and how (hammer-on,
pull-off, slide), and its gestures. All of them come LEAD frames after the note-on, as the release of a pluck does.
"""

from ukrt.engine import gestures as do
from ukrt.engine import player_layout as at
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.player_expression import glide_frames
from ukrt.engine.kernels.player_loosen import leave_touch
from ukrt.engine.kernels.player_mono import is_legato, is_mono
from ukrt.engine.kernels.player_right_hand import muting
from ukrt.engine.kernels.player_strings import free_string, mark_begun, press_string, pull_string


@kernel
def way_to(i, s, channel, pitch):
    """How the note on string ``s`` goes over into ``pitch``; PLUCKED if it cannot."""
    stop, fret = i[at.S_FINGER + s], pitch - i[at.I_OPEN + s]
    if fret < 0 or fret > i[at.I_FRETS] or fret == stop:
        return at.PLUCKED
    if i[at.C_GLIDES + channel] == 1 and stop > 0 and fret > 0:
        return at.SLID
    near = i[at.I_HAND] if stop == 0 else stop
    if not is_legato(i, channel):
        return at.PLUCKED
    if fret > 0 and abs(fret - near) > i[at.I_SPAN]:
        if not is_mono(i, channel):
            return at.PLUCKED
        if stop > 0:
            return at.SLID  # one voice, not struck anew: the finger has gone there
    return at.HAMMERED if fret > stop else at.PULLED


@kernel
def _string_to_slur(i, note):
    """The string, of those plucked last, that can go over into a note of the chord; -1 if none can."""
    found, channel = -1, i[at.G_CHANNEL + note]
    if i[at.G_PARTIAL + note] > 0 or (not is_legato(i, channel) and i[at.C_GLIDES + channel] == 0):
        return found
    pitch, forced = i[at.G_PITCH + note], i[at.G_FORCED + note]
    for s in range(i[at.I_STRINGS]):
        held = i[at.S_STATE + s] == at.HELD and i[at.S_CHANNEL + s] == channel and i[at.X_FREED + s] == at.KEPT
        held = held and i[at.S_PLUCK + s] <= i[at.I_NOW]  # a string that waits for the hand has nothing to slur from
        held = held and (forced == 0 or s == i[at.I_STRINGS] - forced)
        if held and way_to(i, s, channel, pitch) != at.PLUCKED:
            if found < 0 or i[at.S_ORDER + s] > i[at.S_ORDER + found]:
                found = s
    return found


@kernel
def find_slurs(i):
    """G_REPEAT and X_FREED of the notes that can be slurred; of several for one string the highest is."""
    below = 128
    for _ in range(i[at.G_COUNT]):
        note = -1
        for other in range(i[at.G_COUNT]):
            key = i[at.G_KEY + other]
            if key < below and (note < 0 or key > i[at.G_KEY + note]):
                note = other
        if note < 0:
            return
        below = i[at.G_KEY + note]
        for other in range(i[at.G_COUNT]):  # a unison of several channels as well
            if i[at.G_KEY + other] == below and i[at.G_REPEAT + other] < 0:
                s = _string_to_slur(i, other)
                i[at.G_REPEAT + other] = s
                if s >= 0:
                    i[at.X_FREED + s] = at.SLURRING


@kernel
def way_of(i, note, s):
    """How a note of the chord is played on the string ``s`` that it has been given."""
    if i[at.G_PARTIAL + note] > 0:
        return at.HARMONIC
    if i[at.G_REPEAT + note] != s or i[at.X_FREED + s] != at.SLURRING:
        return at.MUTED if muting(i, i[at.G_CHANNEL + note]) > 0 else at.PLUCKED
    return way_to(i, s, i[at.G_CHANNEL + note], i[at.G_PITCH + note])


@kernel
def first_gesture(way):
    """The kind of gesture without which a note has not begun."""
    if way == at.PULLED:
        return do.LIFT
    return do.PRESS if way == at.HAMMERED or way == at.SLID else do.PLUCK


@kernel
def slur_note(d, i, s, frame, fret, force, channel, way):
    """Go over to ``fret`` from what sounds on the string; ``force`` is what its velocity would pluck with [N]."""
    eases = i[at.S_LOOSE + s] > 0 or i[at.S_EASED + s] >= frame
    finger, _ = free_string(d, i, s, frame)
    strength = force / d[at.D_FORCE + 127]
    if way == at.PULLED and finger > 0:
        i[at.S_PULLED + s], i[at.S_PULLED_FROM + s] = frame, finger
        pull_string(d, i, s, force)
        finger = 0
    i[at.S_FINGER + s], i[at.S_STEP + s] = fret, 0
    if fret > 0:
        i[at.S_PRESS + s], i[at.S_STAYS + s], i[at.S_SPEED + s] = frame + i[at.I_LEAD], finger, 0
        if way == at.HAMMERED:
            i[at.S_LANDING + s] = i[at.I_HAMMER]
            i[at.S_SPEED + s] = int(1e6 * strength * d[at.D_HAMMER_SPEED])
        elif way == at.PULLED:
            i[at.S_LANDING + s] = i[at.I_QUICK_RAMP]  # the finger is there already, at rest
        else:
            i[at.S_LANDING + s] = glide_frames(d, i, channel) if finger > 0 else i[at.I_LANDING]
            if i[at.C_FRETS + channel] == 1 and finger > 0 and finger != fret:
                i[at.S_STEP + s] = max(1, i[at.S_LANDING + s] // abs(fret - finger))
                i[at.S_LANDING + s] = min(2 * i[at.I_LANDING], i[at.S_STEP + s])
        press_string(d, i, s, frame)
    mark_begun(i, s)
    if eases:
        leave_touch(d, i, s, frame)
