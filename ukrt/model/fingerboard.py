"""What there is to be played on: a guitar enters; the strings that sound (from the capo on), the key of each and the
pitch of each fret leave.

Keys are MIDI notes as they come. The scale says how high each key is (as Scala does); where it has other steps than the
equal-tempered semitone, a key number is no longer a semitone number. An open string is tuned to that key of the scale
which lies nearest to its note in equal temperament: so a guitar in 19 equal steps keeps its strings and their tensions
about as they are. Fret n is n keys above that.

A capo ends the strings: from its fret on they are strings of that length, as at the nut (a flexible string's length;
the player then tunes with the capo on). The part behind it does not sound, see `ukrt/playing/README.md`.
"""

import functools
from dataclasses import dataclass, replace

import numpy as np

from ..errors import ParameterError
from ..units import A4_HZ, cents_to_ratio, midi_to_hz, ratio_to_cents

KEYS = 128  # MIDI
A4_CENTS = 6900.0  # above MIDI note 0
MOST_FRETS = 24
REACH = 2400.0  # cents above the open string where a fingerboard ends: half way to the bridge and half of the rest
LEAST_STEP = 10.0  # cents between keys: frets nearer than 1 mm at the end of a guitar's neck cannot be fingered apart
FARTHEST = 150.0  # cents between a string's note and the nearest of the scale: half the widest step that is believed


@dataclass(frozen=True, eq=False)
class Fingerboard:
    """A guitar as it is played.

    Attributes
    ----------
    guitar : ukrt.model.parameters.Guitar
        Its strings end at the capo, places of the right hand are fractions of what is left; it has no capo.
    frets : int
        That can be stopped, from the capo on.
    open_keys : tuple of int
        Key of each string that no finger stops.
    hz : ndarray (n_strings, frets + 1) [Hz]
        Pitch of each fret; column 0 is the open string.
    ideal : ndarray (n_strings, frets + 1) [m]
        Places of the frets from nut or capo that flexible strings between rigid ends would want.
    """

    guitar: object
    frets: int
    open_keys: tuple
    hz: np.ndarray
    ideal: np.ndarray


@functools.lru_cache(maxsize=32)
def fingerboard(guitar):
    """Lay out the strings and frets of ``guitar``.

    Parameters
    ----------
    guitar : ukrt.model.parameters.Guitar

    Returns
    -------
    Fingerboard

    Raises
    ------
    ParameterError
        The scale has no note near an open string, the frets go on too far, or the right hand is behind the capo.
    """
    capo, frets = guitar.playing.capo, guitar.playing.frets
    cents, _ = key_cents(guitar.tuning)
    nuts = [_open_key(guitar, n) for n in range(len(guitar.strings))]
    rise = np.array([cents[key : key + frets + 1] - cents[key] for key in nuts])
    if rise[:, -1].max() > REACH + 1e-6:
        most = int(np.min(np.count_nonzero(rise <= REACH + 1e-6, axis=1))) - 1
        words = f"with this scale it must be at most {most}: more lie over two octaves above the open string"
        raise ParameterError("playing.frets", frets, words)
    speaking = cents_to_ratio(-rise[:, capo])
    played = _from_capo(guitar, speaking) if capo else guitar
    from_capo = rise[:, capo:] - rise[:, capo, None]
    fine = np.array([string.fine_tune for string in guitar.strings])[:, None]
    start = np.array([cents[key + capo] for key in nuts])[:, None]
    hz = _reference_hz(guitar.tuning) * cents_to_ratio(start + from_capo + fine)
    lengths = np.array([string.length for string in played.strings])[:, None]
    ideal = lengths * (1.0 - cents_to_ratio(-from_capo))
    for array in (hz, ideal):
        array.setflags(write=False)
    return Fingerboard(played, frets - capo, tuple(key + capo for key in nuts), hz, ideal)


