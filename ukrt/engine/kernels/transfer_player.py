"""The guitarist with another guitar: what is held, owed, asked for and counted goes on; tables are the new guitar's.

Enter two instances whose strings have been carried over; leave the second's player, note log and timeline. A key that
is down stays down on its string, whatever that string's fret sounds now, so that its note-off still ends it. The notes
of strings that the new guitar lacks end; their note-offs are owed.
"""

from ukrt.engine import gestures as do
from ukrt.engine import layout
from ukrt.engine import player_layout as at
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.player_bend import follow_bend, follow_master
from ukrt.engine.kernels.player_chord import close_chord
from ukrt.engine.kernels.player_level import begin_ramp
from ukrt.engine.kernels.player_log import log_end
from ukrt.engine.kernels.player_modes import adopt_mode
from ukrt.engine.kernels.player_strings import ask
from ukrt.engine.kernels.timeline import timeline_cancel
from ukrt.engine.kernels.transfer_hands import carry_place, scaled_frames


@kernel
def transfer_player(d0, i0, d1, i1, now, pace):
    """Everything of the player and the timeline; ``pace`` is the new sample rate over the old."""
    strings0, strings1 = i0[layout.H_STRINGS], i1[layout.H_STRINGS]
    for k in range(at.I_STATE, at.I_GROUP):
        i1[k] = i0[k]
    i1[at.I_STROKE] = now + scaled_frames(i0[at.I_STROKE] - now, pace)
    for k in range(at.D_STATE, at.D_LOG_FORCE):
        d1[k] = d0[k]
    close_chord(i1)
    _copy_log(d0, i0, d1, i1)
    for s in range(min(strings0, strings1)):
        if i1[at.S_PITCH + s] >= 0:
            i1[at.S_PITCH + s] += i1[at.I_OPEN + s] - i0[at.I_OPEN + s]
        if pace != 1.0:
            for row in (at.S_DAMP, at.S_LIFT, at.S_UNDAMP, at.S_PRESS, at.S_TOUCHED, at.S_TENSION_FRAME):
                _carry_frame(i1, row + s, now, pace)
            for row in (at.S_PLUCK, at.S_PLANTED, at.S_PULLED, at.S_EASED, at.S_RESUMED):
                _carry_frame(i1, row + s, now, pace)
            for row in (at.S_LANDING, at.S_PULL, at.S_LATE, at.S_DAMPS, at.S_STEP):
                i1[row + s] = scaled_frames(i1[row + s], pace)
    for s in range(strings1, strings0):
        _give_up_string(d1, i1, s, now)
    _carry_gestures(d0, i0, d1, i1, now, pace)
    if i1[at.I_STARTED]:
        _idle_its_way(d1, i1, now, strings0, i0[at.I_DAMPED_IDLE])
    adopt_mode(d1, i1, now, i0[at.I_MODE], i0[at.I_BASE])
    for channel in range(at.CHANNELS):  # the preset's own bend range may be another
        follow_bend(d1, i1, now, channel)
    follow_master(d1, i1, now)  # strings that the old guitar lacked
    if pace != 1.0 and i1[at.I_LEVEL_LEFT] > 0:
        begin_ramp(d1, i1, max(1, scaled_frames(i1[at.I_LEVEL_LEFT], pace)))


@kernel
def _carry_frame(i, place, now, pace):
    """A frame of the past or of the future, if there is one at ``place``, at the new sample rate."""
    if 0 <= i[place] < at.UNTIL_DAMPED:
        i[place] = max(0, now + scaled_frames(i[place] - now, pace))


@kernel
def _copy_log(d0, i0, d1, i1):
    """The rows that are in use."""
    rows = min(i0[at.I_NEXT_SEQ], at.LOG_CAPACITY)
    for column in range(at.I_LOG, at.I_END, at.LOG_CAPACITY):
        for row in range(rows):
            i1[column + row] = i0[column + row]
    for row in range(rows):
        d1[at.D_LOG_FORCE + row] = d0[at.D_LOG_FORCE + row]


