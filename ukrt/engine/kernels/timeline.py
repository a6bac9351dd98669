"""The gestures still to come, in order of time: a small sorted list of fixed size.

Enter gestures from the player; leave, in order, those that are due. Gestures of the same frame keep the order they
came in.
"""

from ukrt.engine import layout as at
from ukrt.engine.kernels.jit import kernel


@kernel
def _copy(d, i, source, target):
    for k in range(3):
        i[at.GESTURES_I + 3 * target + k] = i[at.GESTURES_I + 3 * source + k]
    for k in range(5):
        d[at.GESTURES + 5 * target + k] = d[at.GESTURES + 5 * source + k]


@kernel
def timeline_add(d, i, frame, kind, s, p0, p1, p2, p3, p4):
    """Put a gesture in its place; returns 1, or 0 (and counts it) where the list is full."""
    count = i[at.H_GESTURES]
    if count >= at.MAX_GESTURES:
        i[at.H_GESTURES_DROPPED] += 1
        return 0
    slot = count
    while slot > 0 and i[at.GESTURES_I + 3 * (slot - 1)] > frame:
        _copy(d, i, slot - 1, slot)
        slot -= 1
    i[at.GESTURES_I + 3 * slot] = frame
    i[at.GESTURES_I + 3 * slot + 1] = kind
    i[at.GESTURES_I + 3 * slot + 2] = s
    place = at.GESTURES + 5 * slot
    d[place], d[place + 1], d[place + 2], d[place + 3], d[place + 4] = p0, p1, p2, p3, p4
    i[at.H_GESTURES] = count + 1
    return 1


@kernel
def timeline_cancel(d, i, s, kind, from_frame):
    """Remove string ``s``'s gestures of ``kind`` (negative: of every kind) from ``from_frame`` on; returns how many."""
    count, kept = i[at.H_GESTURES], 0
    for slot in range(count):
        same = i[at.GESTURES_I + 3 * slot + 2] == s and (kind < 0 or i[at.GESTURES_I + 3 * slot + 1] == kind)
        if not (same and i[at.GESTURES_I + 3 * slot] >= from_frame):
            if kept != slot:
                _copy(d, i, slot, kept)
            kept += 1
    i[at.H_GESTURES] = kept
    return count - kept


@kernel
def timeline_next(i, otherwise):
    """The frame of the first gesture, or ``otherwise`` if there is none or it comes first."""
    if i[at.H_GESTURES] == 0:
        return otherwise
    return min(otherwise, i[at.GESTURES_I])


@kernel
def timeline_drop_first(d, i):
    """Remove the first gesture."""
    count = i[at.H_GESTURES]
    for slot in range(1, count):
        _copy(d, i, slot, slot - 1)
    i[at.H_GESTURES] = count - 1
