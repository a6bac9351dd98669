"""Renders MIDI files to sound, offline: a path and a preset enter, samples (or an audio file) and a report leave.

Sample 0 is MIDI time 0 and releases fall on the notes' times; `ukrt.drivers.files.offline` says how, and where the
sound ends.

Engines give Pa or N. Full scale 1.0 is 1 Pa or 1 N times the gain: for ``pressure`` the preset's ``radiation.gain_db``
plus ``gain_db``; for ``bridge-force`` and ``strings`` ``gain_db`` alone (a force is no loudness). Normalising, where
asked for, puts the peak at -1 dBFS, and ``gain_db`` then comes on top.

``start`` and ``end`` ask for a part, which is bit for bit what stands there in the whole (`ukrt.drivers.files.part`):
normalising, too, goes by the whole's peak.
"""

import math
import numbers
import os
import tempfile
from dataclasses import asdict

import numpy as np

from ukrt.drivers.files.audio import AudioWriter, check_audio_path
from ukrt.drivers.files.midi import load_midi_file
from ukrt.drivers.files.offline import MAX_TAIL_SECONDS, Performance
from ukrt.drivers.files.part import Part
from ukrt.drivers.files.position import find_part, parse_position
from ukrt.drivers.files.report import make_report
from ukrt.errors import AudioFileError, ParameterError
from ukrt.playing.written_fingering import CHOICES, choose_fingering
from ukrt.units import db_to_gain, gain_to_db

NORMALIZED_DB = -1.0
MAX_BLOCK = 8192
MAX_RESPONSE_SECONDS = 2.0
SIGNALS = ("pressure", "bridge-force", "strings")


def render(path, preset="classical", **options):
    """Render a MIDI file, or a part of it, to an array.

    Parameters
    ----------
    path : str or path-like
        The MIDI file.
    preset : str, path-like or Guitar
    **options
        As for `render_to`.

    Returns
    -------
    samples : ndarray (n, channels) float64
        Full scale 1.0; see the module's docstring for the level.
    report : dict
        As from `render_to`.
    """
    memory = _Memory()
    report = render_to(memory.open, path, preset, **options)
    return np.concatenate(memory.blocks), report


def render_file(path, target, preset="classical", *, bits="24", overwrite=True, sample_rate=48000, **options):
    """Render a MIDI file to a WAV or FLAC file, block by block; the file appears when it is whole.

    Parameters
    ----------
    path : str or path-like
        The MIDI file.
    target : str or path-like
        ``.wav`` or ``.flac``.
    preset : str, path-like or Guitar
    bits : {"16", "24", "32f"}
    overwrite : bool
        Whether an existing file may be replaced.
    sample_rate : float [Hz]
    **options
        As for `render_to`.

    Returns
    -------
    report : dict
        As from `render_to`; ``clipped_samples`` counts what the file clipped.
    """
    folder = check_audio_path(target, bits, sample_rate=sample_rate).parent
    writer = None

    def open_writer(channels, rate, max_frames, first_frame):
        nonlocal writer
        options = {"overwrite": overwrite, "max_frames": max_frames, "first_frame": first_frame}
        writer = AudioWriter(target, rate, channels, bits, **options)
        return writer

    try:
        report = render_to(open_writer, path, preset, sample_rate=sample_rate, spool_folder=folder, **options)
        writer.close()
    except BaseException:
        if writer is not None:
            writer.discard()
        raise
    return report | {"clipped_samples": writer.clipped_samples, "file": str(target), "bits": str(bits)}


def render_to(
    open_sink,
    path,
    preset="classical",
    *,
    sample_rate=48000,
    block_size=512,
    signal="pressure",
    gain_db=0.0,
    normalize=False,
    tail_db=-60.0,
    max_minutes=120.0,
    fingering="look-ahead",
    overrides=None,
    start=None,
    end=None,
    progress=None,
    spool_folder=None,
    engine_factory=None,
):
    """Render a MIDI file, or a part of it, block by block; only one block is in memory at a time.

    Parameters
    ----------
    open_sink : callable (channels, sample_rate, max_frames, first_frame) -> object with ``write(block)``
        Called once, when file and preset have been accepted; blocks are float64 (n <= block_size, channels), the first
        one's first frame is ``first_frame`` of the whole.
    path : str or path-like
        The MIDI file.
    preset : str, path-like or Guitar
    sample_rate : float [Hz]
    block_size : int
        1 to 8192 frames computed at once.
    signal : {"pressure", "bridge-force", "strings"}
        Stereo sound [Pa], the bridge's force [N], or each string's share of it [N].
    gain_db : float [dB]
    normalize : bool
        Peak at -1 dBFS (plus ``gain_db``); the sound waits in a temporary file until its peak is known.
    tail_db : float [dB]
        Below 0; energy at which the tail ends, relative to its largest value.
    max_minutes : float [min]
        Longer MIDI files are refused.
    fingering : {"look-ahead", "causal"}
        Strings and positions chosen with the whole piece in view, or as the notes come, as in live play.
    overrides : dict of str to str, optional
        Dotted preset keys and their values.
    start, end : str or float [s], optional
        The part that is wanted: seconds, or words such as ``"1:30"``, ``"bar:5"``, ``"bar:5.3"`` (its third beat),
        ``"marker:Chorus"``, see `ukrt.drivers.files.position`. The end itself is not in it.
    progress : callable (done_s, total_s), optional
        Called now and then with the time rendered and the time there is to render [s].
    spool_folder : path-like, optional
        Where `normalize` keeps its temporary file; by default the system's place.
    engine_factory : callable (guitar, sample_rate, signal=...) -> Engine, optional

    Returns
    -------
    report : dict
        See `ukrt.drivers.files.report.make_report`; and ``fingering``, how strings and positions were chosen
        (`ukrt.playing.written_fingering.Summary`).
    """
    _check_options(block_size, signal, gain_db, tail_db, fingering)
    score = load_midi_file(path, max_minutes)
    start_s, end_s = find_part(start, end, score, os.fspath(path))
    if start_s > score.duration_s + MAX_TAIL_SECONDS:
        raise _beyond(start, f"before {score.duration_s + MAX_TAIL_SECONDS:.1f} s")
    guitar = _guitar(preset, overrides)
    score, chosen = choose_fingering(score, guitar, fingering)
    engine = (engine_factory or _engine)(guitar, sample_rate, signal=signal)
    try:
        part = Part.of_seconds(start_s, end_s, engine.sample_rate)
        progress = _progress_until(math.inf if normalize else end_s, progress)
        performance = Performance(score, engine, block_size, tail_db, _response_frames(engine, signal), progress)
        most = min(math.ceil((score.duration_s + MAX_TAIL_SECONDS) * sample_rate) + 1, part.end) - part.start
        total_db = gain_db + (guitar.radiation.gain_db if signal == "pressure" else 0.0)
        meter = _Meter(open_sink(engine.channels, sample_rate, most, part.start))
        if normalize:
            total_db = _write_normalized(performance, part, meter, gain_db, engine.channels, spool_folder)
        else:
            gain = db_to_gain(total_db)
            for _, block in part.cut(performance.blocks()):
                meter.write(block * gain)
        if part.start > 0 and meter.frames == 0:
            raise _beyond(start, f"at {(engine.frame - engine.lead_frames) / sample_rate:.1f} s")
        return make_report(score, performance, meter, guitar, signal, total_db, part) | {"fingering": asdict(chosen)}
    finally:
        engine.close()


