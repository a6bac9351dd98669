"""System messages: reset, and SysEx whose pieces are put together again; what universal SysEx means is done here.

Enter pieces as `stage_layout.py` describes them; leave volumes, tunings and resets. Any device number is ours. What is
known and has no meaning for a guitar (dumps, requests, balance, makers' own) is ignored and counted, what does not have
the length that its kind must have is refused and counted: a message of which a piece has been lost never acts.
"""

from ukrt.engine import player_layout as at
from ukrt.engine import stage_layout as piece
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.player_bend import follow_master
from ukrt.engine.kernels.player_controllers import clear_channel, sound_off
from ukrt.engine.kernels.player_level import full_volume, set_volume
from ukrt.engine.kernels.player_log import count
from ukrt.engine.kernels.player_modes import clear_zones
from ukrt.engine.kernels.player_tuning import DONE, IGNORED, REFUSED, clear_tunings, tuning_message

SYSTEM_RESET = 0xFF
NON_REAL_TIME, REAL_TIME = 0x7E, 0x7F
DEVICE_CONTROL, TUNING, GENERAL_MIDI = 4, 8, 9  # first sub-id
VOLUME, FINE, COARSE = 1, 3, 4  # second, of device control
_OVERFLOWN = piece.SYSEX_BYTES + 1


@kernel
def _power_up(d, i, frame):
    """Every string damped, everything that messages have set as at power-up."""
    clear_tunings(i)
    full_volume(d, i)
    for channel in range(at.CHANNELS):
        sound_off(d, i, frame, channel)
        clear_channel(d, i, channel)
    clear_zones(i)
    follow_master(d, i, frame)


@kernel
def _device_control(d, i, frame, length):
    """Master volume and tunings, which are six bytes long."""
    what, value = i[at.I_SYSEX + 3], i[at.I_SYSEX + 5] * 128 + i[at.I_SYSEX + 4]
    if what != VOLUME and what != FINE and what != COARSE:
        return IGNORED
    if length != 6:
        return REFUSED
    if what == VOLUME:
        set_volume(d, i, at.I_MASTER_VOLUME, value)
    elif what == FINE:
        i[at.I_MASTER_FINE] = value
        follow_master(d, i, frame)
    else:
        i[at.I_MASTER_COARSE] = value // 128
    return DONE


@kernel
def _act(d, i, frame, length):
    """Do what a whole SysEx asks."""
    kind, about, what = i[at.I_SYSEX], i[at.I_SYSEX + 2], i[at.I_SYSEX + 3]
    if length < 4 or length > piece.SYSEX_BYTES:
        return REFUSED
    if kind == REAL_TIME and about == DEVICE_CONTROL:
        return _device_control(d, i, frame, length)
    if kind >= NON_REAL_TIME and about == TUNING:
        return tuning_message(d, i, frame, length)
    if kind == NON_REAL_TIME and about == GENERAL_MIDI and 1 <= what <= 3:
        if length != 4:
            return REFUSED
        _power_up(d, i, frame)
        return DONE
    return IGNORED


@kernel
def _add_byte(i, byte):
    """One more byte to the SysEx that has begun, if one has."""
    length = i[at.I_SYSEX_LENGTH]
    if 0 < length < piece.SYSEX_BYTES:
        i[at.I_SYSEX + length] = byte
        i[at.I_SYSEX_LENGTH] = length + 1
    elif length > 0:
        i[at.I_SYSEX_LENGTH] = _OVERFLOWN


@kernel
def _end(d, i, frame):
    length = i[at.I_SYSEX_LENGTH]
    i[at.I_SYSEX_LENGTH] = 0
    done = _act(d, i, frame, length)
    count(i, at.SYSEX_IGNORED, 1 if done == IGNORED else 0)
    count(i, at.SYSEX_REFUSED, 1 if done == REFUSED else 0)


@kernel
def system_message(d, i, frame, status, data1, data2):
    """Reset, a piece of a SysEx, or what is neither and is counted."""
    if status == SYSTEM_RESET:
        _power_up(d, i, frame)
    elif status == piece.SYSEX_BEGIN:
        i[at.I_SYSEX_LENGTH] = 2
        i[at.I_SYSEX], i[at.I_SYSEX + 1] = data1, data2
    elif status == piece.SYSEX_MORE:
        _add_byte(i, data1)
        _add_byte(i, data2)
    elif status == piece.SYSEX_END:
        if data2 > 0:
            _add_byte(i, data1)
        _end(d, i, frame)
    elif status == piece.SYSEX_SKIPPED:
        count(i, at.SYSEX_IGNORED if data1 == 0 else at.SYSEX_REFUSED)
    else:
        count(i, at.MESSAGES_IGNORED)
