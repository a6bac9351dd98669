"""Channel messages that are not notes: pitch bend with its range (RPN 0), pedals, volume, the string and the position
that notes to come are given, and the ways to end all notes. How notes are played is player_expression.py's.

Whatever is neither played nor followed is counted. The percussion channel's controllers are counted and ignored.
"""

from ukrt.engine import controller_layout as cc
from ukrt.engine import player_layout as at
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.player_bend import set_bend_range
from ukrt.engine.kernels.player_chord import close_chord, end_note
from ukrt.engine.kernels.player_expression import clear_expression, reset_expression, set_expression
from ukrt.engine.kernels.player_holds import forget_holds
from ukrt.engine.kernels.player_level import set_volume
from ukrt.engine.kernels.player_log import count, log_end
from ukrt.engine.kernels.player_pedals import is_held_by_pedal, set_sostenuto
from ukrt.engine.kernels.player_right_hand import clear_right_hand, reset_right_hand, set_right_hand
from ukrt.engine.kernels.player_rpn import clear_parameters, enter_parameter
from ukrt.engine.kernels.player_strings import damp_string, drop_pluck
from ukrt.engine.kernels.player_zones import bend_range


@kernel
def _data_entry(d, i, channel, controller, value):
    """CC6, 38, 96, 97: the bend range in semitones and cents where RPN 0 is chosen, or another parameter."""
    if i[at.C_RPN + channel] != 0:
        if not enter_parameter(d, i, channel, controller, value):
            count(i, at.NRPN_IGNORED if i[at.C_RPN + channel] == at.NRPN else at.RPN_IGNORED)
        return
    cents = bend_range(i, channel)
    if controller == cc.DATA_MSB:
        cents = value * 100 + cents % 100
    elif controller == cc.DATA_LSB:
        cents = cents - cents % 100 + min(value, 99)
    else:
        cents += 1 if controller == cc.INCREMENT else -1
    set_bend_range(i, channel, max(0, min(at.MAX_RANGE_CENTS, cents)))


@kernel
def _choose_rpn(i, channel, controller, value):
    """CC98 to 101: which parameter data entry is about."""
    if controller == cc.NRPN_LSB or controller == cc.NRPN_MSB:
        i[at.C_RPN + channel] = at.NRPN
        return
    rpn = i[at.C_RPN + channel] if i[at.C_RPN + channel] != at.NRPN else at.RPN_NULL
    if controller == cc.RPN_MSB:
        i[at.C_RPN + channel] = value * 128 + rpn % 128
    else:
        i[at.C_RPN + channel] = rpn - rpn % 128 + value


@kernel
def _force(i, channel, controller, value):
    """CC20, 21: the string (1 the highest) or the hand's position for the channel's notes to come; 0 lets them free."""
    row, most = at.C_STRING, at.MOST_STRING_NUMBER
    if controller == cc.POSITION:
        row, most = at.C_POSITION, i[at.I_FRETS]
    if value <= most:
        i[row + channel] = value
    else:
        count(i, at.CONTROLLERS_IGNORED)


@kernel
def set_pedals(d, i, frame, channel, controller, value):
    """CC64, 66 and, for both up, 121: those that come up end the notes that nothing else holds."""
    down = 1 if value >= cc.DOWN and controller != cc.RESET else 0
    if controller != cc.SOSTENUTO:
        i[at.C_PEDAL + channel] = down
    if controller != cc.PEDAL:
        set_sostenuto(i, channel, down)
    for s in range(i[at.I_STRINGS]):
        of_channel = i[at.S_STATE + s] == at.PEDALLED and i[at.S_CHANNEL + s] == channel
        if of_channel and not is_held_by_pedal(i, s):
            end_note(d, i, s, frame)


@kernel
def _forget_owed(i, channel):
    forget_holds(i, channel)
    for key in range(128):
        i[at.I_OWED + channel * 128 + key] = 0


@kernel
def notes_off(d, i, frame, channel):
    """CC123: every key of the channel comes up; the pedal still holds what it holds."""
    close_chord(i)
    _forget_owed(i, channel)
    for s in range(i[at.I_STRINGS]):
        if i[at.S_STATE + s] == at.HELD and i[at.S_CHANNEL + s] == channel:
            end_note(d, i, s, frame)


@kernel
def sound_off(d, i, frame, channel):
    """CC120: the channel's strings, and those that sound without a note, are damped at once, pedal or not."""
    close_chord(i)
    _forget_owed(i, channel)
    for s in range(i[at.I_STRINGS]):
        state = i[at.S_STATE + s]
        if state != at.IDLE and i[at.S_CHANNEL + s] != channel:
            continue
        if state == at.HELD or state == at.PEDALLED:
            log_end(i, i[at.S_SEQ + s], frame, at.SILENCED)
        drop_pluck(d, i, s, frame + 1)  # a finger that pulls already goes on
        damp_string(d, i, s, frame, frame, i[at.I_QUICK_RAMP])


@kernel
def control_change(d, i, frame, channel, controller, value):
    """One controller message, but for what bends do (``follow_bend`` comes after every one)."""
    if controller in (cc.PEDAL, cc.SOSTENUTO, cc.RESET):
        set_pedals(d, i, frame, channel, controller, value)
    if controller == cc.RESET:  # what RPNs have set stays (MIDI recommended practice RP-015)
        i[at.C_RPN + channel], i[at.C_BEND + channel] = at.RPN_NULL, 0
        i[at.C_STRING + channel], i[at.C_POSITION + channel] = 0, 0
        reset_expression(i, channel)
        set_volume(d, i, at.I_EXPRESSION, at.FULL_EXPRESSION)
        reset_right_hand(i, channel)
    elif controller == cc.BANK_MSB or controller == cc.BANK_LSB:
        count(i, at.PROGRAMS)
    elif controller == cc.STRING or controller == cc.POSITION:
        _force(i, channel, controller, value)
    elif controller in (cc.DATA_MSB, cc.DATA_LSB, cc.INCREMENT, cc.DECREMENT):
        _data_entry(d, i, channel, controller, value)
    elif cc.NRPN_LSB <= controller <= cc.RPN_MSB:
        _choose_rpn(i, channel, controller, value)
    elif controller == cc.SOUND_OFF:
        sound_off(d, i, frame, channel)
    elif controller >= cc.NOTES_OFF:
        notes_off(d, i, frame, channel)
    elif controller == cc.VOLUME or controller == cc.EXPRESSION:
        set_volume(d, i, at.I_VOLUME if controller == cc.VOLUME else at.I_EXPRESSION, value)
    elif controller not in (cc.PEDAL, cc.SOSTENUTO) and not set_expression(i, channel, controller, value):
        if not set_right_hand(i, channel, controller, value):
            count(i, at.CONTROLLERS_IGNORED)


@kernel
def clear_channel(d, i, channel):
    """A channel as it is at power-up."""
    i[at.C_BEND + channel] = 0
    i[at.C_RANGE + channel] = -1
    i[at.C_RPN + channel] = at.RPN_NULL
    i[at.C_PEDAL + channel], i[at.C_SOSTENUTO + channel] = 0, 0
    clear_parameters(i, channel)
    i[at.C_STRING + channel], i[at.C_POSITION + channel] = 0, 0
    clear_expression(i, channel)
    i[at.C_MONO + channel] = 0
    clear_right_hand(i, channel)
    d[at.D_BEND + channel] = 0.0
    _forget_owed(i, channel)
