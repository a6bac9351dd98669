"""The lanes of messages on their way to the stage: one writer each, no lock; and the journal of what has acted.

A lane that fills up refuses first what can be missed (controllers, bends), then new notes, and the end of notes only
when it is full; what it refuses is counted by class. Indices are published with release, read with acquire order.
"""

from ukrt.engine import stage_layout as at
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.machine import load_acquire, store_release

_PEDALS_FROM, _PEDALS_TO, _DOWN = 64, 66, 64  # CC64 sustain, CC66 sostenuto; values from 64 on are "down"


@kernel
def message_class(word):
    """What a word is to a full lane: CLASS_OFF ends notes, CLASS_NOTE_ON begins one, CLASS_OTHER can be missed."""
    if word >> at.KIND_SHIFT != at.KIND_MIDI:
        return at.CLASS_OFF  # the stage's own events
    kind, data1, data2 = (word >> 16) & 0xF0, (word >> 8) & 0x7F, word & 0x7F
    if kind == 0x80 or (kind == 0x90 and data2 == 0):
        return at.CLASS_OFF
    if kind == 0x90:
        return at.CLASS_NOTE_ON
    if kind == 0xB0 and (data1 >= 120 or (_PEDALS_FROM <= data1 <= _PEDALS_TO and data2 < _DOWN)):
        return at.CLASS_OFF
    return at.CLASS_OFF if (word >> 16) & 0xFF == 0xFF else at.CLASS_OTHER


@kernel
def lane_push(si, lane, frame, word):
    """Put a word into a lane, by the lane's only writer; False (and counted) where the lane refuses it."""
    write = si[at.LANE_WRITE + at.LANE_STEP * lane]
    waiting = write - load_acquire(si, at.LANE_READ + at.LANE_STEP * lane)
    kind = message_class(word)
    room = at.ROOM[2]
    if kind == at.CLASS_OTHER:
        room = at.ROOM[0]
    elif kind == at.CLASS_NOTE_ON:
        room = at.ROOM[1]
    if waiting >= room:
        si[at.LANE_REFUSED + at.LANE_STEP * lane + kind] += 1
        return False
    slot = at.QUEUES + at.LANE_SIZE * lane + 2 * (write % at.QUEUE)
    si[slot], si[slot + 1] = frame, word
    store_release(si, at.LANE_WRITE + at.LANE_STEP * lane, write + 1)
    return True


@kernel
def next_lane(si):
    """The lane whose first message comes first (the lower lane of two of the same frame), -1 where all are empty."""
    found, first = -1, 1 << 62
    for lane in range(at.LANES):
        read = si[at.LANE_READ + at.LANE_STEP * lane]
        if read < load_acquire(si, at.LANE_WRITE + at.LANE_STEP * lane):
            frame = si[at.QUEUES + at.LANE_SIZE * lane + 2 * (read % at.QUEUE)]
            if frame < first:
                found, first = lane, frame
    return found


@kernel
def first_frame(si, lane):
    """The frame of a lane's first message, which is there."""
    return si[at.QUEUES + at.LANE_SIZE * lane + 2 * (si[at.LANE_READ + at.LANE_STEP * lane] % at.QUEUE)]


@kernel
def take_first(si, lane):
    """Remove a lane's first message, which is there; returns its word."""
    read = si[at.LANE_READ + at.LANE_STEP * lane]
    word = si[at.QUEUES + at.LANE_SIZE * lane + 2 * (read % at.QUEUE) + 1]
    store_release(si, at.LANE_READ + at.LANE_STEP * lane, read + 1)
    return word


@kernel
def journal(si, frame, word):
    """Note what acts at ``frame``; the oldest entries are overwritten, which the reader notices by their number."""
    count = si[at.N_JOURNAL]
    slot = at.JOURNAL_AT + 2 * (count % at.JOURNAL)
    si[slot], si[slot + 1] = frame, word
    store_release(si, at.N_JOURNAL, count + 1)
