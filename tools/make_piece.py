#!/usr/bin/env python3
"""Writes the bundled demonstration piece, ukrt/data/romance.mid, from the note list below.

The piece is the anonymous Romance for guitar (Spain, 19th century; also known as Estudio en Mi), public domain. This is
the ukrt authors' own transcription, under the same MIT licence as the program: the melody, the arpeggio under it and
the bass as guitarists commonly play them, with dynamics, rubato and the unevenness of a hand (seeded, so that the file
is the same each time).

    tools/make_piece.py [FILE]
"""

import math
import pathlib
import random
import sys
from dataclasses import dataclass

import mido

OPEN_STRINGS = {6: 40, 5: 45, 4: 50, 3: 55, 2: 59, 1: 64}  # MIDI numbers of E2 A2 D3 G3 B3 E4
BEATS_A_BAR = 3
TICKS_A_BEAT = 480
BEATS_A_MINUTE = 88.0
SEED = 1890

# What the left hand holds during a bar, as string:fret. The melody moves on its string; under each of its notes the
# arpeggio plays the two inner strings, upper one first; the bass sounds once a bar.
SHAPES = {
    #          melody string, inner strings, bass
    "Em": (1, ("2:0", "3:0"), "6:0"),
    "Am V": (1, ("2:5", "3:5"), "5:0"),
    "B7 VII": (1, ("2:7", "3:8"), "6:7"),
    "B7 II": (1, ("2:0", "3:2"), "5:2"),
    "E": (1, ("2:0", "3:1"), "6:0"),
    "B7 low": (2, ("3:2", "4:4"), "5:2"),
    "B VII": (1, ("2:7", "3:8"), "6:7"),
    "E IX": (1, ("2:9", "3:9"), "6:0"),
    "A V": (1, ("2:5", "3:6"), "5:0"),
    "B7 II high": (1, ("2:4", "3:2"), "5:2"),
}

# One bar a line: the shape, and the frets of the melody on each beat.
MINOR = [
    ("Em", "7 7 7"),
    ("Em", "7 5 3"),
    ("Em", "3 2 0"),
    ("Em", "0 3 7"),
    ("Em", "12 12 12"),
    ("Em", "12 10 8"),
    ("Am V", "8 7 5"),
    ("Am V", "5 7 8"),
    ("B7 VII", "7 8 7"),
    ("B7 VII", "11 8 7"),
    ("Em", "7 5 3"),
    ("Em", "3 2 0"),
    ("B7 II", "2 2 2"),
    ("B7 II", "2 3 2"),
    ("Em", "0 0 0"),
]
MAJOR = [
    ("E", "4 4 4"),
    ("E", "4 2 0"),
    ("B7 low", "5 4 4"),
    ("B7 low", "4 2 4"),
    ("B VII", "9 9 9"),
    ("B VII", "9 11 9"),
    ("E IX", "9 7 7"),
    ("E IX", "7 9 11"),
    ("E IX", "12 12 12"),
    ("E IX", "12 11 10"),
    ("A V", "9 9 9"),
    ("A V", "9 7 5"),
    ("E", "4 4 4"),
    ("B7 II high", "4 5 2"),
    ("E", "0 0 0"),
]
# The chord of the last bar of each part, rolled from the bass up.
MINOR_CHORD = ("6:0", "5:2", "4:2", "3:0", "2:0", "1:0")
MAJOR_CHORD = ("6:0", "5:2", "4:2", "3:1", "2:0", "1:0")

# (bars, closing chord, MIDI key signature, how slow the last bars get, length of the closing bar in beats)
FORM = [
    (MINOR, MINOR_CHORD, "Em", (0.96, 0.88), 3),
    (MAJOR, MAJOR_CHORD, "E", (0.94, 0.84), 3),
    (MINOR, MINOR_CHORD, "Em", (0.90, 0.72), 6),
]


@dataclass
class Note:
    """One plucked note: which voice, where on the neck, when (in ticks) and how strongly; ``hand`` counts shapes."""

    voice: str
    string: int
    fret: int
    start: int
    end: int
    velocity: int
    hand: int

    @property
    def key(self):
        return OPEN_STRINGS[self.string] + self.fret


def place(text):
    """``"5:2"`` as (string, fret)."""
    string, fret = text.split(":")
    return int(string), int(fret)


