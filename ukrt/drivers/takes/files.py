"""Renders a take to audio files: a take and a file name enter, the samples that were heard and a report leave.

One file holds one sample rate: where the take changes it, the sound goes on in ``NAME-2.wav``. Float files hold every
bit; those of 16 or 24 bits are rounded (and 16 dithered), as in any rendering.
"""

import math
import pathlib

import numpy as np

from ukrt.drivers.files.audio import AudioWriter, check_audio_path
from ukrt.drivers.takes.reader import read_take
from ukrt.drivers.takes.replay import Replay
from ukrt.errors import AudioFileError, MidiFileError
from ukrt.units import gain_to_db


def render_take(
    path,
    target,
    *,
    bits="32f",
    overwrite=True,
    block_size=512,
    max_minutes=120.0,
    progress=None,
    engine_factory=None,
):
    """Render a take to a WAV or FLAC file, or to several where its sample rate changes.

    Parameters
    ----------
    path : str or path-like
        The take.
    target : str or path-like
        ``.wav`` or ``.flac``; appears when all is whole.
    bits : {"16", "24", "32f"}
    overwrite : bool
        Whether existing files may be replaced.
    block_size : int
        1 to 8192 frames computed at once.
    max_minutes : float [min]
        Longer takes are refused.
    progress : callable (done_s, total_s), optional
    engine_factory : callable, optional
        See `Replay`.

    Returns
    -------
    report : dict
        As `ukrt.render.render_file` gives it, without what a take has not (``midi_duration_s``, ``gain_db``); ``files``
        lists what was written, ``lost_entries`` counts what the recording had lost.
    """
    take = read_take(path)
    parts = take.parts()
    seconds = sum((end - first) / rate for first, end, rate in parts)
    if seconds > 60.0 * max_minutes:
        raise MidiFileError(
            f"{path}: lasts {seconds / 60.0:.1f} minutes, at most {max_minutes:g} are allowed (option --max-minutes)"
        )
    targets = _targets(target, len(parts))
    for one, (_, _, rate) in zip(targets, parts, strict=True):
        check_audio_path(one, bits, take.channels, round(rate))
        if one.exists() and not overwrite:
            raise AudioFileError(f"{one}: exists already, a new file name is needed")
    replay = Replay(take, block_size, progress, engine_factory)
    writers = []
    try:
        peak = 0.0
        for one, (first, end, rate) in zip(targets, parts, strict=True):
            writer = AudioWriter(one, round(rate), take.channels, bits, max_frames=end - first)
            writers.append(writer)
            for block in replay.blocks(first, end):
                peak = max(peak, float(np.max(np.abs(block), initial=0.0)))
                writer.write(block)
        for writer in writers:
            writer.close()
        return _report(take, replay, seconds, peak) | {
            "clipped_samples": sum(writer.clipped_samples for writer in writers),
            "file": str(target),
            "files": [str(one) for one in targets],
            "bits": str(bits),
        }
    except BaseException:
        for writer in writers:
            writer.discard()
        raise
    finally:
        replay.engine.close()


def _targets(target, count):
    """The files of a take's parts."""
    target = pathlib.Path(target)
    return [target] + [target.with_stem(f"{target.stem}-{number}") for number in range(2, count + 1)]


def _report(take, replay, seconds, peak):
    """What was played and how, ready for JSON."""
    counters = {name: value for name, value in replay.engine.counters().items() if np.ndim(value) == 0}
    speed = replay.timed_seconds / replay.compute_seconds if replay.compute_seconds > 0.0 else None
    return {
        "notes_total": counters["notes_on"],
        "notes_dropped": counters["notes_dropped"],
        "notes_stolen": counters["notes_stolen"],
        "notes_folded": counters["notes_folded"],
        "notes_percussion": counters["notes_percussion"],
        "duration_s": seconds,
        "peak_dbfs": gain_to_db(peak) if peak > 0.0 and math.isfinite(peak) else None,
        "times_real_time": speed,
        "preset": take.sounds[0].guitar.name,
        "sample_rate": take.sample_rate,
        "signal": take.signal,
        "channels": take.channels,
        "frames": take.frames,
        "lost_entries": take.lost,
        "recorded_with": take.version,
        "warnings": replay.warnings,
        "counters": counters,
        "notes": replay.notes,
    }
