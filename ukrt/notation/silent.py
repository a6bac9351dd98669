"""The guitarist without a guitar: a score enters, string and fret of every note leave, and no sound is computed.

The same compiled player gets the same messages at the same frames as in a rendering; the gestures that it asks for are
dropped when they are due. So the notes get the strings and frets that they have in the sound.
"""

from types import SimpleNamespace

import numpy as np

from ukrt.engine import layout
from ukrt.engine.kernels.player import player_message, player_reset, player_tick
from ukrt.engine.kernels.timeline import timeline_drop_first, timeline_next
from ukrt.engine.note_log import count_logged, read_counters, read_note_log
from ukrt.engine.player_layout import I_LEAD, I_OPEN, LOG_CAPACITY
from ukrt.engine.player_tables import make_player_tables
from ukrt.model.fingerboard import fingerboard

_FAR = 1 << 60


def play_silently(guitar, score, sample_rate=48000.0):
    """Let the player play a score.

    Parameters
    ----------
    guitar : Guitar
    score : Score
    sample_rate : float [Hz]
        Its frames are what the messages are rounded to.

    Returns
    -------
    notes : list of dict
        One for each note-on, and for each note gone back to, as `ukrt.engine.note_log.read_note_log` gives them.
    open_keys : list of int
        MIDI note of each string without a finger (from the capo on), that on the bass side first.
    counters : dict of str to int
    """
    d, i = np.zeros(layout.D_SIZE), np.zeros(layout.I_SIZE, dtype=np.int64)
    player_reset(d, i)
    make_player_tables(guitar, SimpleNamespace(places=fingerboard(guitar).ideal), sample_rate, d, i)
    player_tick(d, i, 0)
    frames = np.rint(score.time_s * sample_rate).astype(np.int64)
    notes, seen = [], 0
    columns = (frames, score.status, score.data1, score.data2)
    for frame, status, data1, data2 in zip(*(column.tolist() for column in columns), strict=True):
        while timeline_next(i, _FAR) < frame:
            timeline_drop_first(d, i)
        player_message(d, i, frame, status, data1, data2)
        if count_logged(i) - seen == LOG_CAPACITY // 2:  # before its ring comes round; rows known already are renewed
            rows, seen = read_note_log(d, i, sample_rate), count_logged(i)
            notes[seen - len(rows) :] = rows
    rows = read_note_log(d, i, sample_rate)
    notes[count_logged(i) - len(rows) :] = rows
    return _without_lead(notes, int(i[I_LEAD])), i[I_OPEN : I_OPEN + len(guitar.strings)].tolist(), read_counters(i)


def _without_lead(notes, lead):
    """Release frames as in a rendering, whose frame 0 is MIDI time 0."""
    return [note | {"release_frame": note["release_frame"] - lead} for note in notes]
