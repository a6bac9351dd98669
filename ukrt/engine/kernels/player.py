"""The guitarist: MIDI messages enter, each at its frame, and gestures on the strings' timeline leave.

A note-on at frame e begins its pluck at e and lets the string go at e + LEAD; note-offs and bends act LEAD frames late,
too.
The rules are written down for musicians in ``ukrt/playing/README.md``. Any three bytes at any time are a legal input.
"""

from ukrt.engine import gestures as do
from ukrt.engine import player_layout as at
from ukrt.engine.controller_layout import PEDAL, RESET, SOSTENUTO
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.player_bend import follow_bend
from ukrt.engine.kernels.player_chord import (
    add_to_chord,
    chord_note_off,
    end_note,
    play_chord,
    recall_chord,
)
from ukrt.engine.kernels.player_controllers import clear_channel
from ukrt.engine.kernels.player_expression import pluck_force, set_key_pressure
from ukrt.engine.kernels.player_holds import forget_hold, go_back
from ukrt.engine.kernels.player_level import full_volume
from ukrt.engine.kernels.player_log import count, log_end, log_note
from ukrt.engine.kernels.player_loosen import follow_touches
from ukrt.engine.kernels.player_modes import channel_control
from ukrt.engine.kernels.player_mono import is_beyond, is_percussion
from ukrt.engine.kernels.player_strings import ask, settle_string
from ukrt.engine.kernels.player_switches import is_switch, press_switch
from ukrt.engine.kernels.player_system import system_message
from ukrt.engine.kernels.player_touch import stopped_pitch
from ukrt.engine.kernels.player_tuning import clear_tunings, keys_moved, transposed, within_keys

NOTE_OFF, NOTE_ON, KEY_PRESSURE, CONTROL, PROGRAM, PRESSURE, BEND = 0x80, 0x90, 0xA0, 0xB0, 0xC0, 0xD0, 0xE0
SYSTEM = 0xF0


@kernel
def player_reset(d, i):
    """The player as before the first message: no notes, an empty log, counters at zero. The timeline is not touched."""
    for k in range(at.I_STATE, at.I_END):
        i[k] = 0
    for k in range(at.D_STATE, at.D_END):
        d[k] = 0.0
    for s in range(at.ROW):
        i[at.S_PITCH + s] = -1
        i[at.S_SEQ + s] = -1
        i[at.S_DAMP + s] = -1
        i[at.S_LIFT + s] = -1
        i[at.S_UNDAMP + s] = -1
        i[at.S_PRESS + s] = -1
        i[at.S_TOUCHED + s] = -1
        i[at.S_PLUCK + s] = -1
        i[at.S_PLANTED + s] = -1
        i[at.S_PULLED + s] = -1
        i[at.S_EASED + s] = -1
        i[at.S_RESUMED + s] = -1
        d[at.D_TENSION + s] = 1.0
    for channel in range(at.CHANNELS):
        clear_channel(d, i, channel)
    clear_tunings(i)
    d[at.D_LEVEL] = d[at.D_LEVEL_GOAL] = 1.0
    full_volume(d, i)
    i[at.I_HAND] = 1
    i[at.I_NOW] = -1


@kernel
def _start(d, i, frame):
    """Before anything else: the damper onto every string, where strings idle damped."""
    i[at.I_STARTED] = 1
    if i[at.I_DAMPED_IDLE] == 0:
        return
    for s in range(i[at.I_STRINGS]):
        ask(d, i, frame, do.DAMP, s, 1.0, 1.0)
        i[at.S_DAMP + s], i[at.S_DAMPS + s] = frame, i[at.I_DAMP_RAMP]


@kernel
def player_tick(d, i, frame):
    """Time has come to ``frame``: strings that have been damped become idle."""
    if i[at.I_STARTED] == 0:
        _start(d, i, frame)
    i[at.I_NOW] = max(i[at.I_NOW], frame)
    for s in range(i[at.I_STRINGS]):
        settle_string(i, s, frame)


@kernel
def _percussion(d, i, frame, kind, key, velocity):
    """Messages of channel 10: notes are logged and counted, nothing is played."""
    if kind == NOTE_ON and velocity > 0:
        count(i, at.NOTES_ON)
        count(i, at.NOTES_PERCUSSION)
        seq = log_note(d, i, frame, at.PERCUSSION_CHANNEL, key, 0.0)
        log_end(i, seq, frame, at.PERCUSSION)
    elif kind != NOTE_ON and kind != NOTE_OFF:
        count(i, at.MESSAGES_IGNORED)


