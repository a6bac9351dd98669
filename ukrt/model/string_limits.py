"""What real strings would say to a tuning: a guitar enters, sentences leave about strings that
would break or rattle and about notes that its body keeps out of tune. Nothing is refused: the model plays on."""

import math

import numpy as np

from ..units import cents_to_ratio
from .fingerboard import fingerboard, key_cents
from .intonation import make_intonation
from .tunings import note_name

NYLON_DENSITY = 1140.0  # kg/m^3, of polyamide 6 and 6.6
# An estimate for nylon: the stress at which gut breaks, 1300 kg/m^3 (2 L f)^2 with L f = 260 Hz m, which Aquila Corde
# measured (240 to 280) and calls the breaking index. Nylon of 0.65 m would then break above G#4.
BREAKING_STRESS = 350e6  # Pa
# Of the core of a wound string, an estimate: what E4, which is bare nylon, has under its own stress of about 210 MPa:
# ES = 3396 N over 0.38e-3 kg/m / NYLON_DENSITY. Nylon is the stiffer the more it is stretched.
CORE_MODULUS = 10.2e9  # Pa
PLAIN_MODULUS = 1e9  # Pa: strings that are stiffer than that for their mass are bare (nylon: 2 to 15 GPa), others wound
# An estimate: 4 mm between string and fret 12 of 0.65 m, a usual set-up on the bass side of a classical guitar.
ACTION = 0.006  # of the length
WOLF = 1.0  # cents out of tune that are worth a word


def tuning_warnings(guitar):
    """What would go wrong with real strings.

    A string breaks where its tension is more than `BREAKING_STRESS` on its section: of bare nylon its mass tells it, of
    a wound string's core its axial stiffness (an estimate, and where that is 0 there is none). It rattles where a
    mezzo-forte pluck (halfway in dB between the preset's soft and strong) moves its middle, over fret 12, by more than
    `ACTION`: released from a triangle of height F L b (1 - b) / T at b from the bridge it swings by F L b / 2 T there.

    Parameters
    ----------
    guitar : ukrt.model.parameters.Guitar

    Returns
    -------
    list of str
    """
    out = []
    pluck = guitar.pluck
    force = math.sqrt(pluck.force_soft * pluck.force_strong) * abs(math.cos(pluck.angle))
    least = force * (1.0 - pluck.place) / (2.0 * ACTION)
    for n, (string, tension) in enumerate(zip(guitar.strings, _tensions(guitar), strict=True)):
        who = f"strings.{n} ({string.name})"
        section, wound = _section(string)
        most = BREAKING_STRESS * section
        if tension > most > 0.0:
            what, why = ("its core", ", estimated from its stiffness") if wound else ("nylon", "")
            out.append(f"{who} would break: it needs {tension:.0f} N, and {what} bears about {most:.0f} N{why}")
        if tension < least:
            words = f"at {tension:.0f} N an ordinary pluck drives it against the frets, at {least:.0f} N not (estimate)"
            out.append(f"{who} would rattle: {words}")
    return out


def wolf_warnings(guitar):
    """Which notes no tension and no fret can put in tune, since the body shares them; nothing in mode ``published``.

    Parameters
    ----------
    guitar : ukrt.model.parameters.Guitar

    Returns
    -------
    list of str
        One sentence at most.
    """
    if guitar.tuning.mode == "published":
        return []
    intonation = make_intonation(guitar)
    board, (_, plays) = fingerboard(guitar), key_cents(guitar.tuning)
    keys = np.array(board.open_keys)[:, None] + np.arange(board.frets + 1)
    off = np.where((keys < len(plays)) & plays[np.minimum(keys, len(plays) - 1)], intonation.cents_left, 0.0)
    count = int(np.count_nonzero(np.abs(off) > WOLF))
    if not count:
        return []
    string, fret = np.unravel_index(np.argmax(np.abs(off)), off.shape)
    worst = f"strings.{string} ({guitar.strings[string].name}), fret {fret}, by {off[string, fret]:+.1f} cents"
    are = "note is a wolf" if count == 1 else "notes are wolves"
    return [f"{count} {are}, out of tune since the body takes part in them; farthest off is {worst}"]


def describe_tuning(guitar):
    """How a guitar is tuned, ready for JSON: notes and keys of its open strings, capo, scale and A4."""
    board = fingerboard(guitar)
    return {
        "open_notes": [note_name(string.note) for string in guitar.strings],
        "open_keys": list(board.open_keys),
        "open_hz": [float(hz) for hz in board.hz[:, 0]],
        "capo": guitar.playing.capo,
        "scale": guitar.tuning.scale.name,
        "a4_hz": guitar.tuning.a4_hz,
    }


def _tensions(guitar):
    """Tension of each string, stiffness and body left aside [N]: list."""
    board = fingerboard(guitar)
    if guitar.tuning.mode == "published":
        return [string.tension * cents_to_ratio(2.0 * string.fine_tune) for string in guitar.strings]
    strings = board.guitar.strings
    return [one.linear_density * (2.0 * one.length * hz) ** 2 for one, hz in zip(strings, board.hz[:, 0], strict=True)]


def _section(string):
    """What carries the tension [m^2], and whether the string is wound."""
    whole = string.linear_density / NYLON_DENSITY
    bare = 4.0 * math.pi * string.bending_stiffness / whole**2 > PLAIN_MODULUS  # a round section has I = S^2 / 4 pi
    return (whole, False) if bare else (string.axial_stiffness / CORE_MODULUS, True)
