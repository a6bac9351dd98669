"""Reads a Standard MIDI File: a path enters, a `Score` of channel messages with their times in seconds leaves.

The events are scanned by `ukrt.drivers.files.midi_events` and not by ``mido.MidiFile``: mido reads numbers of any
length (one megabyte of 0xFF costs 81 s), raises six classes of exception on broken files, needs the header's number of
tracks to be right, and gives negative times for SMPTE divisions. What mido knows better, the length of each kind of
message, is taken from its table; the tests hold this scanner against mido's on well-formed files.

What is done with files that break the rules (Standard MIDI Files 1.0, MMA RP-001):

- Played, with a warning: bytes after the end of a track or of the last chunk, a missing end of track, a wrong number of
  tracks, a wrong track length, several tracks in format 0 (merged like format 1), an unknown format (read as format 1,
  as the standard suggests), system messages inside a track (skipped), running status across metas and exclusives,
  a tempo that is zero or not three bytes long (ignored), a track that breaks off or cannot be understood any further
  (played up to there).
- Refused with a `MidiFileError`: everything of which no track can be understood, or no note where a track broke.

Format 2 holds independent sequences; they are played one after another, each with its own tempo map, and each one's
name is a marker at its beginning. Chunks that are not tracks are skipped, RIFF wrappers (RMID) opened. In formats 0 and
1 events at the same tick keep the order of the tracks. Music begins at time 0: an SMPTE offset is passed over.
"""

import os
import pathlib
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from ukrt.drivers.files.bars import Bars, Sequence
from ukrt.drivers.files.midi_events import read_at_most
from ukrt.drivers.files.midi_track import MAX_EVENTS, UnreadableError, scan_track
from ukrt.drivers.files.tempo_map import TempoMap
from ukrt.errors import MidiFileError

MAX_BYTES = 32 * 2**20
MAX_TRACKS = 65535  # what the header's 16 bits can count
MAX_WARNINGS = 20
FRAMES_PER_SECOND = {24: Fraction(24), 25: Fraction(25), 29: Fraction(30000, 1001), 30: Fraction(30)}  # 29: 29.97 drop


@dataclass(frozen=True)
class Score:
    """What a MIDI file asks for: channel messages in time order.

    Attributes
    ----------
    time_s : ndarray (n,) float64 [s]
        Not decreasing; 0 is the start of the file.
    status, data1, data2 : ndarray (n,) uint8
        The message bytes, status 0x80 to 0xEF; ``data2`` is 0 where the message has only one data byte. Universal SysEx
        stands among them in pieces of status 0xF0 to 0xF7, see `ukrt.engine.stage_layout`.
    duration_s : float [s]
        Time of the last event of any kind, ends of tracks included.
    n_notes : int
        Note-ons of velocity above 0.
    midi_format : int
        0, 1 or 2.
    title, copyright : str
        First track name and first copyright notice, "" where absent.
    track_names : tuple of str
    warnings : tuple of str
        One sentence for each oddity that was played around.
    markers : tuple of (float [s], str)
        Markers and cue points in time order.
    bars : Bars or None
        None where a score is not from a file.
    """

    time_s: np.ndarray
    status: np.ndarray
    data1: np.ndarray
    data2: np.ndarray
    duration_s: float
    n_notes: int
    midi_format: int = 1
    title: str = ""
    copyright: str = ""
    track_names: tuple = ()
    warnings: tuple = ()
    markers: tuple = ()
    bars: Bars | None = None


def load_midi_file(path, max_minutes=120.0):
    """Read a MIDI file of format 0, 1 or 2, plain or RIFF-wrapped.

    Parameters
    ----------
    path : str or path-like
    max_minutes : float [min]
        Longer pieces are refused.

    Returns
    -------
    Score

    Raises
    ------
    MidiFileError
        One sentence: the file, what was found, what is legal. No other exception leaves this function for any content.
    """
    data = _read(path)
    try:
        return _score(data, max_minutes)
    except UnreadableError as reason:
        raise MidiFileError(f"{os.fspath(path)}: {reason}") from None


