"""Program changes and banks: what has acted on the engine enters, a choice among the guitars of a shelf leaves."""

import queue

from ..errors import UkrtError

_SYSTEM_RESET, _CONTROL, _PROGRAM, _PERCUSSION = 0xFF, 0xB0, 0xC0, 9
_BANKS = (0, 32)  # CC 0 and 32: the bank's upper and lower half
_NYLON_GUITAR = (0, 24)
_REST = "the guitar stays as it is (others like it are only counted)"


class Programs:
    """Bank 0 holds the guitars that ``--preset`` names, bank 1 those that come with the program.

    Parameters
    ----------
    shelf : PresetShelf
    of_piece : bool
        They are a piece's: its bank 1 means somebody else's sounds (in Roland's GS, an older sound set) and chooses
        nothing, and where there is but one guitar nobody need hear of its pianos.

    Attributes
    ----------
    chosen, unknown : int
        Program changes that a guitar answered to, or none; General MIDI's nylon guitar is neither, where so many are
        not named.
    """

    def __init__(self, shelf, of_piece=False):
        self.chosen = self.unknown = 0
        self._shelf, self._most_bank = shelf, 0 if of_piece else 1
        self._told = of_piece and len(shelf.names) == 1
        self._words = queue.SimpleQueue()
        self._banks = [[0, 0] for _ in range(16)]

    def follow(self, entries):
        """What has acted on the engine (ndarray (n, 2) of frames and words); called by the recorder's thread."""
        from ..engine.stage_layout import KIND_MIDI, KIND_SHIFT

        words = entries[:, 1]
        kinds, first = words >> 16 & 0xF0, words >> 8 & 0x7F
        banks = (kinds == _CONTROL) & ((first == _BANKS[0]) | (first == _BANKS[1]))
        wanted = (kinds == _PROGRAM) | banks | (words >> 16 == _SYSTEM_RESET)
        for word in words[(words >> KIND_SHIFT == KIND_MIDI) & wanted].tolist():
            self._words.put(word)

    def counts(self):
        """For the report (dict of int)."""
        return {"chosen": self.chosen, "unknown": self.unknown}

    def look(self):
        """Choose the guitar that was asked for last, if there is one.

        Returns
        -------
        list of str
            What there is to say about it.
        """
        before, news = self._shelf.chosen, []
        while not self._words.empty():
            news += self._take(self._words.get())
        if self._shelf.chosen != before:
            news.append(f"{self._asked}: {self._shelf.names[self._shelf.chosen]}")
        return news

    def _take(self, word):
        kind, channel, first = (word >> 16) & 0xF0, (word >> 16) & 0x0F, (word >> 8) & 0x7F
        if word >> 16 == _SYSTEM_RESET:
            self._banks = [[0, 0] for _ in range(16)]
        elif channel == _PERCUSSION:
            return []
        elif kind == _CONTROL:
            self._banks[channel][_BANKS.index(first)] = word & 0x7F
        else:
            upper, lower = self._banks[channel]
            return self._choose(upper or lower, first)
        return []

    def _choose(self, bank, program):
        words = f"program {program} of bank {bank}" if bank else f"program {program}"
        try:
            number = self._shelf.find(bank, program) if bank <= self._most_bank else None
        except UkrtError as error:
            return self._refuse(f"{words}: {error}")
        if number is None and (bank, program) == _NYLON_GUITAR:
            return []  # of General MIDI: that is what there is
        if number is None:
            return self._refuse(f"no guitar answers to program change {program} of bank {bank}")
        self.chosen += 1
        self._shelf.choose(number)
        self._asked = words
        return []

    def _refuse(self, words):
        self.unknown += 1
        told, self._told = self._told, True
        return [] if told else [f"{words}; {_REST}"]
