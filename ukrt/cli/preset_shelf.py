"""The guitars that ``--preset`` names, ready to be chosen while playing: names and settings enter, guitars leave, and
news of files that have changed on the disk."""

from ..errors import UkrtError
from ..model.presets import load_preset, preset_names


class PresetShelf:
    """Guitars by number, the first one chosen.

    Parameters
    ----------
    names : list of str
        Presets' names or TOML files, as ``--preset`` takes them.
    overrides : dict
        Dotted keys and their values, for all of them.

    Raises
    ------
    UkrtError
        One of them cannot be read or accepted.
    """

    def __init__(self, names, overrides=None):
        self.names, self.chosen, self._named = list(names), 0, len(names)
        self._overrides = dict(overrides or {})
        self._guitars = [load_preset(name, self._overrides) for name in self.names]
        self._complaints, self._suspects = {}, {}  # by number

    @property
    def guitar(self):
        """The one that is chosen (Guitar)."""
        return self._guitars[self.chosen]

    def choose(self, number):
        """Choose guitar ``number`` (from 0); False if there is none or it is chosen already."""
        if number == self.chosen or not 0 <= number < len(self.names):
            return False
        self.chosen = number
        return True

    def find(self, bank, program):
        """The number to `choose` for a program of a bank (int); None where there is none.

        Bank 0 holds the guitars that were named, bank 1 all that come with the program, in the order of
        `preset_names`; one that was not named is read now, with the settings, and joins the shelf.

        Raises
        ------
        UkrtError
            The settings do not fit it.
        """
        if bank == 0:
            return program if program < self._named else None
        shipped = preset_names()
        if bank > 1 or program >= len(shipped):
            return None
        name = shipped[program]
        if name not in self.names:
            self._guitars.append(load_preset(name, self._overrides))
            self.names.append(name)
        return self.names.index(name)

    def look(self):
        """Read the files again and take over what has changed.

        A file that cannot be accepted twice in the same way is complained of, once; an editor that is just writing it
        is given the time between two looks.

        Returns
        -------
        list of str
            A sentence for each file that has changed or has just been refused.
        """
        news = []
        for number, name in enumerate(self.names):
            if name.lower().endswith(".toml"):
                news += self._look_at(number, name)
        return news

    def _look_at(self, number, name):
        try:
            guitar = load_preset(name, self._overrides)
        except UkrtError as error:
            words, known = str(error), self._complaints.get(number)
            settled, self._suspects[number] = self._suspects.get(number) == words, words
            if words == known or not settled:
                return []
            self._complaints[number] = words
            return [f"{words}; the guitar as it was plays on"]
        self._complaints[number] = self._suspects[number] = None
        if guitar == self._guitars[number]:
            return []
        self._guitars[number] = guitar
        return [f"{name} has changed and is taken over"]
