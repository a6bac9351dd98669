"""The messages that say how notes are played: their numbers, which compiled code uses, and what they mean, in words.

``CONTROLLERS`` is the table of ``ukrt/playing/README.md``; a test holds the two together.
"""

BANK_MSB, BANK_LSB = 0, 32
WHEEL, GLIDE_TIME, DATA_MSB, DATA_LSB = 1, 5, 6, 38
VOLUME, EXPRESSION = 7, 11
ANGLE, HARMONIC, FLESH, MUTE = 16, 17, 18, 19  # general purpose controllers
STRING, POSITION = 20, 21  # undefined in MIDI 1.0, so free for an instrument
ATTACK, STRUM, DIRECTION, VARIATION, PLANTING = 22, 23, 24, 25, 26
LOOSE, FRETS = 27, 28  # undefined, too
PEDAL, GLIDE, LEGATO, PLACE = 64, 65, 68, 74
SOSTENUTO, SOFT = 66, 67
INCREMENT, DECREMENT, NRPN_LSB, NRPN_MSB, RPN_LSB, RPN_MSB = 96, 97, 98, 99, 100, 101
SOUND_OFF, RESET, NOTES_OFF, MONO, POLY = 120, 121, 123, 126, 127
ZONE_RPN = 6  # MPE Configuration Message
DOWN = 64  # a switch or a pedal is on from here
MIDDLE = 64  # of a controller that goes both ways
ALTERNATE = 127  # of DIRECTION: each stroke the other way

