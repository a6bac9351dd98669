"""String, fret and hand position for music that is known beforehand: the cheapest way through all of it.

Enter notes with their times, and a `Neck`; leave a `Place` for each. A state is which note lies on which string, and
where the index finger is; at every moment at which notes begin, each state that can be reached is extended by each way
to put the new notes on strings. Notes that still sound keep their string. Of all ways that lead to one state only the
cheapest is kept (Viterbi), so the result is the cheapest of all, unless a moment has more than ``MOST_WAYS``
occupations of the strings; then the dearest of them are given up, and counted.

Which notes play at all is no matter of cost: the rule is the compiled player's. In a chord the highest note is kept,
then the lowest, then the others from the top down, as long as strings can be found.
"""

from dataclasses import dataclass

import numpy as np

from ukrt.playing import fingering_costs as cost
from ukrt.playing.legato import Legato
from ukrt.playing.matching import playable_notes
from ukrt.playing.moment import Moment

MOST_WAYS = 250  # more than the shared guitar pieces need; dense music with the pedal down has more


@dataclass(frozen=True)
class Note:
    """A note as the search sees it.

    Attributes
    ----------
    start_s, key_up_s, end_s : float [s]
        It sounds from its start to its end: the key's coming up, or the pedal's.
    pitch : int
        MIDI note that is played, within the instrument's range.
    slurred_from : int
        Number of the note that it is to go on from, on the same string; -1: it is plucked.
    hammers, slides : bool
        Whether it may by hammer-on or pull-off, and by a slide.
    """

    start_s: float
    key_up_s: float
    end_s: float
    pitch: int
    slurred_from: int = -1
    hammers: bool = False
    slides: bool = False


@dataclass(frozen=True)
class Place:
    """Where a note is played.

    Attributes
    ----------
    string : int
        0 the lowest; -1: dropped.
    fret, hand : int
        Hand: the fret under the index finger as the note begins.
    cut_s : float or None [s]
        When it loses its string, or its finger, before its end.
    let_go : bool
        It is cut because the hand is needed elsewhere, though no new note takes its string.
    """

    string: int
    fret: int = -1
    hand: int = 0
    cut_s: float | None = None
    let_go: bool = False


@dataclass(frozen=True)
class Fingering:
    """The result of the search.

    Attributes
    ----------
    places : list of Place
    points : float
        What all of it costs.
    given_up : int
        Moments at which ways were given up for their number; 0: this is the cheapest fingering there is.
    """

    places: list
    points: float
    given_up: int


def find_fingering(notes, neck):
    """The cheapest fingering.

    Parameters
    ----------
    notes : sequence of Note
        In any order.
    neck : Neck

    Returns
    -------
    Fingering
        Places in the order of ``notes``.
    """
    search = _Search(notes, neck)
    moments = search.moments()
    for moment in moments:
        search.extend(*moment)
    return search.result(moments)


