"""A score's notes given string and position beforehand: messages enter, the same with controllers 20 and 21 leave.

Before each note stands what it is to be played on; after the last note of a moment its channels are free again, so
that whoever plays along on the same channel is not bound. So the compiled player remains the only one that plays, and
what it got can be recorded and repeated like anything else.

A file that says itself where its notes lie is left alone: one that has these controllers, or a channel for each string,
as MIDI guitars send. So is one for channels that are strings, or notes of MPE with pedals and bends of their zone; and
one that moves keys by messages.
"""

from dataclasses import dataclass, replace

import numpy as np

from ukrt.model.fingerboard import key_cents, repeat_keys
from ukrt.playing.fingering import Note, find_fingering
from ukrt.playing.grips import neck_of
from ukrt.playing.keyswitches import switches_of
from ukrt.playing.rules import fold_table
from ukrt.playing.written_notes import CONTROL, NOTE_OFF, PERCUSSION, written_notes

CHOICES = ("look-ahead", "causal")
STRING, POSITION = 20, 21
DATA_MSB, INCREMENT, DECREMENT, RPN_LSB, RPN_MSB, COARSE_TUNING, ZONE_RPN = 6, 96, 97, 100, 101, 2, 6
SYSEX_BEGIN, SYSEX_MORE = 0xF0, 0xF4
MOVING_SYSEX = ((4, 4), (8, 2), (8, 7))  # sub-ids: master coarse tuning, tunings of single notes
MOST_NOTES = 30_000  # more are not searched: dense chords under the pedal take some milliseconds a note


@dataclass(frozen=True)
class Summary:
    """What came of it.

    Attributes
    ----------
    choice : {"look-ahead", "causal"}
    why : str
        Why the score was left alone, "" if it was not.
    cut_short, let_go : int
        Notes that lose their string to another before their end, or their finger for the hand's sake.
    given_up : int
        Moments at which not every way to play was followed.
    """

    choice: str
    why: str = ""
    cut_short: int = 0
    let_go: int = 0
    given_up: int = 0


def choose_fingering(score, guitar, choice):
    """What `write_fingering` gives where ``choice`` is "look-ahead", else the score as it is."""
    return write_fingering(score, guitar) if choice == "look-ahead" else (score, Summary("causal"))


def write_fingering(score, guitar):
    """Choose string and position for the notes of a score with all of it in view.

    Parameters
    ----------
    score : Score
        Or any dataclass with arrays ``time_s``, ``status``, ``data1``, ``data2`` and ``duration_s``.
    guitar : Guitar

    Returns
    -------
    score : Score
    summary : Summary
    """
    notes, neck = written_notes(score, switches_of(guitar)), neck_of(guitar)
    if why := _says_itself(score, notes, neck, guitar.playing.midi_mode):
        return score, Summary("causal", why)
    fold = fold_table(neck.open, neck.frets, repeat_keys(guitar.tuning), key_cents(guitar.tuning)[1])
    notes = [note for note in notes if fold[note.key] >= 0]
    found = find_fingering(_searched(notes, fold), neck)
    let_go = sum(place.let_go for place in found.places)
    cut = sum(place.cut_s is not None for place in found.places) - let_go
    written = _write(score, notes, found.places, len(neck.open))
    return written, Summary("look-ahead", "", cut, let_go, found.given_up)


def _searched(notes, fold):
    """The notes as the search sees them."""
    number_of = {id(note): number for number, note in enumerate(notes)}
    return [
        Note(
            note.start_s,
            note.key_up_s,
            note.end_s,
            int(fold[note.key]),
            number_of.get(id(note.slurred_from), -1),
            note.hammers,
            note.slides,
        )
        for note in notes
    ]


def _says_itself(score, notes, neck, mode):
    """Why the strings of this score are not to be chosen, "" if they are."""
    if mode != "keyboard":
        return f"channels are strings or single notes (playing.midi_mode is {mode})"
    if _sets_zones(score):
        return "the file has zones of MPE (RPN 6)"
    controls = (score.status & 0xF0 == CONTROL) & (score.status & 0x0F != PERCUSSION)
    if np.any(controls & ((score.data1 == STRING) | (score.data1 == POSITION))):
        return "the file names strings or positions itself (CC 20, 21)"
    if len(notes) > MOST_NOTES:
        return f"the file has more than {MOST_NOTES} notes"
    if _has_channel_per_string(notes, neck):
        return "the file has a channel for each string"
    if _moves_keys(score):
        return "the file moves keys to other pitches (RPN 2, or SysEx: coarse tuning, tunings of notes)"
    return ""


