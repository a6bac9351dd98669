"""Bent notes on the engine: notes enter, how well their pitch follows, and what it does to other strings, leaves.

What other strings should do comes from the oracle in continuous time (tests/oracle): its poles of two strings on the
body while one of them is at another tension.
"""

import pathlib
import tempfile
from dataclasses import dataclass, replace

import numpy as np
from accuracy.truth import fretted_contacts, oracle_poles
from oracle import ContactData, make_system, poles

import ukrt
from ukrt.model.intonation import make_intonation
from ukrt.model.presets import load_preset

from .guitar_file import BentNote, guitar_file
from .pitch_track import note_track, partial_track
from .poles_from_signal import fit_poles

RATE = 48000
RAMP_SECONDS = 0.0025  # half the time in which the tension follows a message: what the bend is late on average
FAINT = 10.0 ** (-40 / 20)  # of its loudest: below, a note has ended
FULL_BEND = 200.0  # cents, of the bends whose neighbours are listened to
PARTIALS = 6


def smooth(times, start, end):
    """From 0 at ``start`` to 1 at ``end``, without a kink."""
    share = np.clip((times - start) / (end - start), 0.0, 1.0)
    return share * share * (3.0 - 2.0 * share)


# What players of MIDI guitars do: range [semitones], cents over seconds. Slides arrive as bends in steps of a fret.
GESTURES = {
    "whole tone up": (2, lambda t: 200 * smooth(t, 0.4, 0.7)),
    "bent before, released": (2, lambda t: 200 * (1 - smooth(t, 0.5, 1.0))),
    "vibrato": (2, lambda t: 30 * np.sin(2 * np.pi * 5.5 * t) * smooth(t, 0.2, 0.6)),
    "slide over five frets": (12, lambda t: 100 * np.round(500 * smooth(t, 0.5, 1.2) / 100)),
    "down by a minor third": (24, lambda t: -300 * smooth(t, 0.3, 1.5)),
    "up and back": (12, lambda t: 200 * (smooth(t, 0.3, 0.5) - smooth(t, 0.9, 1.2))),
}


def render_notes(notes, idle):
    """Each string's force on the bridge, string 1 first: ndarray (n, 6) [N]; ``idle`` as `playing.idle_strings`."""
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "guitar.mid"
        guitar_file(notes).save(path)
        settings = {"playing.idle_strings": idle, "playing.midi_mode": "guitar"}
        samples, report = ukrt.render(path, sample_rate=RATE, signal="strings", overrides=settings)
    strings = {(note["channel"], note["string"], note["fret"]) for note in report["notes"]}
    wanted = {(note.string - 1, 6 - note.string, note.fret) for note in notes}
    assert strings == wanted, f"channels, strings and frets are {sorted(strings)} instead of {sorted(wanted)}"
    return samples[:, ::-1]


@dataclass(frozen=True)
class Followed:
    """A bent note against the same note unbent, over the time for which it lasts.

    Attributes
    ----------
    note : BentNote
    times, sent, off : ndarray (n,) [s since its start, cents, cents]
        What was sent, and how much higher the pitch was than that.
    fundamental : float [cents]
        The same of partial 1 alone, at its worst.
    """

    note: BentNote
    times: np.ndarray
    sent: np.ndarray
    off: np.ndarray
    fundamental: float


def follow(notes, idle):
    """How the pitch of notes, one after another, follows their bends (list of Followed)."""
    bent, plain = render_notes(notes, idle), render_notes([replace(note, bend=None) for note in notes], idle)
    return [_followed(note, bent[:, note.string - 1], plain[:, note.string - 1]) for note in notes]


def _followed(note, bent, plain):
    first, last = round((note.start + 0.04) * RATE), round((note.start + note.length - 0.02) * RATE)
    cents = note.cents(np.arange(first, last) / RATE - RAMP_SECONDS)
    hz = 440.0 * 2.0 ** ((note.key - 69) / 12)
    found = []
    for track in (note_track, partial_track):
        times, off, level = track(bent[first:last], RATE, hz, cents)
        _, before, _ = track(plain[first:last], RATE, hz, np.zeros(last - first))
        lasts = level > FAINT * level.max()
        found.append((times[lasts], (off - before)[lasts]))
    (times, off), (_, alone) = found
    sent = note.cents(times + first / RATE - RAMP_SECONDS)
    return Followed(note, times + first / RATE - note.start, sent, off, float(np.max(np.abs(alone))))


