"""The chord of the present frame: its notes are weighed together; what was decided is taken back when another arrives.

Messages come one by one, so each note of a chord is played as if it were the last. When another message of the same
frame changes the ground (a note-on, a note-off, the pedal), the plucks, none of which has been carried out yet, are
withdrawn and the state before the chord is brought back (``recall_chord``), the message takes effect, and all is
decided again (``play_chord``). So notes of one frame may come in any order.
"""

from ukrt.engine import layout
from ukrt.engine import player_layout as at
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.player_attack import attack_note
from ukrt.engine.kernels.player_bend import let_go
from ukrt.engine.kernels.player_choice import choose_strings, refused_forces
from ukrt.engine.kernels.player_hand import hand_follow, place_hand
from ukrt.engine.kernels.player_holds import remember_hold
from ukrt.engine.kernels.player_log import count, log_end, log_place
from ukrt.engine.kernels.player_loosen import follow_touches, restore_touch
from ukrt.engine.kernels.player_mono import find_monos, gives_way, string_wanted
from ukrt.engine.kernels.player_pedals import is_held_by_pedal
from ukrt.engine.kernels.player_slur import find_slurs, first_gesture, slur_note, way_of
from ukrt.engine.kernels.player_strings import (
    bend_string,
    damp_string,
    drop_pluck,
    note_ratio,
    rest_ratio,
    restore_ending,
    set_tension,
    start_note,
    string_ratio,
    withdraw_note,
)
from ukrt.engine.kernels.player_strum import end_of_stroke, plan_strum
from ukrt.engine.kernels.player_touch import touch_string
from ukrt.engine.kernels.player_tuning import tune_note
from ukrt.engine.kernels.player_variation import choose_fingers
from ukrt.engine.kernels.timeline import timeline_cancel


@kernel
def chord_open(d, i, frame):
    """Whether a chord has begun at ``frame`` and can be decided anew; its first note is withdrawn to find out."""
    if i[at.G_COUNT] == 0 or i[at.G_FRAME] != frame or i[at.G_DONE] != i[layout.H_GESTURES_DONE]:
        return False
    for note in range(i[at.G_COUNT]):
        s, way = i[at.G_STRING + note], i[at.G_WAY + note]
        if s >= 0 and not (way == at.PULLED and i[at.S_PULLED + s] != frame):  # no finger was left to pull off
            return timeline_cancel(d, i, s, first_gesture(way), frame) > 0
    return True


@kernel
def close_chord(i):
    """Nothing of the chord is decided anew any more."""
    i[at.G_COUNT], i[at.G_VICTIMS] = 0, 0


@kernel
def _recall_string(d, i, s, frame):
    """Bring one string's gestures back to what they were before the chord."""
    withdraw_note(d, i, s, frame)
    restore_ending(d, i, s, frame)
    restore_touch(d, i, s, frame)
    sounding = i[at.S_STATE + s] == at.HELD or i[at.S_STATE + s] == at.PEDALLED
    ratio = string_ratio(d, i, s) if sounding else rest_ratio(i)
    set_tension(d, i, s, frame, ratio, i[at.I_BEND_RAMP], 0.0)


@kernel
def recall_chord(d, i, frame):
    """Take back what the chord of this frame, if one is open, has done; a chord that lies behind is closed.

    Whoever calls this calls ``play_chord`` when the message has taken effect.
    """
    if not chord_open(d, i, frame):
        close_chord(i)
        i[at.G_FRAME] = frame
        return
    for s in range(i[at.I_STRINGS]):
        touched = 0
        for row in (at.S_STATE, at.S_SEQ, at.S_ORDER):
            touched += 1 if i[row + s] != i[row - at.I_TAKEN_BACK + at.I_SAVED + s] else 0
        i[at.X_QUEUE + s] = touched
    for k in range(at.I_SAVED_SIZE):
        i[at.I_TAKEN_BACK + k] = i[at.I_SAVED + k]
    for k in range(3 * at.ROW):
        d[at.D_PLUCKED_PLACE + k] = d[at.D_SAVED + k]
    for s in range(i[at.I_STRINGS]):
        if i[at.X_QUEUE + s] > 0:
            _recall_string(d, i, s, frame)
    for k in range(i[at.G_VICTIMS]):
        log_end(i, i[at.V_SEQ + k], -1, at.PLAYED)
        if i[at.V_OWED + k] >= 0:
            i[at.I_OWED + i[at.V_OWED + k]] -= 1
    i[at.G_VICTIMS] = 0


@kernel
def _owe(i, channel, key):
    """A note sounds no more though its key is down: its note-off will come. Returns the place of that in I_OWED."""
    place = channel * 128 + key
    i[at.I_OWED + place] += 1
    return place


