"""A MIDI file such as MIDI guitars send: notes with their bends enter, one channel for each string, a file leaves."""

from dataclasses import dataclass

import mido
import numpy as np

from ukrt.engine import controller_layout as cc

TICKS_A_SECOND = 1000  # 500 ticks of a quarter note, 120 a minute
SCAN_SECONDS = 0.008  # between two looks of the pickup at a string (typical of converters; an estimate)
OPEN_STRINGS = (64, 59, 55, 50, 45, 40)  # string 1 is the highest


@dataclass(frozen=True)
class BentNote:
    """A note on a string, and how it is bent.

    Attributes
    ----------
    name : str
    string : int
        1 the highest, as MIDI guitars count.
    fret : int
    start, length : float [s]
    range_semitones : int
        Of the channel's bends, by RPN 0.
    bend : callable (ndarray of seconds since the start) -> ndarray of cents, or None
    """

    name: str
    string: int
    fret: int
    start: float
    length: float
    range_semitones: int = 2
    bend: object = None

    @property
    def key(self):
        return OPEN_STRINGS[self.string - 1] + self.fret

    def bends(self):
        """What is sent: times [s] since the start of the file, and 14-bit values (two ndarrays)."""
        if self.bend is None:
            return np.zeros(0), np.zeros(0, int)
        times = np.arange(0.0, self.length, SCAN_SECONDS)
        cents = np.broadcast_to(self.bend(times), times.shape)
        values = np.clip(np.round(cents / (100.0 * self.range_semitones) * 8192), -8192, 8191).astype(int)
        new = np.concatenate([[True], np.diff(values) != 0])
        return self.start + np.round(times[new] * TICKS_A_SECOND) / TICKS_A_SECOND, values[new]

    def cents(self, times):
        """The bend as it was sent: the value last sent before each time [cents]."""
        sent, values = self.bends()
        held = np.concatenate([[0], values])[np.searchsorted(sent, times, side="right")]
        return held * self.range_semitones * 100.0 / 8192.0


def guitar_file(notes):
    """Notes of six strings, a track and a channel (0 to 5, string 1 first) each (mido.MidiFile)."""
    piece = mido.MidiFile(type=1, ticks_per_beat=TICKS_A_SECOND // 2)
    for string in range(1, 7):
        events = []
        for note in (note for note in notes if note.string == string):
            events += _messages(note)
        track, now = mido.MidiTrack(), 0
        for tick, _, message in sorted(events, key=lambda event: event[:2]):
            track.append(message.copy(channel=string - 1, time=tick - now))
            now = tick
        piece.tracks.append(track)
    return piece


def _messages(note):
    """Bend range, bends and note, each with its tick and its place among those of one tick."""
    start, end = (round(time * TICKS_A_SECOND) for time in (note.start, note.start + note.length))
    ranges = ((cc.RPN_MSB, 0), (cc.RPN_LSB, 0), (cc.DATA_MSB, note.range_semitones), (cc.DATA_LSB, 0))
    for control, value in ranges:
        yield start, 0, mido.Message("control_change", control=control, value=value)
    yield start, 1, mido.Message("pitchwheel", pitch=0)
    for time, value in zip(*note.bends(), strict=True):
        yield round(time * TICKS_A_SECOND), 2, mido.Message("pitchwheel", pitch=int(value))
    yield start, 3, mido.Message("note_on", note=note.key, velocity=90)
    yield end, 4, mido.Message("note_off", note=note.key, velocity=64)
