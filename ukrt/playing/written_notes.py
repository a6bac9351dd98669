"""The notes of a score: channel messages enter, notes with the times of key and pedal leave.

Keys and pedals mean what they mean to the compiled player: a key that is struck again plucks its string again, each
note-off ends the oldest note of its key, the pedals let ring what the key has let go.
"""

from dataclasses import dataclass

import numpy as np

from ukrt.playing.written_slurs import mark_slurs

PERCUSSION = 9
NOTE_OFF, NOTE_ON, CONTROL = 0x80, 0x90, 0xB0
PEDAL, SOSTENUTO, SOUND_OFF, RESET, NOTES_OFF = 64, 66, 120, 121, 123


@dataclass
class Written:
    """A note of a score.

    Attributes
    ----------
    message, off : int
        Numbers of its note-on and of the message that lets its key up; -1: none does.
    channel, key : int
    start_s, key_up_s, end_s : float [s]
        The string's use: where a slurred note's key comes up first, until the note it goes back to has ended.
    up_s : float [s]
        When its own key comes up.
    slurred_from : Written or None
        The note it is meant to go on from, on that one's string.
    hammers, slides : bool
        Whether it may by hammer-on or pull-off, and by a slide.
    """

    message: int
    channel: int
    key: int
    start_s: float
    off: int = -1
    key_up_s: float = np.inf
    end_s: float = np.inf
    up_s: float = np.inf
    slurred_from: object = None
    hammers: bool = False
    slides: bool = False


class _Keys:
    """Follows keys and pedals through a score and notes down when each note begins and ends."""

    def __init__(self):
        self.notes, self._down, self._ringing, self._pedal = [], {}, {}, {}
        self._caught = {}  # channel -> notes that the sostenuto pedal holds, where it is down

    def on(self, message, time_s, channel, key):
        for former in self._down.get((channel, key), []) + self._ringing.get(channel, []):
            if former.key == key:  # it is plucked again
                former.key_up_s, former.end_s = min(former.key_up_s, time_s), min(former.end_s, time_s)
        note = Written(message, channel, key, time_s)
        self.notes.append(note)
        self._down.setdefault((channel, key), []).append(note)

    def off(self, message, time_s, channel, key):
        waiting = self._down.get((channel, key))
        if waiting:
            self._up(waiting.pop(0), message, time_s)

    def _up(self, note, message, time_s):
        note.off, note.key_up_s = message, min(note.key_up_s, time_s)
        if self._is_held(note):
            self._ringing.setdefault(note.channel, []).append(note)
        else:
            note.end_s = min(note.end_s, time_s)

    def _is_held(self, note):
        return self._pedal.get(note.channel) or note in self._caught.get(note.channel, ())

    def pedal(self, time_s, channel, down):
        self._pedal[channel] = down
        self._let_go(time_s, channel)

    def sostenuto(self, time_s, channel, down):
        if not down:
            self._caught.pop(channel, None)
        elif channel not in self._caught:
            self._caught[channel] = [n for (one, _), waiting in self._down.items() if one == channel for n in waiting]
        self._let_go(time_s, channel)

    def _let_go(self, time_s, channel):
        """End what rings and no pedal holds any more."""
        for note in self._ringing.pop(channel, []):
            if self._is_held(note):
                self._ringing.setdefault(channel, []).append(note)
            else:
                note.end_s = min(note.end_s, time_s)

    def all_off(self, time_s, channel, ringing_too):
        for (one, _), waiting in self._down.items():
            while one == channel and waiting:
                self._up(waiting.pop(0), -1, time_s)
        if ringing_too:
            for note in self._ringing.pop(channel, []):
                note.end_s = min(note.end_s, time_s)


def written_notes(score, switches=()):
    """The notes of a score (list of `Written`), those of the percussion channel left out.

    Parameters
    ----------
    score : object with arrays ``time_s``, ``status``, ``data1``, ``data2``
    switches : dict of int to Switch
        Keys that are no notes: see `ukrt.playing.keyswitches.switches_of`.
    """
    keys = _Keys()
    columns = (score.time_s, score.status, score.data1, score.data2)
    for message, (time_s, status, data1, data2) in enumerate(zip(*(c.tolist() for c in columns), strict=True)):
        kind, channel = status & 0xF0, status & 0x0F
        if channel == PERCUSSION or (kind in (NOTE_ON, NOTE_OFF) and data1 in switches):
            continue
        if kind == NOTE_ON and data2:
            keys.on(message, time_s, channel, data1)
        elif kind in (NOTE_ON, NOTE_OFF):
            keys.off(message, time_s, channel, data1)
        elif kind == CONTROL and data1 in (PEDAL, SOSTENUTO, RESET):
            if data1 != SOSTENUTO:
                keys.pedal(time_s, channel, data1 == PEDAL and data2 >= 64)
            if data1 != PEDAL:
                keys.sostenuto(time_s, channel, data1 == SOSTENUTO and data2 >= 64)
        elif kind == CONTROL and (data1 == SOUND_OFF or data1 >= NOTES_OFF):
            keys.all_off(time_s, channel, data1 == SOUND_OFF)
    for note in keys.notes:
        note.key_up_s, note.end_s = min(note.key_up_s, score.duration_s), min(note.end_s, score.duration_s)
        note.up_s = note.key_up_s
    mark_slurs(keys.notes, score, switches)
    return keys.notes
