"""Strings for the notes of one chord: first as many notes as strings can play, then the assignment that costs least.

Enter the chord (rows G_*) and what every string is doing; leaves G_STRING. Which notes get a string at all is found by
augmenting paths (bipartite matching), so a note is dropped only if no assignment whatever could play it too. Where too
many notes want too few strings, the highest and the lowest note go first, then the others from the top down; a note
that is out of its octave anyway then tries another one. Among the assignments of the notes that can be played a
depth-first search with bounds takes the cheapest, looking at SEARCH_NODES at most.
"""

from ukrt.engine import player_layout as at
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.player_hand import hand_cost, out_of_position, shift_cost
from ukrt.engine.kernels.player_log import count


@kernel
def _string_cost(i, s, youth):
    """Points for taking string ``s``, whatever is played on it."""
    state = i[at.S_STATE + s]
    if i[at.X_FREED + s] == at.REPEATING:
        return 0
    if state == at.HELD:
        return at.COST_STEAL_HELD + youth * at.COST_YOUTH
    if state == at.PEDALLED:
        return at.COST_STEAL_PEDALLED + youth * at.COST_YOUTH
    if i[at.S_PLUCK + s] > i[at.I_NOW]:  # its key is up, but the hand has yet to come to it
        return at.COST_STEAL_PEDALLED + youth * at.COST_YOUTH
    return at.COST_BUSY if state == at.DAMPING else 0


@kernel
def _is_forced_elsewhere(i, note, s):
    """Whether CC20 has named another string than ``s`` for a note of the chord."""
    number = i[at.G_FORCED + note]
    return number > 0 and s != i[at.I_STRINGS] - number


@kernel
def refused_forces(i):
    """Notes of the chord that play, but not on the string or within the position they were given."""
    refused = 0
    for note in range(i[at.G_COUNT]):
        s = i[at.G_STRING + note]
        if s >= 0:
            away = out_of_position(i, note, i[at.G_PITCH + note] - i[at.I_OPEN + s])
            refused += 1 if away or _is_forced_elsewhere(i, note, s) else 0
    return refused


@kernel
def _force_cost(i, note, s, fret):
    """Points for playing a note elsewhere than its channel's controllers want it."""
    points = at.COST_OTHER_STRING if _is_forced_elsewhere(i, note, s) else 0
    return points + (at.COST_OTHER_POSITION if out_of_position(i, note, fret) else 0)


@kernel
def fill_costs(i):
    """Points of each note of the chord on each string (X_COST); UNPLAYABLE where it has no such fret."""
    strings = i[at.I_STRINGS]
    for s in range(strings):
        youth = 0
        for other in range(strings):
            youth += 1 if i[at.S_ORDER + other] < i[at.S_ORDER + s] else 0
        points = _string_cost(i, s, youth)
        for note in range(i[at.G_COUNT]):
            fret = i[at.G_PITCH + note] - i[at.I_OPEN + s]
            cost = at.UNPLAYABLE
            if 0 <= fret <= i[at.I_FRETS]:
                cost = points + at.COST_FRET * fret + _force_cost(i, note, s, fret)
                if i[at.G_REPEAT + note] == s:
                    cost -= at.BONUS_REPEAT + (points if i[at.X_FREED + s] == at.SLURRING else 0)
                elif i[at.S_PITCH + s] == i[at.G_PITCH + note]:
                    cost -= at.BONUS_SAME
            i[at.X_COST + note * at.ROW + s] = cost


@kernel
def _more_important(i, a, b):
    """Whether note ``a`` comes before ``b``: the higher, of equals the one at its own octave, then the earlier."""
    pitch = i[at.G_PITCH + a]
    if pitch != i[at.G_PITCH + b]:
        return pitch > i[at.G_PITCH + b]
    folded_a, folded_b = i[at.G_WANTED + a] != pitch, i[at.G_WANTED + b] != pitch
    return folded_b if folded_a != folded_b else a < b


@kernel
def order_notes(i):
    """X_ORDER: notes by importance: the highest, the lowest, then the others from the top down."""
    notes = i[at.G_COUNT]
    for k in range(notes):
        slot = k
        while slot > 0 and _more_important(i, k, i[at.X_ORDER + slot - 1]):
            i[at.X_ORDER + slot] = i[at.X_ORDER + slot - 1]
            slot -= 1
        i[at.X_ORDER + slot] = k
    if notes > 2:
        lowest = i[at.X_ORDER + notes - 1]
        for k in range(notes - 1, 1, -1):
            i[at.X_ORDER + k] = i[at.X_ORDER + k - 1]
        i[at.X_ORDER + 1] = lowest


@kernel
def _augment(i, note):
    """Give ``note`` a string too, moving others along a path if need be; returns whether it could be done."""
    strings = i[at.I_STRINGS]
    for s in range(strings):
        i[at.X_PARENT + s] = -1
    i[at.X_QUEUE] = note
    read, write = 0, 1
    while read < write:
        here = i[at.X_QUEUE + read]
        read += 1
        for s in range(strings):
            if i[at.X_PARENT + s] >= 0 or i[at.X_COST + here * at.ROW + s] >= at.UNPLAYABLE:
                continue
            i[at.X_PARENT + s] = here
            if i[at.X_TAKER + s] < 0:
                while s >= 0:
                    mover = i[at.X_PARENT + s]
                    i[at.X_TAKER + s] = mover
                    s, i[at.G_STRING + mover] = i[at.G_STRING + mover], s
                return True
            i[at.X_QUEUE + write] = i[at.X_TAKER + s]
            write += 1
    return False


@kernel
def _clear_matching(i):
    for s in range(at.ROW):
        i[at.X_TAKER + s] = -1
    for note in range(i[at.G_COUNT]):
        i[at.G_STRING + note] = -1