def make_notes(rng):
    """All notes in order of their start, their ends still open."""
    notes, hand = [], 0

    def add(voice, where, beat, velocity, spread_ticks=5):
        late = round(rng.triangular(-spread_ticks, spread_ticks, 0))
        start = max(round((bar_start + beat) * TICKS_A_BEAT) + late, 0)
        velocity = round(velocity + rng.triangular(-3, 3, 0))
        notes.append(Note(voice, *where, start, 0, min(max(velocity, 1), 127), hand))

    bar_start = 0
    for number, (bars, chord, _, _, closing_beats) in enumerate(FORM):
        for k, (shape, frets) in enumerate(bars):
            melody_string, inner, bass = SHAPES[shape]
            hand += k == 0 or shape != bars[k - 1][0]
            swell = phrase_swell(k)
            add("bass", place(bass), 0, 74 + 8 * swell)
            for beat, fret in enumerate(map(int, frets.split())):
                height = (OPEN_STRINGS[melody_string] + fret - 71) / 12  # octaves above B4
                accent = 4 if beat == 0 else 0
                add("melody", (melody_string, fret), beat, 82 + 12 * swell + 6 * height + accent)
                add("accompaniment", place(inner[0]), beat + 1 / 3, 59 + 8 * swell)
                add("accompaniment", place(inner[1]), beat + 2 / 3, 62 + 8 * swell)
            bar_start += BEATS_A_BAR
        hand += 1
        last = number == len(FORM) - 1
        for k, where in enumerate(chord):
            voice = {0: "bass", 5: "melody"}.get(k, "accompaniment")
            add(voice, place(where), k * (0.09 if last else 0.05), (66 if last else 70) + (10 if k == 5 else 0), 2)
        bar_start += closing_beats
    return sorted(notes, key=lambda note: note.start), bar_start * TICKS_A_BEAT


def phrase_swell(bar):
    """-1..1: softer at the ends of the four-bar phrases, fuller in their middle and towards the middle of a part."""
    return 0.6 * math.sin(math.pi * (bar % 4 + 0.5) / 4) + 0.8 * math.sin(math.pi * (bar + 0.5) / 16) - 0.7


def close_notes(notes, end):
    """Let each note ring until its string is plucked again, the hand moves on, or the piece ends."""
    for k, note in enumerate(notes):
        needed = (other.start for other in notes[k + 1 :] if other.string == note.string or other.hand != note.hand)
        note.end = next(needed, end)


def tempo_track():
    """Names, signatures, and a tempo for every beat: a little breath in each phrase, slower at the end of each part."""
    track = mido.MidiTrack()
    track.append(mido.MetaMessage("track_name", name="Romance"))
    track.append(mido.MetaMessage("copyright", text="anonymous, public domain; transcription by the ukrt authors, MIT"))
    track.append(mido.MetaMessage("time_signature", numerator=BEATS_A_BAR, denominator=4))
    wait = 0
    for bars, _, signature, slowing, closing_beats in FORM:
        track.append(mido.MetaMessage("key_signature", key=signature, time=wait))
        wait = 0
        for bar in range(len(bars) + 1):
            for beat in range(BEATS_A_BAR if bar < len(bars) else closing_beats):
                speed = 1.0 + 0.02 * phrase_swell(bar + beat / BEATS_A_BAR)
                if bar >= len(bars) - 1:
                    first, last = slowing
                    speed *= first + (last - first) * min((bar - len(bars) + 1) * 0.5 + beat / 6, 1.0)
                tempo = round(60e6 / (BEATS_A_MINUTE * speed))
                track.append(mido.MetaMessage("set_tempo", tempo=tempo, time=wait))
                wait = TICKS_A_BEAT
    track.append(mido.MetaMessage("end_of_track", time=wait))
    return track


def voice_track(name, notes, end):
    """One voice as a track: note-offs before note-ons where they fall together."""
    track = mido.MidiTrack()
    track.append(mido.MetaMessage("track_name", name=name))
    track.append(mido.Message("program_change", program=24))  # General MIDI: nylon-string guitar
    events = []
    for note in notes:
        events.append((note.start, 1, mido.Message("note_on", note=note.key, velocity=note.velocity)))
        events.append((note.end, 0, mido.Message("note_off", note=note.key, velocity=64)))
    now = 0
    for tick, _, message in sorted(events, key=lambda event: event[:2]):
        track.append(message.copy(time=tick - now))
        now = tick
    track.append(mido.MetaMessage("end_of_track", time=end - now))
    return track


def make_piece():
    """The piece as (mido.MidiFile, list of Note)."""
    notes, end = make_notes(random.Random(SEED))
    close_notes(notes, end)
    piece = mido.MidiFile(type=1, ticks_per_beat=TICKS_A_BEAT)
    piece.tracks.append(tempo_track())
    for voice in ("melody", "accompaniment", "bass"):
        piece.tracks.append(voice_track(voice, [note for note in notes if note.voice == voice], end))
    return piece, notes


if __name__ == "__main__":
    default = pathlib.Path(__file__).resolve().parents[1] / "ukrt" / "data" / "romance.mid"
    target = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else default
    piece, notes = make_piece()
    piece.save(target)
    print(f"{target}: {len(notes)} notes, {piece.length:.1f} s")
