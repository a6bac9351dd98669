#!/usr/bin/env python3
"""Writes the bundled demonstration of articulations, ukrt/data/demonstration.mid, from the table below.

Each section has a marker with its name. In it a note (or a few) is heard plainly, then played as the section says:

    ukrt render demonstration -o demonstration.wav
    ukrt render demonstration --from marker:hammer-on --to marker:pull-off -o hammer-on.wav

    tools/make_demonstration.py [FILE]
"""

import pathlib
import sys
from dataclasses import dataclass

import mido

TICKS_A_SECOND = 960  # 480 of a quarter note, 120 a minute
HALF_SECONDS, END_SECONDS = 3.0, 2.4  # of each half; notes are let go after so long, so that the next begins in silence
VELOCITY = 90
STRING, RESET = 20, 121  # controllers: the string of the notes to come; almost everything back to where it was
STAY = {5: 64, 7: 100, 16: 64, 18: 0, 22: 64, 74: 64}  # what RESET leaves as it is, and where the plain note has it


@dataclass(frozen=True)
class Section:
    """One articulation.

    Attributes
    ----------
    name : str
        The marker's.
    plain, played : tuple of (float [s], str, int, ...)
        What is sent, and when: (0.0, "on", key), (0.5, "off", key), (0.0, "cc", number, value), (0.2, "bend", cents),
        (0.1, "pressure", value).
    way : str
        How the last note of ``played`` is begun, in the player's words.
    """

    name: str
    plain: tuple
    played: tuple
    way: str = "pluck"


def on(key, string, start=0.0, length=END_SECONDS, velocity=VELOCITY):
    """A note on a string (1 the highest) from ``start`` to ``length`` [s]."""
    return (start, "cc", STRING, string), (start, "on", key, velocity), (length, "off", key)


def cc(*pairs, start=0.0):
    """Controllers, from numbers and values in turn."""
    return tuple((start, "cc", number, value) for number, value in zip(pairs[::2], pairs[1::2], strict=True))


def ramp(kind, start, end, values, *more):
    """Messages at equal times from ``start`` to ``end`` [s], one for each value."""
    step = (end - start) / (len(values) - 1)
    return tuple((start + k * step, kind, *more, value) for k, value in enumerate(values))


C4 = on(60, 3)  # third string, fifth fret: no open string has its fundamental
E2 = on(40, 6)  # open
LEGATO, GLIDE = cc(68, 127), cc(65, 127)


def run(*keys, string=4, each=0.5):
    """Notes one after another on a string, each held until the last has begun: what is slurred, with legato on."""
    return sum((on(key, string, k * each) for k, key in enumerate(keys)), ())


def quick(*keys, string=4, each=0.1):
    """A trill's notes: each ends as the next but one begins, so that keys can come again."""
    ends = [min((k + 1) * each + 0.02, END_SECONDS) for k in range(len(keys) - 1)] + [END_SECONDS]
    return sum((on(key, string, k * each, end) for k, (key, end) in enumerate(zip(keys, ends, strict=True))), ())


ARPEGGIO = (on(48, 5, 0.0, 0.3), on(55, 3, 0.3, 0.6), on(60, 2, 0.6, 0.9), on(64, 1, 0.9, 1.2))
CHORD = sum(ARPEGGIO, ())
TOGETHER = sum((on(key, string) for string, key in ((6, 40), (5, 47), (4, 52), (3, 56), (2, 59), (1, 64))), ())
AGAIN = sum((on(60, 3, 0.25 * k, 0.25 * k + 0.24) for k in range(8)), ())
TRILL = quick(*(57, 59) * 8)
UP_AND_BACK = [200 * k / 20 for k in (*range(21), *[20] * 20, *range(20, -1, -1))]

