"""One moment of the search for string and fret: what is the same for all states there is worked out once.

Enter the time, the numbers of the notes that begin and of those that sound; leave, for a state, every way to go on.
"""

from ukrt.playing import fingering_costs as cost
from ukrt.playing.matching import ways_to_place


class Moment:
    """A time at which notes begin.

    Parameters
    ----------
    time_s : float [s]
    numbers : list of int
        The notes that begin and are played.
    sounding : iterable of int
        The notes that lie on a string in some state.
    notes : sequence of ukrt.playing.fingering.Note
    neck : ukrt.playing.grips.Neck
    legato : ukrt.playing.legato.Legato
    """

    def __init__(self, time_s, numbers, sounding, notes, neck, legato):
        self._numbers, self._neck, self._legato = numbers, neck, legato
        self._pitches, late = tuple([notes[number].pitch for number in numbers]), time_s + cost.LEGATO_SECONDS
        self._frets = [[pitch - note for note in neck.open] for pitch in self._pitches]
        self._ways = ways_to_place(self._pitches, neck)
        self._slurred = [notes[number].slurred_from >= 0 for number in numbers]
        self._stays, self._held, self._cut, self._repeated = {-1: -1}, {}, {-1: 0.0}, {}
        for n in sounding:
            note = notes[n]
            self._stays[n] = n if note.end_s > late or legato.is_awaited(n, time_s) else -1
            self._cut[n] = _cut(note, time_s)
            if note.key_up_s > late:  # the pedal holds notes without fingers
                self._held[n] = note.pitch
            if note.pitch in self._pitches:
                self._repeated[n] = note.pitch

    def group_of(self, occupation):
        """All that the future asks of a state: what goes on sounding, and the strings on which each new note's pitch
        sounded last, and from which each that is slurred goes on (a tuple of three)."""
        nowhere, stays, repeated = (-1,) * len(self._numbers), self._stays, self._repeated
        sounded = {repeated[n]: s for s, n in enumerate(occupation) if n in repeated} if repeated else None
        former = tuple([sounded.get(pitch, -1) for pitch in self._pitches]) if sounded else nowhere
        slurs = self._legato.sources(self._numbers, occupation) if any(self._slurred) else nowhere
        return tuple([stays[n] for n in occupation]), former, slurs

    def occupations(self, carried, former, slurs):
        """Every way to go on from such a group: (occupation, points of its own, points by hand position)."""
        neck, numbers, held = self._neck, self._numbers, self._held
        cuts = [self._cut[n] for n in carried]
        under = [held[n] - note if n in held else -1 for n, note in zip(carried, neck.open, strict=True)]
        for strings in self._ways:
            occupation, frets, points = list(carried), under.copy(), 0.0
            for k, s in enumerate(strings):
                fret = self._frets[k][s]
                occupation[s], frets[s] = numbers[k], fret
                lost = self._legato.points(numbers[k], slurs[k], s) if self._slurred[k] else 0.0
                points += (cuts[s] if lost or slurs[k] < 0 else 0.0) + cost.FRET * fret + lost
                if former[k] >= 0 and former[k] != s:
                    points += cost.OTHER_STRING
            for lifted, by_hand in neck.holds(tuple(frets), strings):
                if not lifted:
                    yield tuple(occupation), points, by_hand
                    continue
                left, lost = occupation.copy(), 0.0
                for s in lifted:
                    left[s] = -1
                    lost += cuts[s]
                yield tuple(left), points + lost, by_hand


def _cut(note, time_s):
    """Points for ending a ringing note now."""
    if note.key_up_s <= time_s + cost.LEGATO_SECONDS:
        return cost.CUT_PEDALLED
    return cost.CUT_HELD + cost.CUT_HELD_ALL * (note.key_up_s - time_s) / (note.key_up_s - note.start_s)
