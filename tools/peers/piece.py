"""The piece that every system plays: sixteenth notes over chords that a hand can hold, made by a seeded generator.

Thirty bars of two seconds. In each the left hand holds one shape (open, or a barre at a random fret); the right hand
plays sixteen sixteenth notes: the lowest string of the shape on the first and the ninth, the others in a random order
that never repeats a string at once. Every second bar begins with bass and treble together: 30 * 16 + 15 = 495 notes.
Each rings until its string is plucked again or the hand moves, so that up to six sound at once.
"""

import random
from dataclasses import dataclass, replace

import mido

SEED = 495
BARS = 30
STEPS = 16  # a bar
STEP_S = 0.125
LIFT_S = 0.01  # a note ends this long before its string is needed: a finger has to come down first
TICKS_A_SECOND = 960  # 480 a beat at 120 beats a minute
OPEN_KEYS = (40, 45, 50, 55, 59, 64)  # MIDI numbers of E2 A2 D3 G3 B3 E4
NYLON_GUITAR = 24  # General MIDI program, counted from 0

# Frets from the lowest string up (None: not played); a barre shape is moved up by the fret of its barre.
OPEN_SHAPES = ((0, 2, 2, 1, 0, 0), (None, 0, 2, 2, 1, 0), (3, 2, 0, 0, 0, 3), (None, 3, 2, 0, 1, 0), (0, 2, 2, 0, 0, 0))
BARRE_SHAPES = ((0, 2, 2, 1, 0, 0), (0, 2, 2, 0, 0, 0), (0, 2, 0, 1, 0, 0), (None, 0, 2, 2, 2, 0))
HIGHEST_BARRE = 8


@dataclass(frozen=True)
class Note:
    """One note: from ``start`` to ``end`` [s]; ``string`` counts from 0, the lowest."""

    start: float
    end: float
    string: int
    key: int
    velocity: int


def make_piece(seed=SEED, bars=BARS):
    """All notes, in order of their start (list of Note)."""
    rng, notes = random.Random(seed), []
    for bar in range(bars):
        notes += _bar(rng, bar * STEPS * STEP_S, with_pinch=bar % 2 == 0)
    return notes


def first_seconds(notes, seconds):
    """What of the notes sounds within the first ``seconds`` (list of Note)."""
    return [replace(note, end=min(note.end, seconds)) for note in notes if note.start < seconds - LIFT_S]


def _bar(rng, start, with_pinch):
    shape, barre = _shape(rng)
    strings = [number for number, fret in enumerate(shape) if fret is not None]
    plucked, last = [], None
    for step in range(STEPS):
        on_bass = step % (STEPS // 2) == 0
        last = strings[0] if on_bass else rng.choice([number for number in strings[1:] if number != last])
        plucked.append((step, last, rng.randint(80, 100) if on_bass else rng.randint(55, 90)))
    if with_pinch:
        plucked.insert(1, (0, strings[-1], rng.randint(70, 95)))
    notes = []
    for k, (step, string, velocity) in enumerate(plucked):
        again = next((later for later, other, _ in plucked[k + 1 :] if other == string), STEPS)
        times = start + step * STEP_S, start + again * STEP_S - LIFT_S
        notes.append(Note(*times, string, OPEN_KEYS[string] + shape[string] + barre, velocity))
    return notes


def _shape(rng):
    """The frets that are held, and the barre to be added to them."""
    if rng.random() < 0.4:
        return rng.choice(OPEN_SHAPES), 0
    return rng.choice(BARRE_SHAPES), rng.randint(1, HIGHEST_BARRE)


def events(notes):
    """Ends and beginnings in the order of their times: list of (seconds, is_on, Note)."""
    both = [(note.end, False, note) for note in notes] + [(note.start, True, note) for note in notes]
    return sorted(both, key=lambda event: event[:2])


def write_midi(path, notes, seconds):
    """Write a MIDI file of one track that lasts ``seconds``."""
    track, now = mido.MidiTrack(), 0
    track.append(mido.Message("program_change", program=NYLON_GUITAR))
    for at, is_on, note in events(notes):
        kind, tick = "note_on" if is_on else "note_off", round(at * TICKS_A_SECOND)
        track.append(mido.Message(kind, note=note.key, velocity=note.velocity, time=tick - now))
        now = tick
    track.append(mido.MetaMessage("end_of_track", time=round(seconds * TICKS_A_SECOND) - now))
    mido.MidiFile(type=0, ticks_per_beat=TICKS_A_SECOND // 2, tracks=[track]).save(path)


def frequency(key):
    """Of a MIDI number [Hz]."""
    return 440.0 * 2.0 ** ((key - 69) / 12.0)


def write_events(path, notes, seconds, sample_rate=48000):
    """Write what the C++ programs read: frames in all, then a line for each event.

    A line: frame, string from 0, 1 or 0 for on or off, frequency [Hz], strength from 0 to 1.
    """
    lines = [str(round(seconds * sample_rate))]
    for at, is_on, note in events(notes):
        what = f"{note.string} {int(is_on)} {frequency(note.key):.6f} {note.velocity / 127:.4f}"
        lines.append(f"{round(at * sample_rate)} {what}")
    path.write_text("\n".join(lines) + "\n", encoding="ascii")
