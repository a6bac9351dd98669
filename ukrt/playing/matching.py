"""Which notes of a chord can be played together, and on which strings: the rule of the compiled player, in Python.

Enter pitches and a `Neck`; leave the notes that are kept (``engine/kernels/player_choice.py`` keeps the same ones, as
the tests see to) and every way to put them on different strings.
"""

import functools


def playable_notes(pitches, neck):
    """Numbers of the notes that are played, in the order of importance.

    Parameters
    ----------
    pitches : sequence of int
    neck : Neck

    Returns
    -------
    list of int
    """
    order = sorted(range(len(pitches)), key=lambda k: (-pitches[k], k))
    if len(order) > 2:
        order.insert(1, order.pop())
    taken, kept = {}, []
    for k in order:
        if _augment(k, pitches, neck, taken, set()):
            kept.append(k)
    return kept


def _augment(k, pitches, neck, taken, seen):
    """Give note ``k`` a string too, moving others if need be; whether it could be done."""
    for s, note in enumerate(neck.open):
        if 0 <= pitches[k] - note <= neck.frets and s not in seen:
            seen.add(s)
            if s not in taken or _augment(taken[s], pitches, neck, taken, seen):
                taken[s] = k
                return True
    return False


def ways_to_place(pitches, neck):
    """Every way to play all of ``pitches`` (a tuple): list of tuples of strings, no string twice."""
    return _ways(pitches, neck.open, neck.frets)


@functools.lru_cache(maxsize=4096)
def _ways(pitches, open_notes, frets):
    if not pitches:
        return [()]
    found = []
    for rest in _ways(pitches[1:], open_notes, frets):
        for s, note in enumerate(open_notes):
            if 0 <= pitches[0] - note <= frets and s not in rest:
                found.append((s, *rest))
    return found
