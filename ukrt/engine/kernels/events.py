"""What happens to the stage at a frame: messages are delivered, instances swapped, shedding and resets carried out.

Enter the lanes of messages and the requests of hosts; leave the player's work, and in the journal everything that has
acted, with its frame, so that a take can be replayed bit for bit.
"""

import numpy as np

from ukrt.engine import layout as instance_at
from ukrt.engine import stage_layout as at
from ukrt.engine.kernels.foreign import c_function
from ukrt.engine.kernels.jit import inlined, kernel
from ukrt.engine.kernels.process import come_to_rest
from ukrt.engine.kernels.queue import first_frame, journal, next_lane, take_first
from ukrt.engine.kernels.shed import set_shed
from ukrt.engine.kernels.slots import slot_arrays

FAR = 1 << 62
_play = c_function("int", "pointer", "int64", "int64")  # play.py, take_over.py: both compiled beside the callback
_take_over = c_function("int", "pointer", "int64", "int64")
_SENSING, _CONTROL, _PEDAL, _SOSTENUTO, _NOTES_OFF = 0xFE, 0xB0, 64, 66, 123


@kernel
def mono_word(kind, value):
    """A word of the stage's own kinds."""
    return kind << at.KIND_SHIFT | (value & at.VALUE_MASK)


@inlined
def shed(words, si, now, level):
    """Let ``level`` be shed from now on."""
    si[at.G_SHED] = level
    si[at.G_SHED_WANTED] = level
    si[at.N_SHED_EVENTS] += 1
    journal(si, now, mono_word(at.KIND_SHED, level))
    for slot in range(2):
        if slot == si[at.G_SLOT] or si[at.G_FADE] > 0:
            d, i, v, vi = slot_arrays(words, slot)
            set_shed(d, i, v, vi, level)


@inlined
def rest(words, si):
    """Bring what sounds to rest; a crossfade ends."""
    for slot in range(2):
        if slot == si[at.G_SLOT] or si[at.G_FADE] > 0:
            d, i, v, vi = slot_arrays(words, slot)
            come_to_rest(d, i, v, vi)
            set_shed(d, i, v, vi, si[at.G_SHED])
    si[at.G_FADE] = 0


@inlined
def swap(words, si, sd, now):
    """The other slot's instance takes over what sounds and is held, and is faded in."""
    old = si[at.G_SLOT]
    d0, i0, v0, vi0 = slot_arrays(words, old)
    d1, i1, v1, vi1 = slot_arrays(words, 1 - old)
    set_shed(d0, i0, v0, vi0, np.int64(0))  # what goes over is whole: no string asleep
    _take_over(words[at.W_TAKE_OVER], (words[at.W_TABLE], old, now))
    set_shed(d1, i1, v1, vi1, si[at.G_SHED])
    si[at.G_SLOT], si[at.G_SWAP] = 1 - old, 0
    rate = d1[instance_at.METER + instance_at.M_RATE]
    if rate == d0[instance_at.METER + instance_at.M_RATE]:
        si[at.G_FADE], si[at.G_FADE_IN] = at.FADE, 0
    else:
        si[at.G_FADE], si[at.G_FADE_IN] = 0, at.FADE
    sd[at.M_RATE] = rate
    si[at.N_SWAPS] += 1
    journal(si, now, mono_word(at.KIND_SWAP, si[at.G_SWAP_NUMBER]))


@inlined
def _deliver(words, si, now, word):
    """A MIDI message reaches the player."""
    journal(si, now, word)
    _play(words[at.W_PLAY], (words[at.W_TABLE], now, word))


@inlined
def mend(words, si, sd, now):
    """A host died within the callback and left a torn state, seen at the beginning of a block."""
    rest(words, si)
    sd[at.M_ENVELOPE] = 0.0  # the limiter has not seen what that host had computed
    si[at.G_TORN] = 0
    si[at.N_RESETS] += 1
    journal(si, now, mono_word(at.KIND_RESET, 0))


@inlined
def _act(words, si, now, word):
    """One of the stage's own events, of a take that is replayed."""
    kind, value = word >> at.KIND_SHIFT, word & at.VALUE_MASK
    if kind == at.KIND_SHED:
        shed(words, si, now, value)
    elif kind == at.KIND_RESET and value > 0:
        journal(si, now, word)
        si[at.N_RESETS] += 1
        si[at.G_MUTE_END] = now + value


@inlined
def _sense(si, lane, now, status):
    """Keep track of active sensing; True if the message was nothing else."""
    seen = at.LANE_SENSED + at.LANE_STEP * lane
    if status == _SENSING:
        si[seen] = now
        return True
    if si[seen] >= 0:
        si[seen] = now
    return False


@inlined
def tend_sensing(words, si, sd, now):
    """End the notes where a lane that had active sensing has been silent for too long: a cable was pulled."""
    for lane in range(at.LANES):
        seen = at.LANE_SENSED + at.LANE_STEP * lane
        if si[seen] >= 0 and now - si[seen] > at.SENSING_SECONDS * sd[at.M_RATE]:
            si[seen] = -1
            si[at.N_SENSING] += 1
            for channel in range(16):
                _deliver(words, si, now, (_CONTROL | channel) << 16 | _PEDAL << 8)
                _deliver(words, si, now, (_CONTROL | channel) << 16 | _SOSTENUTO << 8)
                _deliver(words, si, now, (_CONTROL | channel) << 16 | _NOTES_OFF << 8)


@inlined
def _has_room(si, now):
    """Whether one more message may be played in this chunk; what may not waits for the next."""
    if si[at.G_CAP] == 0:
        return True
    chunk = now // instance_at.CHUNK
    if si[at.G_CAP_CHUNK] != chunk:
        si[at.G_CAP_CHUNK], si[at.G_CAP_USED] = chunk, 0
    if si[at.G_CAP_USED] >= si[at.G_CAP]:
        si[at.G_CAP_HELD] = 1
        return False
    si[at.G_CAP_USED] += 1
    return True


@inlined
def take_messages(words, si, now):
    """Deliver every message that is due, in order of frames; returns the frame at which to look again."""
    while True:
        lane = next_lane(si)
        frame = first_frame(si, lane) if lane >= 0 else FAR
        if frame > now:
            si[at.G_CAP_HELD] = 0
            return frame
        if not _has_room(si, now):
            return (now // instance_at.CHUNK + 1) * instance_at.CHUNK
        word = take_first(si, lane)
        if 0 <= frame < now:
            si[at.N_DELAYED if si[at.G_CAP_HELD] else at.N_LATE_MESSAGES] += 1
        if word >> at.KIND_SHIFT != at.KIND_MIDI:
            _act(words, si, now, word)
        elif not _sense(si, lane, now, (word >> 16) & 0xFF):
            si[at.N_MIDI] += 1
            _deliver(words, si, now, word)