def _read(path):
    path = pathlib.Path(path)
    try:
        if path.is_dir():
            raise MidiFileError(f"{path}: is a folder, a MIDI file is needed")
        if path.exists() and not path.is_file():
            raise MidiFileError(f"{path}: is not a regular file, a MIDI file is needed")
        data = read_at_most(path, MAX_BYTES)
    except FileNotFoundError:
        raise MidiFileError(f"{path}: no such file, an existing MIDI file is needed") from None
    except (OSError, ValueError) as error:  # ValueError: a NUL in the name
        reason = getattr(error, "strerror", None) or error
        raise MidiFileError(f"{path}: cannot be read ({reason}), a readable MIDI file is needed") from None
    if not data:
        raise MidiFileError(f"{path}: is empty, a MIDI file begins with MThd")
    if len(data) > MAX_BYTES:
        raise MidiFileError(f"{path}: is larger than {MAX_BYTES >> 20} MB, the most a MIDI file may have here")
    return data


# Chunks ------------------------------------------------------------------------------------------------------------
def _unwrap_riff(data):
    """The MIDI file inside a RIFF RMID file; anything else as it is."""
    if data[:4] != b"RIFF" or data[8:12] != b"RMID":
        return data
    at = 12
    while at + 8 <= len(data):
        size = int.from_bytes(data[at + 4 : at + 8], "little")
        if data[at : at + 4] == b"data":
            return data[at + 8 : at + 8 + size]
        at += 8 + size + (size & 1)
    raise UnreadableError("a RIFF RMID file without a data chunk, where the MIDI file must stand")


def _is_chunk(data, at):
    """Whether a chunk may begin at ``at``: the file ends there, or four printable letters stand there."""
    return at == len(data) or (at + 8 <= len(data) and all(0x20 <= byte < 0x7F for byte in data[at : at + 4]))


def _header(data, warnings):
    """Read the header chunk; returns (format, declared tracks, ticks per quarter note or None, ticks per second or
    None, position of the next chunk)."""
    if data[:4] != b"MThd":
        raise UnreadableError(f"begins with {bytes(data[:4])!r}, a MIDI file begins with MThd")
    size = int.from_bytes(data[4:8], "big")
    if len(data) < 14 or size < 6:
        raise UnreadableError(f"the header has {min(size, max(len(data) - 8, 0))} bytes, at least 6 are needed")
    midi_format, n_tracks, division = (int.from_bytes(data[k : k + 2], "big") for k in (8, 10, 12))
    after = 8 + size
    if after != 14 and (after >= len(data) or not _is_chunk(data, after)) and data[14:18] == b"MTrk":
        warnings.append(f"the header says it is {size} bytes long, but the first track begins after 6")
        after = 14
    if midi_format > 2:
        warnings.append(f"format {midi_format} is unknown (legal: 0, 1, 2), read as format 1")
        midi_format = 1
    if division == 0:
        raise UnreadableError("the division is 0 ticks per quarter note, 1 to 32767 are legal")
    if division < 0x8000:
        return midi_format, n_tracks, division, None, after
    frames, ticks = 256 - (division >> 8), division & 0xFF
    if frames not in FRAMES_PER_SECOND or ticks == 0:
        raise UnreadableError(
            f"the SMPTE division is {frames} frames per second of {ticks} ticks, "
            "legal are 24, 25, 29 or 30 frames of 1 to 255 ticks"
        )
    return midi_format, n_tracks, None, FRAMES_PER_SECOND[frames] * ticks, after


def _tracks(data, at, warnings):
    """Scan every track chunk from ``at`` on; other chunks are skipped."""
    tracks, n_events = [], 0
    while at < len(data):
        if at + 8 > len(data):
            warnings.append(f"{len(data) - at} bytes after the last chunk are ignored")
            break
        size = int.from_bytes(data[at + 4 : at + 8], "big")
        start, end = at + 8, at + 8 + size
        if data[at : at + 4] != b"MTrk":
            if not _is_chunk(data, at):
                warnings.append(f"{len(data) - at} bytes that are no chunk are ignored at byte {at}")
                break
            at = end
            continue
        if len(tracks) == MAX_TRACKS:
            raise UnreadableError(f"has more than {MAX_TRACKS} tracks, the most the format can count")
        number = len(tracks) + 1
        end_is_right = end <= len(data) and _is_chunk(data, end)
        track, stop = scan_track(data, start, end if end_is_right else len(data), MAX_EVENTS - n_events)
        n_events += track.n_events
        if not end_is_right and stop != end:
            track.odd.append(f"says it is {size} bytes long, which leads to no other chunk")
            end = stop
        elif stop < end:
            if data[stop : stop + 4] == b"MTrk":
                track.odd.append(f"says it is {size} bytes long, but the next track begins after {stop - start}")
                end = stop
            elif not track.broken:
                track.odd.append(f"has {end - stop} bytes after its end, which are ignored")
        warnings.extend(f"track {number} {text}" for text in track.odd)
        tracks.append(track)
        at = end
    return tracks