@kernel
def _note_on(d, i, frame, channel, key, velocity):
    if is_switch(i, key):
        press_switch(d, i, frame, channel, key, velocity)
        return
    count(i, at.NOTES_ON)
    count(i, at.NOTES_BEYOND_STRINGS, 1 if is_beyond(i, channel) else 0)
    seq = log_note(d, i, frame, channel, key, pluck_force(d, i, channel, velocity))
    moved = keys_moved(i, channel, key)
    meant = transposed(i, channel, key + moved)
    wanted, partial = stopped_pitch(i, channel, within_keys(i, meant))
    pitch = i[at.I_FOLD + wanted]
    if pitch != wanted or meant != within_keys(i, meant):
        count(i, at.NOTES_FOLDED)
    if pitch >= 0:
        add_to_chord(i, channel, key, moved, wanted, partial, seq)
    else:
        count(i, at.NOTES_DROPPED)
        log_end(i, seq, frame, at.DROPPED)


@kernel
def _string_of(i, channel, key):
    """The string whose key is down, the one plucked longest ago if there are several; -1 if there is none."""
    found = -1
    for s in range(i[at.I_STRINGS]):
        if i[at.S_STATE + s] == at.HELD and i[at.S_CHANNEL + s] == channel and i[at.S_KEY + s] == key:
            if found < 0 or i[at.S_ORDER + s] < i[at.S_ORDER + found]:
                found = s
    return found


@kernel
def _note_off(d, i, frame, channel, key, velocity):
    """End the oldest note of this key that still waits for its note-off; ``velocity`` says how quickly."""
    owed = at.I_OWED + channel * 128 + key
    s = _string_of(i, channel, key)
    if i[owed] > 0:
        i[owed] -= 1
        forget_hold(i, channel, key)
    elif s >= 0 and not go_back(d, i, s, frame):
        i[at.S_HOLDS + s], i[at.S_DAMPS + s] = 0, i[at.I_DAMP_OF + velocity]
        end_note(d, i, s, frame)
    elif s < 0 and not chord_note_off(i, channel, key) and not is_switch(i, key):
        count(i, at.NOTES_OFF_UNMATCHED)


@kernel
def _changes_chord(kind, data1):
    """Whether a message can change what is best for the chord of its frame: notes and pedals (CC64, CC66, CC121)."""
    pedal = data1 == PEDAL or data1 == SOSTENUTO or data1 == RESET
    return kind == NOTE_ON or kind == NOTE_OFF or (kind == CONTROL and pedal)


@kernel
def _channel_message(d, i, frame, kind, channel, data1, data2):
    """A message of a channel other than the percussion's."""
    if kind == NOTE_ON and data2 > 0:
        _note_on(d, i, frame, channel, data1, data2)
    elif kind == NOTE_ON or kind == NOTE_OFF:
        _note_off(d, i, frame, channel, data1, data2)
    elif kind == CONTROL:
        channel_control(d, i, frame, channel, data1, data2)
    elif kind == BEND:
        count(i, at.BENDS)
        i[at.C_BEND + channel] = data2 * 128 + data1 - 8192
    elif kind == PRESSURE:
        i[at.C_PRESSURE + channel] = data1
    elif kind == KEY_PRESSURE:
        set_key_pressure(i, channel, data1, data2)
    elif kind == PROGRAM:  # whoever holds the guitars reads the journal
        count(i, at.PROGRAMS)
    else:
        count(i, at.MESSAGES_IGNORED)
    if kind == CONTROL:
        follow_touches(d, i, frame)
    if kind == CONTROL or kind == BEND:
        follow_bend(d, i, frame, channel)


@kernel
def player_message(d, i, frame, status, data1, data2):
    """One MIDI message at its frame. Frames that go back are taken as the latest frame seen."""
    frame = max(frame, i[at.I_NOW])
    player_tick(d, i, frame)
    status, data1, data2 = status & 0xFF, data1 & 0x7F, data2 & 0x7F
    kind, channel = status & 0xF0, status & 0x0F
    if kind == SYSTEM:
        system_message(d, i, frame, status, data1, data2)
    elif is_percussion(i, channel):
        _percussion(d, i, frame, kind, data1, data2)
    else:
        weigh = _changes_chord(kind, data1)
        if weigh:
            recall_chord(d, i, frame)
        _channel_message(d, i, frame, kind, channel, data1, data2)
        if weigh:
            play_chord(d, i, frame)