# What is sent, what it means
CONTROLLERS = (
    (
        "pitch bend",
        "tension of the channel's sounding strings; a new note starts with it; at most an octave either way "
        "(`bends_limited`)",
    ),
    (
        f"RPN 0 (CC {RPN_MSB}, {RPN_LSB} = 0, 0) with CC {DATA_MSB}, {DATA_LSB}, {INCREMENT}, {DECREMENT}",
        "bend range in semitones, cents, one cent up, one cent down; at most 96 semitones; "
        "`playing.bend_range_semitones` before that, in zones 48 for members and 2 for masters. On a member: for all "
        "members of its zone",
    ),
    (
        f"RPN {ZONE_RPN} on channels 1 and 16 with CC {DATA_MSB}",
        "a lower or upper zone of MPE with 1 to 15 members, 0: off; on other channels, with more members or in mode "
        "`guitar` it is counted (`rpn_ignored`)",
    ),
    (
        "RPN 1, fine tuning",
        "14 bits, 100 cents either way, by tension; strings that sound follow",
    ),
    (
        "RPN 2, coarse tuning",
        "semitones (64: none) by which the keys of notes to come are moved, so that other frets are used",
    ),
    (
        "RPN 5, modulation depth range",
        "semitones and 1/128 semitones of vibrato at full wheel or pressure, at most 12 semitones; "
        "`articulation.vibrato_depth` before that",
    ),
    ("other RPNs, NRPNs", "nothing; their data entries are counted (`rpn_ignored`, `nrpn_ignored`)"),
    (
        f"CC {VOLUME} volume, CC {EXPRESSION} expression",
        "volume of the whole guitar, the last value of any channel counts: 40 log10(value / 100) dB and "
        "40 log10(value / 127) dB",
    ),
    (
        f"CC {WHEEL}, channel pressure, key pressure",
        "vibrato of the channel's strings, or of the key's; the largest of the three counts, 127 is "
        "`articulation.vibrato_depth`",
    ),
    (
        f"CC {LEGATO} legato ({DOWN} and above is on)",
        "a note that begins while another of the channel is held is slurred, where the hand reaches it on that string; "
        "when its key comes up first, the string goes back to that other note. Before that on for channels with one "
        "voice alone",
    ),
    (
        f"CC {GLIDE} portamento ({DOWN} and above is on)",
        "such a note is slid to, from a stopped note to a stopped note",
    ),
    (f"CC {GLIDE_TIME}", "time of a slide, 0.03 to 2 s; `articulation.slide_time` before that"),
    (
        f"CC {PLACE} brightness",
        f"where notes to come are plucked: {MIDDLE} as the preset has it, less towards the neck, more towards the "
        "bridge",
    ),
    (
        f"CC {ANGLE}",
        f"direction of plucks to come: {MIDDLE} as the preset has it, 0 parallel to the soundboard, 127 towards it "
        "(rest stroke)",
    ),
    (
        f"CC {FLESH}",
        "how plucks to come let go: 0 at once, as a nail or a plectrum, 127 within `articulation.flesh_time`, as a "
        "soft fingertip; `articulation.flesh` before that",
    ),
    (
        f"CC {ATTACK}",
        f"time for which plucks to come pull: {MIDDLE} as the preset has it (`pluck.attack`), 0 for 0.5 ms, 127 for "
        "all of `pluck.duration`; the release stays where it is",
    ),
    (
        f"CC {PLANTING}",
        "planting: how firmly the finger rests on the string from the note-on until it plucks it, 0 not at all; "
        "`articulation.planting` before that",
    ),
    (
        f"CC {STRUM}",
        "strumming: time in which the hand sweeps over all strings, 0: at once, 1 to 127: 5 ms to 0.4 s; "
        "`articulation.strum_time` before that",
    ),
    (
        f"CC {DIRECTION}",
        f"strums begin on the bass side (0 to 63), on the treble side (64 to 126), in turns ({ALTERNATE}); "
        "`articulation.strum_direction` before that",
    ),
    (
        f"CC {VARIATION}",
        "how much plucks differ from finger to finger and from note to note, 0: not at all; `articulation.variation` "
        "before that",
    ),
    (
        f"CC {HARMONIC} ({DOWN} and above is on)",
        "notes to come are harmonics: they sound at their pitch, from a string that is touched at a node",
    ),
    (
        f"CC {MUTE}",
        "the hand's edge on the string near the bridge, of notes that sound and of those to come: 0 not at all, 127 "
        "the most; `articulation.muting` before that",
    ),
    (
        f"CC {LOOSE} half lift",
        "fingers of the left hand loosen, of notes that sound and of those to come: 0 they press, 1 to 127 they damp "
        "what they stopped, up to as much as a finger can; open strings ring on",
    ),
    (
        f"CC {FRETS} frets ({DOWN} and above is on)",
        "slides go over the frets, each stopping the string in its turn, instead of gliding freely",
    ),
    (
        f"CC {STRING}",
        "the string for the channel's notes to come: 1 the highest to 12, 0: free; more is ignored and counted",
    ),
    (
        f"CC {POSITION}",
        "the fret under the index finger for the channel's notes to come, 0: free; beyond the last fret it is ignored "
        "and counted. Open strings stay within reach",
    ),
    (f"CC {PEDAL} ({DOWN} and above is down)", "notes ring on after their keys come up"),
    (
        f"CC {SOSTENUTO} sostenuto ({DOWN} and above is down)",
        "so do those, and only those, whose keys were down when it went down",
    ),
    (
        f"CC {SOFT} soft ({DOWN} and above is down)",
        f"plucks to come are 3 dB softer, and let go as if CC {FLESH} were 48 more",
    ),
    (
        f"CC {SOUND_OFF} all sound off",
        "the channel's strings, and strings that sound without a note of their own, are damped at once; fate "
        "`silenced`",
    ),
    (
        f"CC {RESET} reset controllers",
        "pedals up, bend to the middle, full expression, no RPN chosen, string and position free, no vibrato, slurs, "
        "slides, harmonics, half-lifted fingers, frets in slides; muting, planting, strums and variation as the preset "
        "has them; "
        f"what RPNs have set, CC {GLIDE_TIME}, {VOLUME}, {ANGLE}, {FLESH}, {ATTACK} and {PLACE} stay",
    ),
    (
        f"program change, CC {BANK_MSB} and {BANK_LSB} bank",
        "another guitar: bank 0 those of `--preset`, bank 1 those of `ukrt presets --banks`; what there is not changes "
        "nothing",
    ),
    (f"CC {NOTES_OFF} all notes off, 124, 125", "every key of the channel comes up; the pedals still hold"),
    (
        f"CC {MONO} mono, {POLY} poly",
        "the same; and as many channels from this one on as the value says (0: as there are strings) have one voice "
        "each, or have many again. In a zone: its members",
    ),
    ("any of these on the master of a zone", f"for all its members, but for RPNs; bends and CC {PLACE} add up"),
    ("system reset (FF), SysEx GM on, off, GM2 on", "all channels: as CC 120, then as at power-up, tunings too"),
    ("SysEx master volume", "40 log10(value / 16383) dB on top of the others"),
    (
        "SysEx master fine tuning, master coarse tuning",
        "as RPN 1 and 2, for all channels, and for idle strings",
    ),
    (
        "SysEx of the MIDI Tuning Standard",
        "see Tunings by MIDI; other SysEx, and what is not there, is counted (`sysex_ignored`, `sysex_refused`)",
    ),
)


def controller_table():
    """The table as Markdown lines, without a line end after the last."""
    rows = [("message", "meaning"), ("---", "---"), *CONTROLLERS]
    return "\n".join(f"| {message} | {meaning} |" for message, meaning in rows).replace("| --- | --- |", "|---|---|")
