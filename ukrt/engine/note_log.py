"""The player's counters and log of notes, read out of an instance's flat arrays as plain Python values.

Enter ``d`` and ``i``; leave dicts for the report. Nothing here changes the arrays.
"""

from ukrt.engine import player_layout as at


def read_counters(i):
    """Everything the player counts.

    ``notes_on`` = ``notes_played`` + ``notes_dropped`` + ``notes_percussion``; stolen and repeated notes are among the
    played.

    Parameters
    ----------
    i : ndarray of int64

    Returns
    -------
    dict of str to int
    """
    return {name: int(i[at.I_COUNTERS + k]) for k, name in enumerate(at.COUNTER_NAMES)}


def count_logged(i):
    """How many notes have been logged since the start: note-ons, but those of keyswitches, and notes gone back to."""
    return int(i[at.I_NEXT_SEQ])


def read_note_log(d, i, sample_rate, since=0):
    """The notes the log still holds, in the order they came.

    Parameters
    ----------
    d, i : ndarray
        The instance's flat arrays.
    sample_rate : float [Hz]
    since : int
        Number of the first note wanted, as `count_logged` counts, from 0.

    Returns
    -------
    list of dict
        ``time_s`` of the note-on and ``end_s`` of its end (None: it rings) in the time of the events, ``release_frame``
        in engine frames (event plus lead, and plus what a strum let it wait), ``midi`` as it came, ``channel`` 0 to 15,
        ``string`` (0 the lowest) and ``fret`` (None where it got none), ``force_n``, ``articulation`` (see
        ``player_layout.WAY_NAMES``), ``finger`` ("p", "i", "m", "a"; None where the hand strums or does not pluck),
        ``fate``.
    """
    total = int(i[at.I_NEXT_SEQ])
    first = max(since, total - at.LOG_CAPACITY, 0)
    return [_note(d, i, sample_rate, seq % at.LOG_CAPACITY) for seq in range(first, total)]


def _note(d, i, sample_rate, row):
    frame, end, string = int(i[at.L_FRAME + row]), int(i[at.L_END + row]), int(i[at.L_STRING + row])
    return {
        "time_s": frame / sample_rate,
        "release_frame": frame + int(i[at.I_LEAD] + i[at.L_LATE + row]),
        "midi": int(i[at.L_KEY + row]),
        "channel": int(i[at.L_CHANNEL + row]),
        "string": string if string >= 0 else None,
        "fret": int(i[at.L_FRET + row]) if string >= 0 else None,
        "force_n": float(d[at.D_LOG_FORCE + row]),
        "articulation": at.WAY_NAMES[int(i[at.L_WAY + row])],
        "finger": at.FINGER_NAMES[int(i[at.L_FINGER + row])],
        "end_s": end / sample_rate if end >= 0 else None,
        "fate": at.FATE_NAMES[int(i[at.L_FATE + row])],
    }