@kernel
def _victim(i, seq, frame, fate, owed):
    log_end(i, seq, frame, fate)
    i[at.V_SEQ + i[at.G_VICTIMS]] = seq
    i[at.V_OWED + i[at.G_VICTIMS]] = owed
    i[at.G_VICTIMS] += 1


@kernel
def _is_repeated(i, s):
    """Whether a note of the chord is the same key of the same channel as the string's."""
    for note in range(i[at.G_COUNT]):
        if i[at.G_KEY + note] == i[at.S_KEY + s] and i[at.G_CHANNEL + note] == i[at.S_CHANNEL + s]:
            return True
    return False


@kernel
def _end_former(i, s, frame, way):
    """The note that sounds on string ``s``, if any, gives way to a new one, or to its own repetition, or is slurred."""
    state = i[at.S_STATE + s]
    if state != at.HELD and state != at.PEDALLED:
        return
    owed = _owe(i, i[at.S_CHANNEL + s], i[at.S_KEY + s]) if state == at.HELD else -1
    if way in (at.HAMMERED, at.PULLED, at.SLID):
        count(i, at.NOTES_SLURRED)
        if state == at.HELD:
            remember_hold(i, s)
        _victim(i, i[at.S_SEQ + s], frame, at.SLURRED, owed)
        return
    i[at.S_HOLDS + s] = 0
    if i[at.X_FREED + s] == at.REPEATING and _is_repeated(i, s):
        count(i, at.NOTES_REPEATED)
        _victim(i, i[at.S_SEQ + s], frame, at.REPEATED, owed)
    else:
        count(i, at.NOTES_STOLEN)
        _victim(i, i[at.S_SEQ + s], frame, at.STOLEN, owed)


@kernel
def _find_repeats(i):
    """G_REPEAT and X_FREED: notes of the chord that repeat, on their channel, a key that still sounds."""
    for s in range(i[at.I_STRINGS]):
        i[at.X_FREED + s] = at.KEPT
    for note in range(i[at.G_COUNT]):
        i[at.G_REPEAT + note] = -1
        for s in range(i[at.I_STRINGS]):
            state = i[at.S_STATE + s]
            sounding = state == at.HELD or state == at.PEDALLED
            same = i[at.S_KEY + s] == i[at.G_KEY + note] and i[at.S_CHANNEL + s] == i[at.G_CHANNEL + note]
            if sounding and same and i[at.X_FREED + s] == at.KEPT and i[at.G_REPEAT + note] < 0:
                i[at.G_REPEAT + note] = s
                i[at.X_FREED + s] = at.REPEATING


@kernel
def end_note(d, i, s, frame):
    """The key of the note on string ``s`` comes up: the note is damped, or a pedal holds it."""
    if is_held_by_pedal(i, s):
        i[at.S_STATE + s] = at.PEDALLED
        let_go(i, s)
        return
    log_end(i, i[at.S_SEQ + s], frame, at.PLAYED)
    damp_string(d, i, s, frame, end_of_stroke(i, s, frame) + i[at.I_LEAD], i[at.S_DAMPS + s])


@kernel
def _overtake(d, i, s, frame):
    """String ``s`` is needed: if the hand has yet to come to it for its former note, it does not any more."""
    if drop_pluck(d, i, s, frame):
        count(i, at.PLUCKS_OVERTAKEN)


@kernel
def _sound(d, i, note, frame):
    """Play a note of the chord on the string it was given."""
    s, seq = i[at.G_STRING + note], i[at.G_SEQ + note]
    channel, pitch, tuned = i[at.G_CHANNEL + note], i[at.G_PITCH + note], i[at.S_TUNED + s]
    fret, way = pitch - i[at.I_OPEN + s], way_of(i, note, s)
    i[at.G_WAY + note] = way
    _end_former(i, s, frame, way)
    _overtake(d, i, s, frame)
    tune_note(i, s, channel, i[at.G_KEY + note], i[at.G_MOVED + note])
    force = d[at.D_LOG_FORCE + seq % at.LOG_CAPACITY]
    if way not in (at.HAMMERED, at.PULLED, at.SLID):
        touch_string(d, i, s, frame, max(0, i[at.X_LATE + note]), fret, channel, i[at.G_PARTIAL + note])
        start_note(d, i, s, frame, fret, channel)
        attack_note(d, i, s, frame, fret, force, note)
        i[at.S_HOLDS + s] = 0
    else:
        slur_note(d, i, s, frame, fret, force, channel, way)
        if i[at.S_TUNED + s] != tuned:
            bend_string(d, i, s, frame, note_ratio(d, i, s, channel))
    i[at.S_STATE + s], i[at.S_CAUGHT + s] = at.HELD, i[at.G_CAUGHT + note]
    i[at.S_CHANNEL + s], i[at.S_KEY + s], i[at.S_PITCH + s] = channel, i[at.G_KEY + note], pitch
    i[at.S_SEQ + s] = seq
    log_place(i, seq, s, fret, way)
    log_end(i, seq, -1, at.PLAYED)
    count(i, at.NOTES_PLAYED)
    if i[at.G_OFF + note] == 1:
        end_note(d, i, s, frame)


