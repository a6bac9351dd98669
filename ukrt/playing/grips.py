"""What a left hand can hold: the frets of all sounding strings enter, what each place of the index finger costs leaves.

The hand's reach is a length and no number of frets, because frets get narrower up the neck: what it covers with
comfort is the way from fret 1 to fret ``hand_span_frets``; five frets at the seventh are as easy as four at the first.
"""

import functools
import itertools
from typing import NamedTuple

import numpy as np

from ukrt.model.fingerboard import fingerboard
from ukrt.playing import fingering_costs as cost
from ukrt.units import cents_to_ratio

FINGERS = 4


class Grip(NamedTuple):
    """One way to hold the sounding strings.

    Attributes
    ----------
    points : ndarray (max(frets, 1) + 1,)
        What it costs with the index finger at each fret, inf where that cannot be; [0] is never used.
    possible : bool
        Whether a hand can do it.
    stretch_m : float [m]
        How far the fingers lie apart beyond the comfortable reach.
    barre : bool
        Whether it needs one finger across several strings.
    """

    points: np.ndarray
    possible: bool
    stretch_m: float
    barre: bool


class Neck:
    """A fingerboard under a left hand.

    Parameters
    ----------
    open_keys : sequence of int
        Keys (MIDI notes) of the open strings, that on the bass side first.
    frets : int
    places : ndarray (max(frets, 1) + 1,) [m]
        From the nut to each fret.
    reach : float [m]
        Between index and little finger without strain.
    span : int
        Frets of a slur by hammer-on or pull-off, at most.
    """

    def __init__(self, open_keys, frets, places, reach, span=4):
        self.open, self.frets, self.places, self.reach = tuple(open_keys), frets, places, reach
        self.span = span
        self.ways = np.abs(self.places[:, None] - self.places)  # [m] between two positions
        self._grips, self._holds, self._metres = {}, {}, self.places.tolist()
        self._nowhere = np.full(len(self.places), np.inf)

    def grip(self, frets):
        """The `Grip` for the frets of all strings, lowest first: 0 open, -1 silent."""
        found = self._grips.get(frets)
        if found is None:
            found = self._grips[frets] = self._make_grip(frets)
        return found

    def holds(self, frets, new):
        """How a hand can hold these frets: all of them or, where that is too much, with fingers lifted that hold former
        notes: no more than a possible hand asks for, or, where even the ``new`` notes alone ask too much, any.

        Parameters
        ----------
        frets : tuple of int
            As for `grip`.
        new : tuple of int
            Strings whose notes begin.

        Returns
        -------
        sequence of (tuple, ndarray)
            The strings whose fingers are lifted, and what the rest costs with the index finger at each fret.
        """
        whole = self.grip(frets)
        if whole.possible:
            return (((), whole.points),)
        found = self._holds.get((frets, new))
        if found is None:
            found = self._holds[frets, new] = self._make_holds(frets, new)
        return found

    def _make_holds(self, frets, new):
        held, enough, ways = tuple([s for s, fret in enumerate(frets) if fret > 0 and s not in new]), [], []
        alone = self.grip(_without(frets, held))
        for lifted, mask in _subsets(held):
            if enough and any(less & mask == less for less in enough):
                continue
            found = self.grip(_without(frets, lifted))
            if found.possible:
                enough.append(mask)
            elif alone.possible:
                continue
            ways.append((lifted, found.points))
        return ways

    def crossings(self, frets):
        """Pairs of sounding strings whose notes lie the other way round than the open strings (int)."""
        sounding = [(note, note + fret) for note, fret in zip(self.open, frets, strict=True) if fret >= 0]
        pairs = itertools.combinations(sounding, 2)
        return sum([(pitch - other) * (note - beside) < 0 for (note, pitch), (beside, other) in pairs])

    def _make_grip(self, frets):
        points = self._nowhere.copy()
        stopped = [fret for fret in frets if fret > 0]
        crossed = cost.CROSSED * self.crossings(frets)
        if not stopped:
            points[1:] = crossed
            return Grip(points, True, 0.0, False)
        low, high, metres = min(stopped), max(stopped), self._metres
        wide = max(0.0, metres[high] - metres[low] - self.reach)
        too_wide = max(0.0, metres[high] - metres[low] - cost.WIDEST * self.reach)
        fingers, barre = len(stopped), False
        if fingers > FINGERS and _can_lie_across(frets, low):
            fingers, barre = fingers - stopped.count(low) + 1, True
        missing = max(0, fingers - FINGERS)
        possible = missing == 0 and too_wide == 0.0
        points[low] = crossed + cost.STRETCH_M * wide + cost.FINGER * min(fingers, FINGERS) + cost.BARRE * barre
        if not possible:
            points[low] += cost.BEYOND_HAND + cost.BEYOND_HAND_M * too_wide + cost.BEYOND_FINGERS * missing
        elif wide == 0.0 and len(stopped) < FINGERS:  # the index finger may wait at a lower fret
            for hand in range(low - 1, 0, -1):
                if metres[high] - metres[hand] > self.reach:
                    break
                points[hand] = points[low]
        return Grip(points, possible, wide, barre)


def _without(frets, lifted):
    left = list(frets)
    for s in lifted:
        left[s] = -1
    return tuple(left)


@functools.cache
def _subsets(held):
    """Every choice out of ``held`` (a tuple), the smallest first, and each as a mask."""
    some = [chosen for size in range(len(held) + 1) for chosen in itertools.combinations(held, size)]
    return [(chosen, sum(1 << s for s in chosen)) for chosen in some]


def _can_lie_across(frets, low):
    """Whether one finger at fret ``low`` can stop all strings that need it there: it would stop open ones between."""
    strings = [s for s, fret in enumerate(frets) if fret == low]
    return len(strings) > 1 and 0 not in frets[strings[0] : strings[-1]]


def neck_of(guitar):
    """The `Neck` of a ``Guitar``: from its capo on, with the frets of its scale on the longest string.

    What the hand reaches does not depend on either: it is the way between frets in semitones on the whole string.
    """
    board, span = fingerboard(guitar), guitar.playing.hand_span_frets
    longest = int(np.argmax([string.length for string in guitar.strings]))
    first, last = guitar.strings[longest].length * (1.0 - cents_to_ratio(np.array([-100.0, -100.0 * span])))
    places = board.ideal[longest]
    if not board.frets:  # a hand stands at fret 1, whether or not there is one
        places = np.append(places, board.guitar.strings[longest].length * (1.0 - cents_to_ratio(-100.0)))
    return Neck(board.open_keys, board.frets, places, last - first, span)