class _Search:
    """The states after each moment: which note lies on which string, points by hand position, and where from."""

    def __init__(self, notes, neck):
        self.notes, self.neck = notes, neck
        self.given_up = 0
        self._legato = Legato(notes, neck)
        self._states = [(-1,) * len(neck.open)]  # occupations of the strings
        self._points = np.zeros((1, len(neck.places)))  # of each, by hand position
        self._history = []  # for each moment: former states; rows of occupations; groups by row and hand; their origins
        self._last_s = None

    def moments(self):
        """(time, numbers of the notes that play) for each time at which notes begin."""
        order = sorted(range(len(self.notes)), key=lambda n: (self.notes[n].start_s, self.notes[n].pitch, n))
        starts = {}
        for number in order:
            starts.setdefault(self.notes[number].start_s, []).append(number)
        found = []
        for time_s, numbers in starts.items():
            kept = playable_notes([self.notes[number].pitch for number in numbers], self.neck)
            found.append((time_s, [numbers[k] for k in kept]))
        return found

    def extend(self, time_s, numbers):
        """One moment further."""
        sounding = {n for occupation in self._states for n in occupation if n >= 0}
        moment = Moment(time_s, numbers, sounding, self.notes, self.neck, self._legato)
        groups = {}  # states that differ in nothing the future asks for are one
        members = [groups.setdefault(moment.group_of(occupation), len(groups)) for occupation in self._states]
        points, states = _least_of_each(self._points, members, len(groups))
        ways = points[:, :, None] + self._moves(time_s)
        hands = np.argmin(ways, axis=1)  # where the hand comes from, for each group and each position it goes to
        arrived = np.take_along_axis(ways, hands[:, None, :], axis=1)[:, 0]
        rows, owners, extras, grips, from_group = {}, [], [], [], []
        for group, what in enumerate(groups):
            for occupation, extra, held in moment.occupations(*what):
                owners.append(rows.setdefault(occupation, len(rows)))
                extras.append(extra)
                grips.append(held)
                from_group.append(group)
        from_group = np.array(from_group)
        totals = arrived[from_group] + (np.array(grips) + np.array(extras)[:, None])
        points, chosen = _least_of_each(totals, owners, len(rows))
        origins = np.take_along_axis(states, hands, axis=1), hands
        self._history.append((self._states, rows, from_group[chosen], origins))
        self._last_s = time_s
        self._go_on_with_cheapest(list(rows), points)

    def _moves(self, time_s):
        """Points of a shift from each hand position to each other, in the time there is."""
        if self._last_s is None:
            return np.zeros_like(self.neck.ways)
        hurry = 1.0 + cost.HURRY_SECONDS / max(time_s - self._last_s, cost.LEAST_SECONDS)
        moves = np.where(self.neck.ways > 0.0, cost.SHIFT + cost.SHIFT_M * hurry * self.neck.ways, 0.0)
        moves[0, 1:] = moves[1:, 0] = np.inf
        return moves

    def _go_on_with_cheapest(self, states, points):
        if len(states) > MOST_WAYS:
            self.given_up += 1
            kept = np.argsort(points.min(axis=1), kind="stable")[:MOST_WAYS]
            states, points = [states[row] for row in kept], points[kept]
        self._states, self._points = states, points

    def result(self, moments):
        """Follow the cheapest state back."""
        places = [Place(-1)] * len(self.notes)
        row = int(np.argmin(self._points.min(axis=1)))
        points, hand, occupation = float(self._points[row].min()), int(np.argmin(self._points[row])), self._states[row]
        cut = {}  # note -> (time, whether its string stays empty)
        for (time_s, numbers), past in zip(reversed(moments), reversed(self._history), strict=True):
            order, rows, groups, (states, hands) = past
            group = groups[rows[occupation], hand]
            for s, number in enumerate(occupation):
                if number in numbers:
                    fret = self.notes[number].pitch - self.neck.open[s]
                    places[number] = Place(s, fret, hand, *cut.get(number, (None, False)))
            former = order[states[group, hand]]
            for s, number in enumerate(former):
                if number < 0 or occupation[s] == number or self._legato.is_continued(number, occupation[s], s):
                    continue
                if self.notes[number].end_s > time_s + cost.LEGATO_SECONDS:
                    cut[number] = time_s, occupation[s] < 0
            occupation, hand = former, int(hands[group, hand])
        return Fingering(places, points, self.given_up)


def _least_of_each(rows, owners, count):
    """The least of the rows of each owner, element by element, and the first row that has it: two (count, n).

    Parameters
    ----------
    rows : ndarray (m, n)
    owners : sequence (m,) of int
        Each of 0 to count - 1 has a row.
    count : int
    """
    owners = np.asarray(owners)
    order = np.argsort(owners, kind="stable")
    starts = np.searchsorted(owners[order], np.arange(count))
    least = np.minimum.reduceat(rows[order], starts, axis=0)
    first = np.where(rows == least[owners], np.arange(len(rows))[:, None], len(rows))
    return least, np.minimum.reduceat(first[order], starts, axis=0)