@kernel
def _drop(i, note, frame):
    """No string is left for a note of the chord."""
    log_place(i, i[at.G_SEQ + note], -1, -1, at.PLUCKED)
    log_end(i, i[at.G_SEQ + note], frame, at.DROPPED)
    count(i, at.NOTES_DROPPED)
    if i[at.G_OFF + note] == 0:
        i[at.V_OWED + i[at.G_VICTIMS]] = _owe(i, i[at.G_CHANNEL + note], i[at.G_KEY + note])
        i[at.V_SEQ + i[at.G_VICTIMS]] = -1
        i[at.G_VICTIMS] += 1


@kernel
def play_chord(d, i, frame):
    """Choose strings for all notes of the chord and put their gestures on the timeline."""
    if i[at.G_COUNT] == 0:
        return
    for k in range(at.I_SAVED_SIZE):
        i[at.I_SAVED + k] = i[at.I_TAKEN_BACK + k]
    for k in range(3 * at.ROW):
        d[at.D_SAVED + k] = d[at.D_PLUCKED_PLACE + k]
    i[at.G_DONE] = i[layout.H_GESTURES_DONE]
    _find_repeats(i)
    hand = i[at.I_HAND]
    place_hand(i)
    find_slurs(i)
    find_monos(i)
    choose_strings(i)
    strain = hand_follow(i)
    way = abs(i[at.I_HAND] - hand)
    count(i, at.FORCES_REFUSED, refused_forces(i))
    count(i, at.STRETCHES, min(strain, 1))
    count(i, at.HAND_SHIFTS, min(way, 1))
    count(i, at.HAND_SHIFT_FRETS, way)
    for s in range(i[at.I_STRINGS]):
        if gives_way(i, s):
            _end_former(i, s, frame, at.PLUCKED)
            _overtake(d, i, s, frame)
            damp_string(d, i, s, frame, frame + i[at.I_LEAD], i[at.I_DAMP_RAMP])
    plan_strum(d, i, frame)
    choose_fingers(i)
    for note in range(i[at.G_COUNT]):
        if i[at.G_STRING + note] < 0:
            _drop(i, note, frame)
        else:
            _sound(d, i, note, frame)
    follow_touches(d, i, frame)


@kernel
def _forget_dropped(i):
    """Make room in a full chord: forget for good a note that has no string. Its drop, decided already, is kept."""
    for note in range(i[at.G_COUNT] - 1, -1, -1):
        if i[at.G_STRING + note] >= 0:
            continue
        count(i, at.NOTES_DROPPED)
        if i[at.G_OFF + note] == 0:
            _owe(i, i[at.G_CHANNEL + note], i[at.G_KEY + note])
        last = i[at.G_COUNT] - 1
        for row in range(at.GROUP_FIELDS):
            i[at.I_GROUP_ROWS + row * at.ROW + note] = i[at.I_GROUP_ROWS + row * at.ROW + last]
        i[at.G_COUNT] = last
        return


@kernel
def add_to_chord(i, channel, key, moved, wanted, partial, seq):
    """One more note for the chord (``recall_chord`` has been called, ``play_chord`` must follow)."""
    if i[at.G_COUNT] >= at.MAX_GROUP:
        _forget_dropped(i)
    note = i[at.G_COUNT]
    i[at.G_COUNT] = note + 1
    i[at.G_KEY + note], i[at.G_CHANNEL + note], i[at.G_WANTED + note] = key, channel, wanted
    i[at.G_PITCH + note], i[at.G_PARTIAL + note] = i[at.I_FOLD + wanted], partial
    i[at.G_SEQ + note], i[at.G_OFF + note], i[at.G_STRING + note] = seq, 0, -1
    i[at.G_MOVED + note], i[at.G_CAUGHT + note] = moved, 0
    i[at.G_FORCED + note], i[at.G_POSITION + note] = string_wanted(i, channel), i[at.C_POSITION + channel]


@kernel
def chord_note_off(i, channel, key):
    """The note-off of a note of the present chord; returns whether there is such a note."""
    for note in range(i[at.G_COUNT]):
        if i[at.G_KEY + note] == key and i[at.G_CHANNEL + note] == channel and i[at.G_OFF + note] == 0:
            i[at.G_OFF + note] = 1
            return True
    return False