@kernel
def _give_up_string(d, i, s, now):
    """A string that is no longer there: its note ends, its row of the player's state is as at the start."""
    state = i[at.S_STATE + s]
    if state == at.HELD:
        i[at.I_OWED + i[at.S_CHANNEL + s] * 128 + i[at.S_KEY + s]] += 1
    if state == at.HELD or state == at.PEDALLED:
        log_end(i, i[at.S_SEQ + s], now, at.SILENCED)
    for row in (at.S_STATE, at.S_CHANNEL, at.S_KEY, at.S_FINGER, at.S_ORDER, at.S_TENSION_FRAME):
        i[row + s] = 0
    for row in (at.S_STAYS, at.S_LANDING, at.S_SPEED, at.S_PRESSURE, at.S_RELEASE, at.S_LET):
        i[row + s] = 0
    for row in (at.S_MOVED, at.S_TUNED, at.S_CAUGHT):
        i[row + s] = 0
    i[at.S_PULL + s] = i[at.S_LATE + s] = 0
    i[at.S_DAMPS + s] = i[at.S_STEP + s] = i[at.S_LOOSE + s] = i[at.S_HOLDS + s] = 0
    for row in (at.S_PITCH, at.S_SEQ, at.S_DAMP, at.S_LIFT, at.S_UNDAMP, at.S_PRESS, at.S_TOUCHED):
        i[row + s] = -1
    i[at.S_PLUCK + s] = i[at.S_PLANTED + s] = -1
    i[at.S_PULLED + s] = i[at.S_EASED + s] = i[at.S_RESUMED + s] = -1
    d[at.D_TENSION + s] = 1.0
    d[at.D_DEPTH + s] = d[at.D_PHASE + s] = 0.0


@kernel
def _carry_gestures(d0, i0, d1, i1, now, pace):
    """What was still to come, on the strings that there are, with places on the new guitar and frames at its rate."""
    count = 0
    for slot in range(i0[layout.H_GESTURES]):
        old_i, old = layout.GESTURES_I + 3 * slot, layout.GESTURES + 5 * slot
        kind, s = i0[old_i + 1], i0[old_i + 2]
        if s >= min(i0[layout.H_STRINGS], i1[layout.H_STRINGS]):
            continue
        new_i, new = layout.GESTURES_I + 3 * count, layout.GESTURES + 5 * count
        i1[new_i], i1[new_i + 1], i1[new_i + 2] = now + scaled_frames(i0[old_i] - now, pace), kind, s
        for k in range(5):
            d1[new + k] = d0[old + k]
        if kind == do.PRESS or kind == do.MOVE:
            d1[new] = carry_place(d0, i0, d1, i1, s, d0[old])
        ramp = new + 3 if kind == do.PLUCK else new + 1
        if pace != 1.0:
            d1[ramp] = float(max(1, scaled_frames(d1[ramp], pace)))
        count += 1
    i1[layout.H_GESTURES] = count
    i1[layout.H_GESTURES_DONE], i1[layout.H_GESTURES_DROPPED] = (
        i0[layout.H_GESTURES_DONE],
        i0[layout.H_GESTURES_DROPPED],
    )


@kernel
def _idle_its_way(d, i, now, strings0, damped_before):
    """Strings without a note idle as the new guitar's do, those that are new included."""
    for s in range(i[layout.H_STRINGS]):
        state = i[at.S_STATE + s]
        if state != at.IDLE and state != at.DAMPING:
            continue
        if i[at.I_DAMPED_IDLE] == 1 and s >= strings0:
            ask(d, i, now, do.DAMP, s, 1.0, 1.0)
            i[at.S_DAMP + s] = now
        elif i[at.I_DAMPED_IDLE] == 1 and damped_before == 0:
            waiting = timeline_cancel(d, i, s, do.UNDAMP, now)
            if i[at.S_DAMP + s] < 0 or (i[at.S_UNDAMP + s] >= 0 and waiting == 0):
                ask(d, i, now, do.DAMP, s, 1.0, i[at.I_DAMP_RAMP])
                i[at.S_DAMP + s] = now
            i[at.S_UNDAMP + s] = -1
        elif i[at.I_DAMPED_IDLE] == 0 and damped_before == 1 and i[at.S_DAMP + s] >= 0:
            i[at.S_UNDAMP + s] = max(now, i[at.S_DAMP + s] + i[at.I_SETTLE] + i[at.I_GAP])
            ask(d, i, i[at.S_UNDAMP + s], do.UNDAMP, s, 0.0, i[at.I_UNDAMP_RAMP])
