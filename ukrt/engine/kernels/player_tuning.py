"""Tunings by MIDI: what a key is to sound, as the key that is fingered for it and what tension must add.

Enter the MIDI Tuning Standard's messages (single notes, scales of an octave) and coarse tunings; leave keys and
TUNING_UNITs. A key that is tuned far from its own pitch is played at the fret nearest to what it is to sound. Messages
of Universal Real Time (7F) move strings that sound, those of Non-Real Time (7E) act on notes to come. The standard's
note numbers and frequencies are taken at the guitar's own A4.

Source: MIDI Tuning Messages (CA-020, CA-021, RP-020), in The Complete MIDI 1.0 Detailed Specification.
"""

from ukrt.engine import player_layout as at
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.player_bend import bend_string, string_ratio
from ukrt.engine.kernels.player_log import count
from ukrt.engine.kernels.player_strings import note_cents

REAL_TIME = 0x7F
NOTES, NOTES_OF_BANK, SCALE, FINE_SCALE = 2, 7, 8, 9  # second sub-id after 08
DONE, IGNORED, REFUSED = range(3)
_SEMITONE = 100 * at.TUNING_UNIT


@kernel
def clear_tunings(i):
    """Every key at its own pitch."""
    i[at.I_MASTER_FINE], i[at.I_MASTER_COARSE] = at.MIDDLE_FINE, at.MIDDLE_COARSE
    for k in range(at.CHANNELS * 12):
        i[at.I_SCALE + k] = 0
    for key in range(128):
        i[at.I_NOTE_PITCH + key] = -1


@kernel
def _tuned(i, channel, key):
    """How far the tuning moves a key from its own pitch [TUNING_UNITs]."""
    units = i[at.I_SCALE + channel * 12 + key % 12]
    if i[at.I_NOTE_PITCH + key] >= 0:
        units += i[at.I_NOTE_PITCH + key] - i[at.I_KEY_PITCH + key]
    return units


@kernel
def keys_moved(i, channel, key):
    """By how many keys the tuning moves a key: to the one whose own pitch is nearest, its own of two as near."""
    wanted, found = i[at.I_KEY_PITCH + key] + _tuned(i, channel, key), key
    while found < 127 and wanted - i[at.I_KEY_PITCH + found] > i[at.I_KEY_PITCH + found + 1] - wanted:
        found += 1
    while found > 0 and i[at.I_KEY_PITCH + found] - wanted > wanted - i[at.I_KEY_PITCH + found - 1]:
        found -= 1
    return found - key


@kernel
def transposed(i, channel, key):
    """A key moved by the coarse tunings."""
    return key + i[at.C_COARSE + channel] + i[at.I_MASTER_COARSE] - 2 * at.MIDDLE_COARSE


@kernel
def within_keys(i, key):
    """A key beyond MIDI's range comes back by as many octaves (of the scale) as it takes."""
    while key < 0:
        key += i[at.I_REPEAT]
    while key > 127:
        key -= i[at.I_REPEAT]
    return max(0, key)


@kernel
def tune_note(i, s, channel, key, moved):
    """Let string ``s`` be tuned as a note of this key now is that is fingered ``moved`` keys away."""
    fingered = i[at.I_KEY_PITCH + key + moved] - i[at.I_KEY_PITCH + key]
    i[at.S_MOVED + s] = moved
    i[at.S_TUNED + s] = _tuned(i, channel, key) - fingered


@kernel
def _retune(d, i, frame, channel, key):
    """Bring strings that sound to what their notes are tuned to now; of all channels or keys where these are -1."""
    for s in range(i[at.I_STRINGS]):
        own, its_key = i[at.S_CHANNEL + s], i[at.S_KEY + s]
        sounds = i[at.S_STATE + s] == at.HELD or i[at.S_STATE + s] == at.PEDALLED
        if sounds and (channel < 0 or own == channel) and (key < 0 or its_key == key):
            tune_note(i, s, own, its_key, i[at.S_MOVED + s])
            count(i, at.BENDS_LIMITED, 1 if abs(note_cents(d, i, s, own)) > at.MAX_BEND_CENTS else 0)
            bend_string(d, i, s, frame, string_ratio(d, i, s))


@kernel
def _tune_notes(d, i, frame, now, at_byte, changes):
    """Single notes: key, semitone and 14 bits of a semitone each; three times 7F is no change."""
    for k in range(at_byte, at_byte + 4 * changes, 4):
        key, semitone, fraction = i[k], i[k + 1], i[k + 2] * 128 + i[k + 3]
        if semitone == 127 and fraction == 16383:
            continue
        i[at.I_NOTE_PITCH + key] = semitone * _SEMITONE + fraction * (_SEMITONE // 16384)
        if now:
            _retune(d, i, frame, -1, key)


@kernel
def _tune_scale(d, i, frame, now, at_byte, wide):
    """Twelve offsets from C on, for the channels of a bitmap: 16 and 15, 14 to 8, 7 to 1."""
    bits = (i[at_byte] & 3) << 14 | i[at_byte + 1] << 7 | i[at_byte + 2]
    first = at_byte + 3
    for channel in range(at.CHANNELS):
        if bits >> channel & 1 == 0:
            continue
        for k in range(12):
            if wide:
                units = (i[first + 2 * k] * 128 + i[first + 2 * k + 1] - at.MIDDLE_FINE) * at.FINE_UNITS
            else:
                units = (i[first + k] - 64) * at.TUNING_UNIT
            i[at.I_SCALE + channel * 12 + k] = units
        if now:
            _retune(d, i, frame, channel, -1)


@kernel
def tuning_message(d, i, frame, length):
    """A message of the tuning standard, ``length`` bytes from 7E or 7F on; returns DONE, IGNORED or REFUSED."""
    now, what = i[at.I_SYSEX] == REAL_TIME, i[at.I_SYSEX + 3]
    first = 5 if what == NOTES else 6  # the byte that counts changes
    if what == NOTES_OF_BANK or (what == NOTES and now):
        if length <= first or length != first + 1 + 4 * i[at.I_SYSEX + first]:
            return REFUSED
        if i[at.I_SYSEX + 4] != 0 or i[at.I_SYSEX + first - 1] != 0:  # another bank or programme than the one there is
            return IGNORED
        _tune_notes(d, i, frame, now, at.I_SYSEX + first + 1, i[at.I_SYSEX + first])
    elif what == SCALE or what == FINE_SCALE:
        if length != (19 if what == SCALE else 31):
            return REFUSED
        _tune_scale(d, i, frame, now, at.I_SYSEX + 4, what == FINE_SCALE)
    else:
        return IGNORED
    return DONE
