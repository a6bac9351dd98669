"""One note at a time, on a string and fret of one's choice: an engine enters, its audio and the note's pitch leave.

MIDI notes choose their string by the player's rules. Here that choice alone is passed over: after the player's first
tick (which puts the dampers on where strings idle damped) its own `start_note` and `pluck_string` are called for the
string and fret, the functions that every plucked MIDI note ends in. For the string the player would have taken, the
audio is the same bit by bit.
"""

from typing import NamedTuple

import numpy as np

from ukrt.engine.kernels.player import player_tick
from ukrt.engine.kernels.player_attack import pluck_string
from ukrt.engine.kernels.player_strings import start_note
from ukrt.model.fingerboard import fingerboard

from .poles_from_signal import Component, cents_above, note_components

WINDOW = (0.6, 3.2)  # s after the release. The shipped response is 0.5 s long: from then on poles are all there is
REACH_CENTS = 100.0  # what is looked at on either side of the note
OWN_CENTS = 50.0  # beyond is another note: with idle strings open, theirs outlast one that the body takes away fast
RIVAL = 0.01  # of the note's energy in the window: more, and it takes part in the sound
EQUAL_A4_HZ = 440.0


class NotePitch(NamedTuple):
    """Partial 1 of a note: cents above where its scale wants it, decay [1/s], and whatever else is near and not faint.

    The pitch is that of the component with the most energy in the window among those at most half a semitone off or,
    where there is none, of all within a semitone (a note far out of tune, of which `paper` has one). With idle strings
    damped that is the string-like pole: beside it there is at most a body mode, which is fainter and decays faster
    (``rivals`` lets this be checked), and all else is far fainter: the motion in Z, which the bridge does not hear but
    which changes the tension; modes of the soft finger and the dead length; and components of the same frequency, to a
    few cents, and about three times the decay rate, which is how the fall of the tension with the amplitude looks in a
    sum of exponentials. With idle strings open a string in unison splits the pole in two; the pitch is then that of the
    one that is heard more, and the other is a rival.
    """

    string: int
    fret: int
    midi: int
    cents: float
    decay_rate: float
    energy: float
    rivals: tuple[Component, ...]


def forced_note(engine, string, fret, force, seconds):
    """Reset the engine and play one note; the audio begins with the string's release: ndarray (k, channels)."""
    engine.reset()
    player_tick(engine._d, engine._i, 0)
    start_note(engine._d, engine._i, string, 0, fret, 0)
    pluck_string(engine._d, engine._i, string, 0, fret, float(force), 0, 0, 0, 0)
    return after_release(engine, seconds)


def after_release(engine, seconds):
    """Audio of a note that starts at frame 0, from its release on: ndarray (k, channels)."""
    out = np.empty((engine.lead_frames + round(seconds * engine.sample_rate), engine.channels))
    engine.process_into(out)
    return out[engine.lead_frames :]


def note_pitch(engine, string, fret, force):
    """Play one note and measure it against its scale with A4 = 440 Hz: `NotePitch`."""
    board = fingerboard(engine.guitar)
    midi = board.open_keys[string] + fret
    target = float(board.hz[string, fret]) * EQUAL_A4_HZ / engine.guitar.tuning.a4_hz
    audio = forced_note(engine, string, fret, force, WINDOW[1])
    found = note_components(audio, engine.sample_rate, target, *WINDOW, REACH_CENTS)
    own = next((one for one in found if abs(cents_above(one, target)) <= OWN_CENTS), found[0])
    rivals = tuple(one for one in found if one is not own and one.energy > RIVAL * own.energy)
    return NotePitch(string, fret, midi, cents_above(own, target), own.decay_rate, own.energy, rivals)