@kernel
def _take(i, note, s):
    i[at.G_STRING + note] = s
    i[at.X_TAKER + s] = note


@kernel
def _match_forced(i, placed):
    """Match the first ``placed`` notes again, beginning with those that have a string to be on: what can be kept of
    that is then the search's first bound. Whatever is matched first, paths still reach the others."""
    _clear_matching(i)
    for k in range(placed):
        note = i[at.X_ORDER + k]
        s = i[at.I_STRINGS] - i[at.G_FORCED + note]
        if 0 <= s < i[at.I_STRINGS] and i[at.X_TAKER + s] < 0 and i[at.X_COST + note * at.ROW + s] < at.UNPLAYABLE:
            _take(i, note, s)
    for k in range(placed):
        if i[at.G_STRING + i[at.X_ORDER + k]] < 0:
            _augment(i, i[at.X_ORDER + k])


@kernel
def match_notes(i):
    """Give as many notes a string as possible; X_ORDER then holds those alone. Returns how many."""
    _clear_matching(i)
    placed = 0
    for k in range(i[at.G_COUNT]):
        note = i[at.X_ORDER + k]
        if _augment(i, note):
            i[at.X_ORDER + placed] = note
            placed += 1
    _match_forced(i, placed)
    return placed


@kernel
def _untake(i, note):
    s = i[at.G_STRING + note]
    if s >= 0:
        i[at.X_TAKER + s] = -1
        i[at.G_STRING + note] = -1


@kernel
def _prepare_search(i, placed):
    """Remember the matching's assignment (X_PICK), clear the strings, and bound from below what notes still cost.

    Returns the cost of the remembered assignment.
    """
    best = hand_cost(i)
    i[at.X_REST + placed] = 0
    for k in range(placed - 1, -1, -1):
        note = i[at.X_ORDER + k]
        s = i[at.G_STRING + note]
        i[at.X_PICK + k] = s
        best += i[at.X_COST + note * at.ROW + s]
        least = at.UNPLAYABLE
        for other in range(i[at.I_STRINGS]):
            least = min(least, i[at.X_COST + note * at.ROW + other])
        i[at.X_REST + k] = i[at.X_REST + k + 1] + least
    for k in range(placed):
        _untake(i, i[at.X_ORDER + k])
    i[at.X_TRY], i[at.X_SUM], i[at.X_LOW], i[at.X_HIGH] = 0, 0, 99, 0
    return best


@kernel
def _bound(i, k, points, low, high):
    """Least cost of an assignment whose first ``k`` + 1 notes make ``points`` and are stopped between low and high."""
    excess = max(0, high - low + 1 - i[at.I_SPAN])
    return points + i[at.X_REST + k + 1] + at.COST_STRETCH * excess + shift_cost(i[at.I_HAND], low, high, i[at.I_SPAN])


@kernel
def search(i, placed):
    """Improve on the matching: the cheapest assignment of the first ``placed`` notes of X_ORDER goes into G_STRING."""
    best = _prepare_search(i, placed)
    k, nodes = 0, 0
    while k >= 0:
        note = i[at.X_ORDER + k]
        _untake(i, note)
        s = i[at.X_TRY + k]
        i[at.X_TRY + k] = s + 1
        if s >= i[at.I_STRINGS] or nodes >= at.SEARCH_NODES:
            k -= 1
            continue
        cost = i[at.X_COST + note * at.ROW + s]
        if i[at.X_TAKER + s] >= 0 or cost >= at.UNPLAYABLE:
            continue
        nodes += 1
        points = i[at.X_SUM + k] + cost
        low, high = i[at.X_LOW + k], i[at.X_HIGH + k]
        fret = i[at.G_PITCH + note] - i[at.I_OPEN + s]
        if fret > 0:
            low, high = min(low, fret), max(high, fret)
        if _bound(i, k, points, low, high) >= best:
            continue
        _take(i, note, s)
        if k + 1 < placed:
            k += 1
            i[at.X_TRY + k], i[at.X_SUM + k], i[at.X_LOW + k], i[at.X_HIGH + k] = 0, points, low, high
        elif points + hand_cost(i) < best:
            best = points + hand_cost(i)
            for other in range(placed):
                i[at.X_PICK + other] = i[at.G_STRING + i[at.X_ORDER + other]]
    if nodes >= at.SEARCH_NODES:
        count(i, at.SEARCHES_CUT_SHORT)
    for other in range(placed):
        _take(i, i[at.X_ORDER + other], i[at.X_PICK + other])


@kernel
def _fold_further(i):
    """Move a dropped note that is out of its octave by one octave more; returns whether there was one to move."""
    for note in range(i[at.G_COUNT]):
        pitch = i[at.G_PITCH + note]
        if i[at.G_STRING + note] >= 0 or pitch == i[at.G_WANTED + note]:
            continue
        further = pitch + i[at.I_REPEAT] if pitch > i[at.G_WANTED + note] else pitch - i[at.I_REPEAT]
        if 0 <= further < 128 and i[at.I_FOLD + further] == further:
            i[at.G_PITCH + note] = further
            return True
    return False


@kernel
def choose_strings(i):
    """Strings for the notes of the chord into G_STRING (-1: dropped) and X_TAKER, pitches to play into G_PITCH."""
    for note in range(i[at.G_COUNT]):
        i[at.G_PITCH + note] = i[at.I_FOLD + i[at.G_WANTED + note]]
    for _ in range(at.MAX_GROUP):
        fill_costs(i)
        order_notes(i)
        placed = match_notes(i)
        if placed == i[at.G_COUNT] or not _fold_further(i):
            break
    if placed > 0:
        search(i, placed)
