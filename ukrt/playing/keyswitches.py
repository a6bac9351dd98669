"""Keys below (or above) the instrument that say how notes are played, for keyboards: each stands for controllers.

Enter a guitar; leave which keys are switches and what each of them sets. ``KEYSWITCHES`` is the table of
``ukrt/playing/README.md``; the compiled player (``engine/kernels/player_switches.py``) works by it.
"""

from dataclasses import dataclass

from ukrt.errors import ParameterError
from ukrt.model.fingerboard import fingerboard

# Numbers of controllers, those of ukrt/engine/controller_layout.py
WHEEL, ANGLE, HARMONIC, FLESH, MUTE, LOOSE, GLIDE, LEGATO, PLACE = 1, 16, 17, 18, 19, 27, 65, 68, 74
BACK = 0  # the group of the switch that ends all others
NAMES = ("C", "C#", "D", "D#", "E", "F", "F#", "G", "G#", "A", "A#", "B")


@dataclass(frozen=True)
class Switch:
    """One key.

    Attributes
    ----------
    words : str
        What it does.
    group : int
        A switch ends the others of its group.
    sets : tuple of (controller, off, soft, hard)
        Its controllers: their values without it, and with it at velocity 1 and 127.
    """

    words: str
    group: int
    sets: tuple = ()


KEYSWITCHES = (
    Switch("back to normal: ends all others", BACK),
    Switch("legato (CC 68)", 1, ((LEGATO, 0, 127, 127),)),
    Switch("slides (CC 65)", 1, ((GLIDE, 0, 127, 127),)),
    Switch("harmonics (CC 17)", 2, ((HARMONIC, 0, 127, 127),)),
    Switch("palm mute (CC 19), velocity says how much", 2, ((MUTE, 0, 1, 127),)),
    Switch(
        "pizzicato: muted (CC 19, by velocity) and plucked with the flesh (CC 18)",
        2,
        ((MUTE, 0, 1, 127), (FLESH, 0, 127, 127)),
    ),
    Switch("half lift (CC 27), velocity says how far", 3, ((LOOSE, 0, 1, 127),)),
    Switch("rest stroke (CC 16), velocity says how much", 4, ((ANGLE, 64, 65, 127),)),
    Switch("sul ponticello (CC 74), velocity says how near the bridge", 5, ((PLACE, 64, 65, 127),)),
    Switch("sul tasto (CC 74), velocity says how near the neck", 5, ((PLACE, 64, 63, 0),)),
    Switch("vibrato (CC 1), velocity says how much", 6, ((WHEEL, 0, 1, 127),)),
)


def value_of(soft, hard, velocity):
    """Value of a controller between ``soft`` (velocity 1) and ``hard`` (127)."""
    return soft + (hard - soft) * (velocity - 1) // 126


def switches_of(guitar):
    """Key (MIDI note) -> `Switch`; empty where the guitar has them off.

    Raises
    ------
    ParameterError
        If one of the keys is within the instrument's range, or beyond MIDI's.
    """
    first = guitar.playing.keyswitch_key
    if guitar.playing.keyswitches == "off":
        return {}
    board = fingerboard(guitar)
    lowest, highest = min(board.open_keys), max(board.open_keys) + board.frets
    last = first + len(KEYSWITCHES) - 1
    if last > 127 or (last >= lowest and first <= highest):
        legal = [f"from 0 to {lowest - len(KEYSWITCHES)}"] if lowest >= len(KEYSWITCHES) else []
        legal += [f"from {highest + 1} to {128 - len(KEYSWITCHES)}"] if highest + len(KEYSWITCHES) < 128 else []
        words = f"{len(KEYSWITCHES)} keyswitches must lie outside the guitar's keys, {lowest} to {highest}"
        where = f"it must be {' or '.join(legal)}" if legal else "there is no room for them"
        raise ParameterError("playing.keyswitch_key", first, f"{where}: {words}")
    return {first + n: switch for n, switch in enumerate(KEYSWITCHES)}


def settings(switch, velocity):
    """What a switch sets, in order: list of (controller, value)."""
    others = [one for one in KEYSWITCHES if switch.group in (BACK, one.group)]
    changes = [(controller, off) for one in others for controller, off, _, _ in one.sets]
    return changes + [(controller, value_of(soft, hard, velocity)) for controller, _, soft, hard in switch.sets]


def keyswitch_table(first=21):
    """The table as Markdown lines, without a line end after the last; ``first`` is the first key."""
    rows = [
        f"| {first + n} ({NAMES[(first + n) % 12]}{(first + n) // 12 - 1}) | {switch.words} |"
        for n, switch in enumerate(KEYSWITCHES)
    ]
    return "\n".join(["| key | switch |", "|---|---|", *rows])
