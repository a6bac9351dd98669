"""What came of a rendering: the performance and what was written of it enter, a dict for JSON leaves."""

import numpy as np

from ukrt.drivers.files.part import count_all, count_notes
from ukrt.model.fingerboard import fingerboard
from ukrt.model.string_limits import describe_tuning, tuning_warnings, wolf_warnings
from ukrt.units import gain_to_db


def make_report(score, performance, meter, guitar, signal, gain_db, part):
    """What was played and how.

    Parameters
    ----------
    score : Score
    performance : Performance
        Played.
    meter : object
        ``peak``, ``frames`` and ``beyond_full_scale`` of what was written.
    guitar : Guitar
    signal : str
    gain_db : float [dB]
        All in all.
    part : Part

    Returns
    -------
    report : dict
        Ready for JSON. ``notes_total``, ``notes_dropped``, ``notes_stolen``, ``notes_folded`` (not of a part),
        ``notes_percussion``, ``duration_s`` (of the sound), ``midi_duration_s`` (of the whole file), ``start_s`` (of
        the sound in the whole), ``peak_dbfs`` (None for silence), ``clipped_samples`` (beyond full scale),
        ``times_real_time`` (of the engine; its first block, which may wait for the compiler, is left out; None where
        there is no other), ``preset``, ``sample_rate``, ``signal``, ``channels``, ``frames``, ``gain_db``, ``title``,
        ``warnings`` (oddities of the MIDI file), ``tuning``, ``tuning_warnings`` (strings that would break or rattle,
        notes that cannot be put in tune), ``counters`` (the engine's, from the beginning of the whole), and ``notes``,
        those that begin in the part: a list of ``time_s`` (in the whole), ``release_frame`` (in output samples),
        ``midi``, ``channel``, ``string``, ``fret`` (from the capo), ``hz`` (its pitch without bend; None for a note
        that got no string), ``force_n``, ``articulation``, ``end_s`` (in the whole; None: not yet), ``fate``.
    """
    engine, lead = performance.engine, performance.engine.lead_frames
    counters = {name: _plain(value) for name, value in engine.counters().items() if np.ndim(value) == 0}
    pitches = fingerboard(guitar).hz
    notes = part.notes(_note(row, lead, pitches) for row in performance.notes())
    seconds = performance.compute_seconds
    speed = performance.timed_frames / engine.sample_rate / seconds if seconds > 0.0 else None
    return {
        **(count_all(score.n_notes, counters) if part.is_whole else count_notes(notes)),
        "duration_s": meter.frames / engine.sample_rate,
        "midi_duration_s": score.duration_s,
        "start_s": part.start / _plain(engine.sample_rate),
        "peak_dbfs": gain_to_db(meter.peak) if meter.peak > 0.0 else None,
        "clipped_samples": meter.beyond_full_scale,
        "times_real_time": speed,
        "preset": guitar.name,
        "sample_rate": _plain(engine.sample_rate),
        "signal": signal,
        "channels": engine.channels,
        "frames": meter.frames,
        "gain_db": gain_db,
        "title": score.title,
        "warnings": list(score.warnings),
        "tuning": describe_tuning(guitar),
        "tuning_warnings": tuning_warnings(guitar) + wolf_warnings(guitar),
        "counters": counters,
        "notes": notes,
    }


def _note(row, lead, pitches):
    """A note of the log with its pitch, its release counted from MIDI time 0."""
    hz = None if row["string"] is None else pitches[row["string"], row["fret"]]
    row = row | {"release_frame": row["release_frame"] - lead, "hz": hz}
    return {name: _plain(value) for name, value in row.items()}


def _plain(value):
    """NumPy scalars as Python's own numbers."""
    return value.item() if isinstance(value, np.generic) else value