# Time ----------------------------------------------------------------------------------------------------------------


def _merge(tracks):
    """Channel messages of tracks that sound together, in time order: (ticks, status, data1, data2)."""
    columns = [
        np.concatenate([np.frombuffer(getattr(track, name), dtype=kind) for track in tracks])
        for name, kind in (("ticks", np.int64), ("status", np.uint8), ("data1", np.uint8), ("data2", np.uint8))
    ]
    order = np.argsort(columns[0], kind="stable")
    return [column[order] for column in columns]


def _score(data, max_minutes):
    warnings = []
    data = _unwrap_riff(data)
    midi_format, declared, per_quarter, per_second, at = _header(data, warnings)
    tracks = _tracks(data, at, warnings)
    if not tracks:
        raise UnreadableError("has a header but no track, at least one MTrk chunk is needed")
    if len(tracks) != declared:
        warnings.append(f"the header says {declared} tracks, {len(tracks)} are there")
    if midi_format == 0 and len(tracks) > 1:
        warnings.append(f"format 0 has one track, here are {len(tracks)}; they are played together")
    groups = [[track] for track in tracks] if midi_format == 2 else [tracks]
    parts, sequences, markers, start = [], [], [], 0.0
    for group in groups:
        sequence = _sequence(group, start, per_quarter, per_second)
        length = sequence.clock.seconds(sequence.end_tick)
        if start + length > 60.0 * max_minutes:
            raise UnreadableError(
                f"lasts {(start + length) / 60.0:.1f} minutes or more, at most {max_minutes:g} are allowed "
                "(option --max-minutes)"
            )
        ticks, *columns = _merge(group)
        parts.append((start + sequence.clock.seconds_array(ticks), *columns))
        sequences.append(sequence)
        if midi_format == 2 and group[0].name:
            markers.append((start, group[0].name))
        markers += _in_order((start + sequence.clock.seconds(tick), name) for t in group for tick, name in t.markers)
        start += length
    time_s, status, data1, data2 = (np.concatenate(column) for column in zip(*parts, strict=True))
    n_notes = int(np.count_nonzero((status & 0xF0 == 0x90) & (data2 > 0)))
    if n_notes == 0 and (broken := [text for text in warnings if "breaks off" in text]):
        raise UnreadableError(f"no note could be read: {broken[0]}")
    if len(warnings) > MAX_WARNINGS:
        warnings[MAX_WARNINGS:] = [f"and {len(warnings) - MAX_WARNINGS} more oddities"]
    names = tuple(track.name for track in tracks if track.name)
    copyrights = [track.copyright for track in tracks if track.copyright]
    return Score(
        time_s,
        status,
        data1,
        data2,
        start,
        n_notes,
        midi_format,
        title=names[0] if names else "",
        copyright=copyrights[0] if copyrights else "",
        track_names=names,
        warnings=tuple(warnings),
        markers=tuple(markers),
        bars=Bars(sequences),
    )


def _sequence(tracks, start_s, per_quarter, per_second):
    """The times and bars of tracks that sound together."""
    clock = TempoMap([change for track in tracks for change in track.tempos], per_quarter, per_second)
    signatures, keys = (_in_order(c for t in tracks for c in getattr(t, name)) for name in ("signatures", "keys"))
    return Sequence(start_s, clock, max(track.end_tick for track in tracks), tuple(signatures), tuple(keys))


def _in_order(events):
    """Events in order of their first item; those at the same place keep the order of the tracks."""
    return sorted(events, key=lambda event: event[0])