def _progress_until(end_s, progress):
    """``progress`` for what is computed up to ``end_s`` only."""
    return progress and (lambda done_s, total_s: progress(done_s, max(done_s, min(total_s, end_s))))


def _beyond(start, when):
    return ParameterError("start", parse_position(start).text, f"the sound ends {when}, and a part begins earlier")


class _Memory:
    """A sink that keeps its blocks."""

    def open(self, channels, sample_rate, max_frames, first_frame):
        self.blocks = [np.zeros((0, channels))]
        return self

    def write(self, block):
        self.blocks.append(block)


class _Meter:
    """Passes blocks on to a sink and keeps their peak, their number of frames and of samples beyond full scale."""

    def __init__(self, sink):
        self._sink = sink
        self.peak, self.frames, self.beyond_full_scale = 0.0, 0, 0

    def write(self, block):
        size = np.abs(block)
        self.peak = max(self.peak, float(np.max(size, initial=0.0)))
        self.frames += len(block)
        self.beyond_full_scale += int(np.count_nonzero(size > 1.0))
        self._sink.write(block)


def _write_normalized(performance, part, meter, gain_db, channels, folder):
    """Let the part wait in a temporary file until the whole's peak is known, then write it; returns the gain [dB]."""
    peak, rows = 0.0, 65536
    try:
        with tempfile.TemporaryFile(dir=folder) as spool:
            for whole, block in part.cut(performance.blocks(), to_end=True):
                peak = max(peak, float(np.max(np.abs(whole), initial=0.0)))
                spool.write(np.ascontiguousarray(block, dtype=np.float64).tobytes())
            total_db = NORMALIZED_DB + gain_db - (gain_to_db(peak) if peak > 0.0 else 0.0)
            gain = db_to_gain(total_db)
            spool.seek(0)
            while data := spool.read(rows * channels * 8):
                meter.write(np.frombuffer(data).reshape(-1, channels) * gain)
    except OSError as error:
        raise AudioFileError(
            f"{folder or tempfile.gettempdir()}: the sound cannot wait there until its peak is known "
            f"({error.strerror}), more room is needed (or no --normalize)"
        ) from None
    return total_db


def _check_options(block_size, signal, gain_db, tail_db, fingering):
    if not isinstance(block_size, numbers.Integral) or not 1 <= block_size <= MAX_BLOCK:
        raise ParameterError("block_size", block_size, f"a whole number from 1 to {MAX_BLOCK} frames is needed")
    if signal not in SIGNALS:
        raise ParameterError("signal", signal, f"one of {', '.join(SIGNALS)} is needed")
    if fingering not in CHOICES:
        raise ParameterError("fingering", fingering, f"one of {', '.join(CHOICES)} is needed")
    if not -200.0 <= gain_db <= 200.0:
        raise ParameterError("gain_db", gain_db, "a number from -200 to 200 dB is needed")
    if not -200.0 <= tail_db < 0.0:
        raise ParameterError("tail_db", tail_db, "a number from -200 dB to below 0 dB is needed")


def _guitar(preset, overrides):
    """The guitar itself, or the one that a preset's name or file describes."""
    if not isinstance(preset, str | os.PathLike):
        return preset
    from ukrt.model.presets import load_preset

    return load_preset(preset, dict(overrides or {}))


def _engine(guitar, sample_rate, signal):
    from ukrt.engine.engine import Engine  # the compiler is loaded only when the file and the preset are right

    return Engine(guitar, sample_rate, signal=signal)


def _response_frames(engine, signal):
    """Frames for which ``signal`` is still heard after its cause: forces not at all, pressure through the impulse
    response (the longest there may be, where the engine does not say)."""
    if signal != "pressure":
        return 0
    return int(getattr(engine, "response_frames", round(MAX_RESPONSE_SECONDS * engine.sample_rate)))
