"""Slurs in the search for string and fret: on which string a note can go on from another, and what it costs if not.

Enter the notes of the search; leave, at each moment, where the notes to be slurred come from. Without slurs nothing of
this has any effect.
"""

from ukrt.playing import fingering_costs as cost


class Legato:
    """The phrases of a piece: notes that are slurred one from the other are to lie on one string.

    Parameters
    ----------
    notes : sequence of Note
    neck : Neck
    """

    def __init__(self, notes, neck):
        self._notes, self._neck = notes, neck
        self._phrase, self._awaited_s = list(range(len(notes))), {}
        for number in sorted(range(len(notes)), key=lambda n: notes[n].start_s):
            source = notes[number].slurred_from
            if source >= 0:
                self._phrase[number] = self._phrase[source]
                self._awaited_s[source] = notes[number].start_s

    def is_awaited(self, number, time_s):
        """Whether another note is to be slurred from this one after ``time_s``."""
        return self._awaited_s.get(number, -1.0) > time_s

    def sources(self, numbers, occupation):
        """For each note the string where its phrase sounded last, -1 where it did not, or is not to be slurred."""
        return tuple(self._source(number, occupation) for number in numbers)

    def _source(self, number, occupation):
        if self._notes[number].slurred_from < 0:
            return -1
        phrase = self._phrase[number]
        same = [s for s, n in enumerate(occupation) if n >= 0 and self._phrase[n] == phrase]
        return max(same, key=lambda s: (self._notes[occupation[s]].start_s, s), default=-1)

    def goes_on(self, number, source, string):
        """Whether note ``number`` can be slurred on ``string`` from what its phrase has on string ``source``."""
        note, open_note = self._notes[number], self._neck.open[string]
        if source != string or note.slurred_from < 0:
            return False
        stop, fret = self._notes[note.slurred_from].pitch - open_note, note.pitch - open_note
        if stop < 0 or fret == stop:
            return False
        if note.slides and stop > 0 and fret > 0:
            return True
        return note.hammers and (fret == 0 or stop == 0 or abs(fret - stop) <= self._neck.span)

    def is_continued(self, former, number, string):
        """Whether what sounds as note ``former`` goes over, on its string, into note ``number`` (-1: none)."""
        return number >= 0 and self._phrase[former] == self._phrase[number] and self.goes_on(number, string, string)

    def points(self, number, source, string):
        """What it costs that note ``number``, put on ``string``, is not slurred."""
        meant = self._notes[number].slurred_from >= 0
        return cost.SLUR_LOST if meant and not self.goes_on(number, source, string) else 0.0