# A line for each: what is heard plainly, and what is played instead.
SECTIONS = (
    Section("strength", on(60, 3, velocity=50), on(60, 3, velocity=120)),
    Section("tasto", C4, cc(74, 0) + C4),
    Section("ponticello", C4, cc(74, 127) + C4),
    Section("free stroke", C4, cc(16, 32) + C4),
    Section("rest stroke", C4, cc(16, 127) + C4),
    Section("fingertip", C4, cc(18, 127) + C4),
    Section("attack", C4, cc(22, 0) + C4),
    Section("planting", on(60, 3) + on(60, 3, 0.8), cc(26, 127) + on(60, 3) + on(60, 3, 0.8)),
    Section("strum", TOGETHER, cc(23, 80) + TOGETHER),
    Section("strum from the treble", TOGETHER, cc(23, 80, 24, 96) + TOGETHER),
    Section("variation", AGAIN, cc(25, 127) + AGAIN),
    Section("hammer-on", run(57, 59), LEGATO + run(57, 59), "hammer-on"),
    Section("pull-off", run(59, 57), LEGATO + run(59, 57), "pull-off"),
    Section("slide", run(52, 57), GLIDE + cc(5, 64) + run(52, 57), "slide"),
    Section("glissando", run(52, 57), GLIDE + cc(5, 90, 28, 127) + run(52, 57), "slide"),
    Section("trill", TRILL, LEGATO + TRILL, "hammer-on"),
    Section("bend", on(64, 2), on(64, 2) + ramp("bend", 0.4, 1.6, UP_AND_BACK)),
    Section("vibrato", on(64, 2), on(64, 2) + ramp("cc", 0.3, 0.8, range(0, 128, 8), 1)),
    Section("natural harmonic", on(52, 6), cc(17, 127) + on(52, 6), "harmonic"),
    Section("artificial harmonic", on(70, 3), cc(17, 127) + on(70, 3), "harmonic"),
    Section("palm mute", E2, cc(19, 100) + E2, "muted"),
    Section("muted while it sounds", E2, E2 + cc(19, 100, start=0.6)),
    Section("half lift", C4, C4 + cc(27, 100, start=0.6)),
    Section("let ring", CHORD, cc(64, 127) + CHORD + cc(64, 0, start=END_SECONDS)),
    Section("sostenuto", CHORD, CHORD + cc(66, 127, start=0.2) + cc(66, 0, start=END_SECONDS)),
    Section("soft pedal", C4, cc(67, 127) + C4),
    Section("volume", C4, cc(7, 64) + C4),
    Section("expression", E2, E2 + ramp("cc", 0.3, 2.0, range(127, 30, -4), 11)),
)


def starts(k):
    """When section ``k`` begins, when its articulation does, and when it ends [s]."""
    return tuple((2 * k + half) * HALF_SECONDS for half in range(3))


def events(messages, start):
    """Messages of a half as (time [s], mido.Message), with what takes them back at its end."""
    used = {rest[0] for _, kind, *rest in messages if kind == "cc"}
    after = [(END_SECONDS + 0.1, "cc", number, value) for number, value in STAY.items() if number in used]
    for time, kind, *values in sorted([*messages, *after, (END_SECONDS + 0.1, "cc", RESET, 0)], key=lambda m: m[0]):
        if kind == "on":
            message = mido.Message("note_on", note=values[0], velocity=values[1])
        elif kind == "off":
            message = mido.Message("note_off", note=values[0], velocity=64)
        elif kind == "cc":
            message = mido.Message("control_change", control=values[0], value=values[1])
        elif kind == "pressure":
            message = mido.Message("aftertouch", value=values[0])
        else:
            message = mido.Message("pitchwheel", pitch=min(round(values[0] / 200 * 8192), 8191))
        yield start + time, message


def track(timed):
    """Messages with their times [s] as a track."""
    found, now = mido.MidiTrack(), 0
    for time, message in timed:
        tick = round(time * TICKS_A_SECOND)
        found.append(message.copy(time=tick - now))
        now = tick
    found.append(mido.MetaMessage("end_of_track", time=round(starts(len(SECTIONS))[0] * TICKS_A_SECOND) - now))
    return found


def make_demonstration():
    """The demonstration (mido.MidiFile)."""
    piece = mido.MidiFile(type=1, ticks_per_beat=TICKS_A_SECOND // 2)
    heads = [(0.0, mido.MetaMessage("track_name", name="Articulations"))]
    heads += [(0.0, mido.MetaMessage("copyright", text="the ukrt authors, MIT"))]
    notes = [(0.0, mido.MetaMessage("track_name", name="guitar")), (0.0, mido.Message("program_change", program=24))]
    for k, section in enumerate(SECTIONS):
        plain, played, _ = starts(k)
        heads.append((plain, mido.MetaMessage("marker", text=section.name)))
        notes += [*events(section.plain, plain), *events(section.played, played)]
    piece.tracks += [track(heads), track(notes)]
    return piece


if __name__ == "__main__":
    default = pathlib.Path(__file__).resolve().parents[1] / "ukrt" / "data" / "demonstration.mid"
    target = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else default
    piece = make_demonstration()
    piece.save(target)
    print(f"{target}: {len(SECTIONS)} sections, {piece.length:.1f} s")
