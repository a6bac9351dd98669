"""String, fret and hand position for music that is known beforehand: the cheapest way through all of it.

Enter notes with their times, and a `Neck`; leave a `Place` for each. A state is which note lies on which string, and
where the index finger is; at every moment at which notes begin, each state that can be reached is extended by each way
to put the new notes on strings. Notes that still sound keep their string. Of all ways that lead to one state only the
cheapest is kept (Viterbi), so the result is the cheapest of all, unless a moment has more than ``MOST_WAYS``
occupations of the strings; then the dearest of them are given up, and counted.

Which notes play at all is no matter of cost: the rule is the compiled player's. In a chord the highest note is kept,
then the lowest, then the others from the top down, as long as strings can be found.
"""

import itertools
from dataclasses import dataclass

import numpy as np

from ukrt.playing import fingering_costs as cost
from ukrt.playing.legato import Legato
from ukrt.playing.matching import playable_notes, ways_to_place

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
    """The states after each moment: which note lies on which string -> points by hand position, and where from."""

    def __init__(self, notes, neck):
        self.notes, self.neck = notes, neck
        self.given_up = 0
        self._legato = Legato(notes, neck)
        self._silent = (-1,) * len(neck.open)
        self._states = {self._silent: np.zeros(len(neck.places))}
        self._history = []  # for each moment: occupation -> (former occupation by hand, former hand by hand)
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
        groups = self._groups(time_s, numbers)
        points = np.array([points for points, _ in groups.values()])
        ways = points[:, :, None] + self._moves(time_s)
        hands = np.argmin(ways, axis=1)  # where the hand comes from, for each group and each position it goes to
        arrived = np.take_along_axis(ways, hands[:, None, :], axis=1)[:, 0]
        after, origins = {}, {}
        for group, ((carried, former, slurs), (_, from_state)) in enumerate(groups.items()):
            origin = np.array([from_state[hands[group]], hands[group]])
            for occupation, extra, held in self._occupations(time_s, numbers, carried, former, slurs):
                total = arrived[group] + (held + extra)
                known = after.get(occupation)
                if known is None:
                    after[occupation], origins[occupation] = total, origin
                else:
                    better = total < known
                    after[occupation] = np.where(better, total, known)
                    origins[occupation] = np.where(better, origin, origins[occupation])
        self._states, self._last_s = self._cheapest(after), time_s
        self._history.append((self._order, origins))

    def _moves(self, time_s):
        """Points of a shift from each hand position to each other, in the time there is."""
        if self._last_s is None:
            return np.zeros_like(self.neck.ways)
        hurry = 1.0 + cost.HURRY_SECONDS / max(time_s - self._last_s, cost.LEAST_SECONDS)
        moves = np.where(self.neck.ways > 0.0, cost.SHIFT + cost.SHIFT_M * hurry * self.neck.ways, 0.0)
        moves[0, 1:] = moves[1:, 0] = np.inf
        return moves

    def _groups(self, time_s, numbers):
        """States that differ in nothing the future asks for, as one: the cheapest points for each hand position.

        The key is what goes on sounding, and the strings on which each new note's pitch sounded last, and from which
        each that is slurred goes on.
        """
        notes, pitches = self.notes, [self.notes[number].pitch for number in numbers]
        self._order, groups = list(self._states), {}
        for state, (occupation, points) in enumerate(self._states.items()):
            late = time_s + cost.LEGATO_SECONDS
            carried = tuple(n if n >= 0 and self._stays(n, time_s, late) else -1 for n in occupation)
            sounded = {notes[n].pitch: s for s, n in enumerate(occupation) if n >= 0}
            former = tuple(sounded.get(pitch, -1) for pitch in pitches)
            key = carried, former, self._legato.sources(numbers, occupation)
            if key not in groups:
                groups[key] = points.copy(), np.full(len(points), state)
            else:
                best, from_state = groups[key]
                from_state[points < best] = state
                np.minimum(best, points, out=best)
        return groups

    def _stays(self, number, time_s, late):
        """Whether a note keeps its string: it sounds on, or another is to be slurred from it."""
        return self.notes[number].end_s > late or self._legato.is_awaited(number, time_s)

    def _occupations(self, time_s, numbers, carried, former, slurs):
        """Every way to go on: (occupation, points of its own, points by hand position)."""
        notes, neck = self.notes, self.neck
        frets = tuple(tuple(notes[number].pitch - note for note in neck.open) for number in numbers)
        held = self._held_frets(carried, time_s)
        cuts = [self._cut(n, time_s) if n >= 0 else 0.0 for n in carried]
        for strings in ways_to_place(tuple(notes[number].pitch for number in numbers), neck):
            occupation, grip, points = list(carried), list(held), 0.0
            for k, s in enumerate(strings):
                occupation[s], grip[s] = numbers[k], frets[k][s]
                lost = self._legato.points(numbers[k], slurs[k], s)
                points += (cuts[s] if lost or slurs[k] < 0 else 0.0) + cost.FRET * frets[k][s] + lost
                points += cost.OTHER_STRING if former[k] not in (-1, s) else 0.0
            found = neck.grip(tuple(grip))
            if found.possible:
                yield tuple(occupation), points, found.points
            else:
                yield from self._let_go(occupation, grip, strings, cuts, points)

    def _let_go(self, occupation, grip, new, cuts, points):
        """The same with fingers lifted that hold former notes: no more than a possible hand asks for, or, where even
        the new notes alone ask too much, any."""
        held, enough = [s for s, fret in enumerate(grip) if fret > 0 and s not in new], []
        alone = self.neck.grip(tuple(-1 if s in held else fret for s, fret in enumerate(grip)))
        for lifted in (set(some) for size in range(len(held) + 1) for some in itertools.combinations(held, size)):
            if any(less <= lifted for less in enough):
                continue
            found = self.neck.grip(tuple(-1 if s in lifted else fret for s, fret in enumerate(grip)))
            if found.possible:
                enough.append(lifted)
            elif alone.possible:
                continue
            left = tuple(-1 if s in lifted else n for s, n in enumerate(occupation))
            yield left, points + sum(cuts[s] for s in sorted(lifted)), found.points

    def _cut(self, number, time_s):
        """Points for ending a ringing note now."""
        note = self.notes[number]
        if note.key_up_s <= time_s + cost.LEGATO_SECONDS:
            return cost.CUT_PEDALLED
        return cost.CUT_HELD + cost.CUT_HELD_ALL * (note.key_up_s - time_s) / (note.key_up_s - note.start_s)

    def _held_frets(self, carried, time_s):
        """What the hand holds already: notes whose key is down. The pedal holds notes without fingers."""
        late, notes = time_s + cost.LEGATO_SECONDS, self.notes
        return [
            notes[n].pitch - open_note if n >= 0 and notes[n].key_up_s > late else -1
            for n, open_note in zip(carried, self.neck.open, strict=True)
        ]

    def _cheapest(self, states):
        if len(states) <= MOST_WAYS:
            return states
        self.given_up += 1
        kept = sorted(states, key=lambda occupation: float(states[occupation].min()))[:MOST_WAYS]
        return {occupation: states[occupation] for occupation in kept}

    def result(self, moments):
        """Follow the cheapest state back."""
        places = [Place(-1)] * len(self.notes)
        best = min(self._states, key=lambda occupation: float(self._states[occupation].min()))
        points, hand, occupation = float(self._states[best].min()), int(np.argmin(self._states[best])), best
        cut = {}  # note -> (time, whether its string stays empty)
        for (time_s, numbers), (order, origins) in zip(reversed(moments), reversed(self._history), strict=True):
            states, hands = origins[occupation]
            for s, number in enumerate(occupation):
                if number in numbers:
                    fret = self.notes[number].pitch - self.neck.open[s]
                    places[number] = Place(s, fret, hand, *cut.get(number, (None, False)))
            former = order[states[hand]]
            for s, number in enumerate(former):
                if number < 0 or occupation[s] == number or self._legato.is_continued(number, occupation[s], s):
                    continue
                if self.notes[number].end_s > time_s + cost.LEGATO_SECONDS:
                    cut[number] = time_s, occupation[s] < 0
            occupation, hand = former, int(hands[hand])
        return Fingering(places, points, self.given_up)