@functools.lru_cache(maxsize=64)
def key_cents(tuning):
    """How high each key is, and whether it plays.

    Parameters
    ----------
    tuning : ukrt.model.parameters.Tuning

    Returns
    -------
    cents : ndarray (KEYS + MOST_FRETS,) [cents]
        Above the reference key; keys without a degree lie between their neighbours.
    plays : ndarray (KEYS,) of bool

    Raises
    ------
    ParameterError
        Keys do not rise by at least `LEAST_STEP`, or the reference key has no degree.
    """
    board = tuning.keyboard
    keys = np.arange(-KEYS, 2 * KEYS + MOST_FRETS)  # so many that every key has neighbours with a degree
    cents = np.array([_cents_of_key(tuning, key) for key in keys])
    known = np.isfinite(cents)
    if not known[keys == board.reference_key].any():
        raise ParameterError("keyboard.reference_key", board.reference_key, "it must be a key with a degree")
    cents = np.interp(keys, keys[known], cents[known]) - cents[keys == board.reference_key]
    step = np.diff(cents[KEYS:-KEYS])
    if step.min() < LEAST_STEP - 1e-9:
        at = int(np.argmin(step))
        words = f"key {at + 1} would lie {step[at]:.4g} cents above key {at}; frets need at least {LEAST_STEP:g} cents"
        raise ParameterError("scale", tuning.scale.name, words)
    plays = known[KEYS : 2 * KEYS].copy()
    plays[: board.first_key], plays[board.last_key + 1 :] = False, False
    return cents[KEYS:-KEYS], plays


def key_pitches(tuning):
    """How high each key is above MIDI note 0 of the guitar's own A4, ndarray (KEYS,) [cents]: 100 a key in 12 equal
    steps."""
    reference = float(ratio_to_cents(tuning.keyboard.reference_hz / A4_HZ))
    return key_cents(tuning)[0][:KEYS] + A4_CENTS + reference


def repeat_keys(tuning):
    """Keys after which the scale repeats: 12 where nothing else is asked for (int)."""
    return len(tuning.keyboard.degrees) or len(tuning.scale.cents)


def first_fret(guitar):
    """Distance of the first fret from nut or capo on the shortest string [m]; infinite where there is no fret."""
    board = fingerboard(guitar)
    return float(board.ideal[:, 1].min()) if board.frets else np.inf


def _cents_of_key(tuning, key):
    """Cents of ``key`` above degree 0 on the middle key; NaN where it has no degree."""
    board, scale = tuning.keyboard, (0.0, *tuning.scale.cents)

    def height(degree):
        turns, rest = divmod(degree, len(scale) - 1)
        return turns * scale[-1] + scale[rest]

    distance = int(key) - board.middle_key
    if not board.degrees:
        return height(distance)
    turns, rest = divmod(distance, len(board.degrees))
    if board.degrees[rest] == "x":
        return np.nan
    return height(int(board.degrees[rest])) + turns * height(board.octave_degree or len(scale) - 1)


def _reference_hz(tuning):
    return tuning.keyboard.reference_hz * tuning.a4_hz / A4_HZ


def _open_key(guitar, n):
    """The key that string ``n`` is tuned to at the nut."""
    cents, plays = key_cents(guitar.tuning)
    wanted = midi_to_hz(guitar.strings[n].note, guitar.tuning.a4_hz)
    beside = np.abs(cents[:KEYS] - ratio_to_cents(wanted / _reference_hz(guitar.tuning)))
    beside = np.where(plays, beside, np.inf)
    key = int(np.argmin(beside))
    if not beside[key] <= FARTHEST:
        words = f"no key plays a note within {FARTHEST:g} cents of it; tune the string to one, or move the keyboard map"
        raise ParameterError(f"strings.{n}.note", guitar.strings[n].note, words)
    return key


def _from_capo(guitar, speaking):
    """The guitar with strings that end at the capo; ``speaking`` (n_strings,) is what is left of each length."""
    strings = tuple(replace(one, length=one.length * part) for one, part in zip(guitar.strings, speaking, strict=True))
    left = float(np.mean(speaking))  # one right hand for all strings, which an unequal scale ends unequally
    places = [1.0 - (1.0 - place) / left for place in (guitar.pluck.place, *guitar.damper.places)]
    if min(places) < 0.01:
        words = "the right hand (pluck.place, damper.places) would be behind it; lower it"
        raise ParameterError("playing.capo", guitar.playing.capo, words)
    return replace(
        guitar,
        strings=strings,
        pluck=replace(guitar.pluck, place=places[0]),
        damper=replace(guitar.damper, places=tuple(places[1:])),
        playing=replace(guitar.playing, frets=0, capo=0),
    )
