"""What the left hand can do: the position it takes for given frets, and the points that moving and stretching cost.

The hand stands at the fret under its index finger and covers ``span`` frets from there. Open strings ask nothing of it.
"""

from ukrt.engine import player_layout as at
from ukrt.engine.kernels.jit import kernel


@kernel
def hand_moved(hand, low, high, span):
    """The position nearest to ``hand`` that covers frets ``low`` to ``high`` (``low`` where it cannot cover both)."""
    least = max(1, high - span + 1)
    if least > low or hand > low:
        return low
    return max(hand, least)


@kernel
def shift_cost(hand, low, high, span):
    """Points for moving so that ``low`` to ``high`` are covered; 0 where nothing is stopped (``high`` < 1)."""
    if high < 1:
        return 0
    way = abs(hand_moved(hand, low, high, span) - hand)
    return at.COST_SHIFT * way + at.COST_SHIFT_ANY * min(way, 1)


@kernel
def strain(low, high, at_low, stopped, span):
    """Frets beyond the span plus fingers beyond four; strings stopped at the lowest fret share one finger (a barre)."""
    if stopped == 0:
        return 0
    fingers = stopped - at_low + 1
    return max(0, high - low + 1 - span) + max(0, fingers - at.FINGERS)


@kernel
def stops(i, s):
    """The fret that string ``s`` is held at by a sounding note, 0 if it is open or sounds no note."""
    state = i[at.S_STATE + s]
    if state == at.HELD or state == at.PEDALLED:
        return i[at.S_PITCH + s] - i[at.I_OPEN + s]
    return 0


@kernel
def choice_strain(i):
    """Strain of the assignment in X_PICK together with the notes that keep sounding, and the hull of all stopped frets.

    Returns
    -------
    strain, low, high, new_low, new_high : int
        Hull of all stopped frets and of the new ones alone; a high of 0 says that none is stopped.
    """
    low, high, at_low, stopped, new_low, new_high = 99, 0, 0, 0, 99, 0
    for s in range(i[at.I_STRINGS]):
        note = i[at.X_TAKER + s]
        if note >= 0:
            fret = i[at.G_PITCH + note] - i[at.I_OPEN + s]
        elif i[at.X_FREED + s] != at.REPEATING:
            fret = stops(i, s)
        else:
            fret = 0
        if fret < 1:
            continue
        stopped += 1
        if fret < low:
            low, at_low = fret, 0
        if fret == low:
            at_low += 1
        high = max(high, fret)
        if note >= 0:
            new_low, new_high = min(new_low, fret), max(new_high, fret)
    return strain(low, high, at_low, stopped, i[at.I_SPAN]), low, high, new_low, new_high


@kernel
def _sounds(i, s):
    """The pitch string ``s`` will sound if the assignment in X_TAKER is played, -1: none."""
    note = i[at.X_TAKER + s]
    if note >= 0:
        return i[at.G_PITCH + note]
    held = i[at.S_STATE + s] == at.HELD or i[at.S_STATE + s] == at.PEDALLED
    return i[at.S_PITCH + s] if held and i[at.X_FREED + s] != at.REPEATING else -1


@kernel
def _crossings(i):
    """Pairs of notes that sound together in another order than their open strings (which need not be ascending)."""
    pairs = 0
    for s in range(i[at.I_STRINGS]):
        pitch = _sounds(i, s)
        for lower in range(s if pitch >= 0 else 0):
            other = _sounds(i, lower)
            if other >= 0 and other != pitch:
                pairs += 1 if (other > pitch) != (i[at.I_OPEN + lower] > i[at.I_OPEN + s]) else 0
    return pairs


@kernel
def hand_cost(i):
    """Points of the assignment in X_TAKER for stretching, for moving the hand and for crossed voices."""
    tension, low, high, new_low, new_high = choice_strain(i)
    points = at.COST_STRETCH * tension + at.COST_CROSSED * _crossings(i)
    if new_high < 1:
        return points
    span = i[at.I_SPAN]
    if high - low + 1 > span:
        low, high = new_low, new_high
    return points + shift_cost(i[at.I_HAND], low, high, span)


@kernel
def place_hand(i):
    """Put the hand where the chord's notes are forced to have it (the last of them, where they differ)."""
    for note in range(i[at.G_COUNT]):
        if i[at.G_POSITION + note] > 0:
            i[at.I_HAND] = i[at.G_POSITION + note]


@kernel
def out_of_position(i, note, fret):
    """Whether a note's forced position leaves ``fret`` out of the hand's reach; open strings are within any, and a
    forced string is, whatever it stretches."""
    position = i[at.G_POSITION + note]
    return (
        position > 0 and i[at.G_FORCED + note] == 0 and fret > 0 and not position <= fret < position + i[at.I_SPAN]
    )


@kernel
def _is_told(i):
    """Whether string and position of a note of the chord are both given: the hand then is where it is told to be."""
    for note in range(i[at.G_COUNT]):
        if i[at.G_FORCED + note] > 0 and i[at.G_POSITION + note] > 0:
            return True
    return False


@kernel
def hand_follow(i):
    """Move the hand to where the assignment in X_TAKER needs it; returns what that strains it by."""
    tension, low, high, new_low, new_high = choice_strain(i)
    if new_high < 1:
        return 0
    if _is_told(i):
        return tension
    span = i[at.I_SPAN]
    if high - low + 1 > span:
        low, high = new_low, new_high
    i[at.I_HAND] = hand_moved(i[at.I_HAND], low, high, span)
    return tension
