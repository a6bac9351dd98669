"""Names of notes."""

_SHARP = (("C", 0), ("C", 1), ("D", 0), ("D", 1), ("E", 0), ("F", 0), ("F", 1), ("G", 0), ("G", 1), ("A", 0), ("A", 1),
          ("B", 0))  # fmt: skip
_FLAT = (("C", 0), ("D", -1), ("D", 0), ("E", -1), ("E", 0), ("F", 0), ("G", -1), ("G", 0), ("A", -1), ("A", 0),
         ("B", -1), ("B", 0))  # fmt: skip


def spell(key, fifths=0):
    """Letter (str), alteration (1 sharp, -1 flat) and octave of a MIDI note; flats where the key has them."""
    letter, alter = (_FLAT if fifths < 0 else _SHARP)[key % 12]
    return letter, alter, key // 12 - 1


def note_name(key, fifths=0):
    """Name of a MIDI note, such as ``C#5`` (60 is C4)."""
    letter, alter, octave = spell(key, fifths)
    return f"{letter}{'#' * alter}{'b' * -alter}{octave}"