def _moves_keys(score):
    """Whether messages may change which fret a key is played at, which the search does not follow."""
    chosen, begun = {}, False  # channel -> [msb, lsb] of the RPN
    columns = (score.status, score.data1, score.data2)
    for status, data1, data2 in zip(*(column.tolist() for column in columns), strict=True):
        if begun and status == SYSEX_MORE and (data1, data2) in MOVING_SYSEX:
            return True
        begun = status == SYSEX_BEGIN or (begun and status < SYSEX_BEGIN)  # messages of tracks beside may come between
        if status & 0xF0 == CONTROL and data1 in (RPN_LSB, RPN_MSB):
            chosen.setdefault(status, [127, 127])[data1 == RPN_LSB] = data2
        elif status & 0xF0 == CONTROL and chosen.get(status) == [0, COARSE_TUNING]:
            if data1 in (INCREMENT, DECREMENT) or (data1 == DATA_MSB and data2 != 64):
                return True
    return False


def _sets_zones(score):
    """Whether there is an MPE Configuration Message: a data entry on channel 1 or 16 with RPN 6 chosen."""
    chosen = {CONTROL: [0, 0], CONTROL | 15: [0, 0]}
    for status, data1, data2 in zip(score.status.tolist(), score.data1.tolist(), score.data2.tolist(), strict=True):
        if status not in chosen:
            continue
        if data1 in (RPN_LSB, RPN_MSB):
            chosen[status][data1 - RPN_LSB] = data2
        elif data1 == DATA_MSB and chosen[status] == [ZONE_RPN, 0]:
            return True
    return False


def _has_channel_per_string(notes, neck):
    """Whether as many channels as strings, side by side, hold one voice each that lies on its string."""
    channels = sorted({note.channel for note in notes})
    count = len(neck.open)
    if count < 2 or len(channels) != count or channels[-1] - channels[0] != count - 1:
        return False
    last_s = {}
    for note in sorted(notes, key=lambda note: note.start_s):
        lowest = neck.open[count - 1 - (note.channel - channels[0])]
        if not lowest <= note.key <= lowest + neck.frets or note.start_s < last_s.get(note.channel, 0.0):
            return False
        last_s[note.channel] = note.key_up_s
    return True


def _write(score, notes, places, strings):
    """The score with what ``places`` say written into it."""
    before, after, gone = {}, {}, set()
    first_of, last_of = {}, {}  # time -> first note-on; (time, channel) -> last note-on
    for note, place in zip(notes, places, strict=True):
        number = strings - place.string if place.string >= 0 else 0
        status = CONTROL | note.channel
        before.setdefault(note.message, []).extend([(status, STRING, number), (status, POSITION, place.hand)])
        first_of.setdefault(note.start_s, note.message)
        last_of[note.start_s, note.channel] = note.message
    for (_, channel), message in last_of.items():
        after[message] = [(CONTROL | channel, STRING, 0), (CONTROL | channel, POSITION, 0)]
    for note, place in zip(notes, places, strict=True):
        while place.let_go and note.up_s <= place.cut_s and note.slurred_from:
            note = note.slurred_from  # what sounds by then
        if place.let_go:
            gone.add(note.off)
            before[first_of[place.cut_s]].insert(0, (NOTE_OFF | note.channel, note.key, 0))
    rows = []
    columns = (score.time_s, score.status, score.data1, score.data2)
    for message, (time_s, *own) in enumerate(zip(*(column.tolist() for column in columns), strict=True)):
        rows += [(time_s, *row) for row in before.get(message, ())]
        if message not in gone:
            rows.append((time_s, *own))
        rows += [(time_s, *row) for row in after.get(message, ())]
    if not rows:
        return score
    time_s, *data = zip(*rows, strict=True)
    status, data1, data2 = (np.array(column, dtype=np.uint8) for column in data)
    return replace(score, time_s=np.array(time_s), status=status, data1=data1, data2=data2)
