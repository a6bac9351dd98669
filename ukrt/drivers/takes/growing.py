"""Files that are whole at every instant while they grow: takes and WAV files, appended to in place.

New bytes enter, a file leaves that any reader understands, also if this process is killed between any two of its
writes: what is new is written behind the file's old end first; then the few bytes that let it count. In a take those
are the old end of the track, which the first of the new bytes overwrite; in a WAV file they are the header's lengths.
Such bytes never stand on both sides of a page boundary, because there a write can be interrupted. A disk that runs full
fails in the first of these steps, after which the file is cut back to what it held before.

WAV files are written here byte by byte: libsndfile can bring a header up to date while it writes
(SFC_UPDATE_HEADER_NOW), but python-soundfile has no public way to ask for it, and hides how many bytes a failed write
has left.
"""

import os
import pathlib
import struct

import numpy as np

from ukrt.drivers.takes.take import Encoder, describe, file_head, text, ticks_and_tempo

PAGE = 4096  # what systems write at once; larger pages are multiples of it
END_BYTES = 7  # of the longest end of a track: a delta of four bytes and the event
LENGTH_AT = 18  # where the length of a take's track stands
WAV_MAX_BYTES = 2**32 - 2**16  # RIFF counts bytes in 32 bits; the rest is for the header
WAV_HEADER = struct.Struct("<4sI4s4sIHHIIHHH4sII4sI")
IEEE_FLOAT = 3  # WAVE_FORMAT_IEEE_FLOAT
SAMPLE_BYTES = 4


class _File:
    """A new file without buffers between it and the system."""

    def __init__(self, path):
        self.path = pathlib.Path(path)
        self._file = open(self.path, "xb", buffering=0)

    def _put(self, data, at):
        """Write all of ``data`` at byte ``at``."""
        self._file.seek(at)
        view = memoryview(data).cast("B")
        while len(view):
            view = view[self._file.write(view) :]

    def _cut(self, size):
        """Make the file ``size`` bytes long, where the system lets it."""
        try:
            self._file.truncate(size)
        except OSError:
            pass  # what stands behind the end that counts harms no reader

    def close(self):
        """Bring what was written to the disk and close."""
        try:
            os.fsync(self._file.fileno())
        finally:
            self._file.close()


class GrowingTake(_File):
    """A take that is appended to.

    Parameters
    ----------
    path : path-like
        A new file.
    sound : Sound
        The guitar that begins.
    signal : str
    channels : int
    settings : dict
        The engine's, ready for JSON.

    Attributes
    ----------
    frames : int
        Where the track ends now.
    """

    def __init__(self, path, sound, signal, channels, settings):
        division, _ = ticks_and_tempo(sound.sample_rate)
        self._encoder = Encoder(division)
        head = self._encoder.head(sound, describe(sound, signal, channels, settings, division))
        head += _padding(len(file_head(division, 0)) + len(head))
        end = self._encoder.end(0)
        start = file_head(division, len(head) + len(end))
        super().__init__(path)
        try:
            self._put(start + head + end, 0)
        except OSError:
            self._file.close()
            self.path.unlink(missing_ok=True)
            raise
        self._head_bytes = len(start)
        self._at, self._end, self.frames = len(start) + len(head), end, 0

    def append(self, entries, frames, sounds, lost=0):
        """Append entries of the journal, and let the track end at ``frames``.

        Parameters
        ----------
        entries : iterable of (frame, word)
            Plain integers.
        frames : int
            Computed so far.
        sounds : callable (number) -> Sound
            What each swap brings.
        lost : int
            Entries that are missing before these.
        """
        encoder, before = self._encoder, self._encoder.frame
        try:
            data = encoder.lost(self.frames, lost) if lost else b""
            data += b"".join([encoder.entry(frame, word, sounds) for frame, word in entries])
            data += encoder.bridge(frames)
            if data:
                data += _padding(self._at + len(data))
            self._commit(data, encoder.end(frames))
        except BaseException:
            encoder.frame = before
            raise
        self.frames = frames

    def _commit(self, data, end):
        """Put ``data`` and the new end in the place of the old end."""
        new, old = data + end, len(self._end)
        try:
            self._put(new[old:], self._at + old)
            self._put(new[:old], self._at)
            self._put((self._at + len(new) - self._head_bytes).to_bytes(4, "big"), LENGTH_AT)
        except OSError:
            try:
                self._put(self._end, self._at)
                self._put((self._at + old - self._head_bytes).to_bytes(4, "big"), LENGTH_AT)
            finally:
                self._cut(self._at + old)
            raise
        self._at, self._end = self._at + len(data), end
        if len(new) < old:
            self._cut(self._at + len(end))


def _padding(at):
    """An empty text where the end of a track at byte ``at`` could reach over a page boundary; nothing elsewhere."""
    left = PAGE - at % PAGE
    return b"\0" + text(" " * max(left - 4, 0)) if left < END_BYTES else b""


class GrowingWav(_File):
    """A WAV file of 32-bit floats that is appended to.

    Parameters
    ----------
    path : path-like
        A new file.
    sample_rate : float [Hz]
        Rounded to whole hertz.
    channels : int

    Attributes
    ----------
    frames : int
        Written so far.
    room : int
        Frames it can still take: a WAV file ends at 4 GB.
    """

    def __init__(self, path, sample_rate, channels):
        self._rate, self._frame_bytes, self.frames = round(sample_rate), SAMPLE_BYTES * channels, 0
        self._channels = channels
        super().__init__(path)
        try:
            self._put(self._header(0), 0)
        except OSError:
            self._file.close()
            self.path.unlink(missing_ok=True)
            raise

    @property
    def room(self):
        return WAV_MAX_BYTES // self._frame_bytes - self.frames

    def append(self, samples):
        """Append samples, float32 (n, channels), at most ``room`` of them."""
        data = np.ascontiguousarray(samples, dtype="<f4")
        end = WAV_HEADER.size + self.frames * self._frame_bytes
        try:
            if data.size:
                self._put(data.reshape(-1), end)
            self._put(self._header(self.frames + len(data)), 0)
        except OSError:
            try:
                self._put(self._header(self.frames), 0)
            finally:
                self._cut(end)
            raise
        self.frames += len(data)

    def append_silence(self, frames):
        """Append ``frames`` frames of zeros, at most ``room``."""
        self.append(np.zeros((frames, self._channels), np.float32))

    def _header(self, frames):
        size, rest = frames * self._frame_bytes, WAV_HEADER.size - 8
        return WAV_HEADER.pack(
            b"RIFF", rest + size, b"WAVE",
            b"fmt ", 18, IEEE_FLOAT, self._channels, self._rate, self._rate * self._frame_bytes, self._frame_bytes,
            8 * SAMPLE_BYTES, 0,
            b"fact", 4, frames,
            b"data", size,
        )  # fmt: skip
