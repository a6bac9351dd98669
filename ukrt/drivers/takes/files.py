"""Renders a take to audio files: a take and a file name enter, the samples that were heard and a report leave.

One file holds one sample rate: where the take changes it, the sound goes on in ``NAME-2.wav``. Float files hold every
bit; those of 16 or 24 bits are rounded (and 16 dithered), as in any rendering.
"""

import collections
import math
import pathlib
from dataclasses import dataclass

import numpy as np

from ukrt.drivers.files.audio import AudioWriter, check_audio_path
from ukrt.drivers.files.part import Part, count_all, count_notes
from ukrt.drivers.takes.reader import read_take
from ukrt.drivers.takes.replay import Replay
from ukrt.errors import AudioFileError, MidiFileError, ParameterError
from ukrt.units import gain_to_db


def render_take(
    path,
    target,
    *,
    bits="32f",
    overwrite=True,
    block_size=512,
    max_minutes=120.0,
    start_s=0.0,
    end_s=math.inf,
    progress=None,
    engine_factory=None,
):
    """Render a take, or a part of it, to a WAV or FLAC file, or to several where its sample rate changes.

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
    start_s, end_s : float [s]
        The part that is wanted, bit for bit as it stands in the whole.
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
    stretches = _stretches(parts, start_s, end_s)
    wanted = [stretch for stretch in stretches if stretch.is_wanted]
    if not wanted:
        raise ParameterError("start", start_s, f"the take ends at {seconds:.1f} s, and a part begins earlier")
    targets = _targets(target, len(wanted))
    for one, stretch in zip(targets, wanted, strict=True):
        check_audio_path(one, bits, take.channels, round(stretch.rate))
        if one.exists() and not overwrite:
            raise AudioFileError(f"{one}: exists already, a new file name is needed")
    replay = Replay(take, block_size, progress, engine_factory)
    writers = []
    try:
        peak = _write(replay, stretches, targets, bits, writers)
        for writer in writers:
            writer.close()
        return _report(take, replay, wanted, start_s, peak) | {
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


def _write(replay, stretches, targets, bits, writers):
    """Write the wanted parts of stretches to ``targets``, through writers that are put into ``writers``; returns the
    peak."""
    peak = 0.0
    for stretch in stretches:
        blocks = replay.blocks(stretch.first, stretch.first + stretch.part.end)
        if not stretch.is_wanted:
            collections.deque(blocks, maxlen=0)  # computed and not kept
            continue
        target, part = targets[len(writers)], stretch.part
        options = {"max_frames": part.end - part.start, "first_frame": part.start}
        writers.append(writer := AudioWriter(target, round(stretch.rate), replay.take.channels, bits, **options))
        for _, block in part.cut(blocks, to_end=True):
            peak = max(peak, float(np.max(np.abs(block), initial=0.0)))
            writer.write(block)
    return peak


@dataclass(frozen=True)
class _Stretch:
    """What is computed at one sample rate.

    Attributes
    ----------
    first : int
        Its first frame in the take.
    rate : float [Hz]
    part : Part
        What of it is kept, counted from its first frame; nothing is computed beyond.
    is_wanted : bool
        Whether that is anything.
    """

    first: int
    rate: float
    part: Part
    is_wanted: bool


def _stretches(parts, start_s, end_s):
    """What is to be computed of a take for the part of it between two times."""
    found, at_s = [], 0.0
    for first, end, rate in parts:
        length = end - first
        part = Part.of_seconds(start_s - at_s, end_s - at_s, rate)
        part = Part(min(max(part.start, 0), length), min(max(part.end, 0), length))
        is_wanted = part.start < part.end or start_s == at_s == length == 0
        if is_wanted or part.end > 0:
            found.append(_Stretch(first, rate, part, is_wanted))
        at_s += length / rate
    return found


def _targets(target, count):
    """The files of a take's parts."""
    target = pathlib.Path(target)
    return [target] + [target.with_stem(f"{target.stem}-{number}") for number in range(2, count + 1)]


def _report(take, replay, wanted, start_s, peak):
    """What was played and how, ready for JSON."""
    counters = {name: value for name, value in replay.engine.counters().items() if np.ndim(value) == 0}
    part = Part(wanted[0].first + wanted[0].part.start, wanted[-1].first + wanted[-1].part.end)
    is_whole = (part.start, part.end) == (0, take.frames)
    notes = replay.notes if is_whole else part.notes(replay.notes)
    speed = replay.timed_seconds / replay.compute_seconds if replay.compute_seconds > 0.0 else None
    return {
        **(count_all(counters["notes_on"], counters) if is_whole else count_notes(notes)),
        "duration_s": sum((stretch.part.end - stretch.part.start) / stretch.rate for stretch in wanted),
        "start_s": start_s,
        "peak_dbfs": gain_to_db(peak) if peak > 0.0 and math.isfinite(peak) else None,
        "times_real_time": speed,
        "preset": take.sounds[0].guitar.name,
        "sample_rate": wanted[0].rate,
        "signal": take.signal,
        "channels": take.channels,
        "frames": part.end - part.start,
        "lost_entries": take.lost,
        "recorded_with": take.version,
        "warnings": replay.warnings,
        "counters": counters,
        "notes": notes,
    }