@dataclass(frozen=True)
class Neighbour:
    """What a partial of a sounding string does while another string is bent by a whole tone.

    Attributes
    ----------
    bent, string, partial : int
        Strings from 1, the highest.
    near : float [cents]
        To the nearest partial of the other string, at rest or bent.
    shift, expected : float [cents]
        What the pole moves by, in the sound, and by the oracle.
    """

    bent: int
    string: int
    partial: int
    near: float
    shift: float
    expected: float


def neighbours(frets, pairs, idle="damped"):
    """Partials 1 to 6 of strings while another is bent (list of Neighbour).

    Parameters
    ----------
    frets : sequence of int
        Of strings 1 to 6.
    pairs : sequence of (int, int)
        The string that is bent, the one that is listened to; no two pairs sound at the same time.
    """

    def notes(bend):
        for k, pair in enumerate(pairs):
            for s, bends in zip(pair, (bend, None), strict=True):
                yield BentNote("", s, frets[s - 1], 0.2 + 4.0 * k, 3.2, 2, bends)

    plain = render_notes(list(notes(None)), idle)
    held = render_notes(list(notes(lambda t: FULL_BEND * np.clip((t - 0.1) / 0.2, 0.0, 1.0))), idle)
    found = []
    for k, pair in enumerate(pairs):
        first, last = round((0.7 + 4.0 * k) * RATE), round((3.0 + 4.0 * k) * RATE)
        expected = expected_poles(pair, frets)
        for n, oracle in enumerate(expected, start=1):
            moved = (_hz_of(x[first:last, pair[1] - 1], pole) for x, pole in zip((plain, held), oracle, strict=True))
            shifts = (float(1200.0 * np.log2(b / a)) for a, b in (moved, oracle.imag))
            found.append(Neighbour(*pair, n, _nearest(pair, frets, n), *shifts))
    return found


def _hz_of(signal, pole):
    """Frequency [Hz] of the component that is the most like ``pole`` [rad/s], of those that are not faint.

    Motion in Z, which changes the tension, is heard faintly beside that in Y; it decays at another rate.
    """
    hz = pole.imag / (2.0 * np.pi)
    found = fit_poles(signal, RATE, hz, max(0.2 * hz, 16.0) if hz < 150.0 else 40.0)
    heard = [c for c in found if c.energy > FAINT * found[0].energy]
    return min(
        heard, key=lambda c: np.hypot(2.0 * np.pi * (c.frequency_hz - hz), c.decay_rate + pole.real)
    ).frequency_hz


def _hz(string, frets):
    return 440.0 * 2.0 ** ((BentNote("", string, frets[string - 1], 0.0, 0.0).key - 69) / 12)


def _nearest(pair, frets, n):
    """Cents from partial ``n`` of the second string to the nearest of the first, bent or not."""
    own = n * _hz(pair[1], frets)
    others = [p * _hz(pair[0], frets) * 2.0 ** (c / 1200.0) for p in range(1, 60) for c in (0.0, FULL_BEND)]
    return float(min(abs(1200.0 * np.log2(other / own)) for other in others))


def expected_poles(pair, frets, steps=10):
    """Poles of partials 1 to 6 of the second string, the first at rest and bent: ndarray (6, 2) complex [rad/s].

    All strings stand on the body, the others damped; the tension rises in small steps, and each pole is followed.
    """
    guitar = load_preset("classical")
    tuned = make_intonation(guitar)
    tensions = [float(t) for t in tuned.tensions]
    held, (bent, heard) = {}, (len(guitar.strings) - s for s in pair)
    for s, string in enumerate(guitar.strings):
        if s not in (bent, heard):
            resistance = guitar.damper.damping_ratio * np.sqrt(tensions[s] * string.linear_density)
            held[s] = [ContactData(x * string.length, damping=resistance) for x in guitar.damper.places]
    for s, number in ((bent, pair[0]), (heard, pair[1])):
        if frets[number - 1]:
            held[s] = fretted_contacts(guitar, float(tuned.places[s, frets[number - 1]]))

    def system(cents):
        now = [t * 2.0 ** (cents / 600.0) if s == bent else t for s, t in enumerate(tensions)]
        strings = tuple(replace(one, tension=t) for one, t in zip(guitar.strings, now, strict=True))
        return make_system(replace(guitar, strings=strings), held, polarization="Y")

    start = poles(system(0.0), oracle_poles(guitar, tuned, heard, frets[pair[1] - 1])[:PARTIALS])
    now = start
    for k in range(1, steps + 1):
        now = poles(system(FULL_BEND * k / steps), now)
    return np.stack([start, now], axis=1)
