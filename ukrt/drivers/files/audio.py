"""Writes audio files: blocks of float64 samples enter, a WAV or FLAC file of 16, 24 or 32 (float) bits leaves.

Until it is whole the sound stands in a hidden file beside the target, which replaces it in one step at the end and is
removed after any error or Ctrl-C: nobody ever finds half a file.

16 bits get triangular (TPDF) dither of two LSB peak to peak from a seeded generator, 24 bits are rounded without dither
(their LSB lies 144 dB down, below any converter's noise), 32 bits are float and hold any level. Digital silence stays
digital silence. Equal samples give equal bytes whatever the block sizes and the time of day.
"""

import errno
import os
import pathlib
import secrets
import shutil

import numpy as np
import soundfile

from ukrt.errors import AudioFileError

SUFFIXES = {".wav": "WAV", ".flac": "FLAC"}
BITS = {"16": "PCM_16", "24": "PCM_24", "32f": "FLOAT"}
FLAC_MAX_CHANNELS = 8  # RFC 9639
FLAC_MAX_RATE_HZ = 655_350  # libsndfile's limit
WAV_MAX_BYTES = 2**32 - 2**16  # RIFF counts bytes in 32 bits; the rest is for the header
MAX_CHANNELS = 1024  # libsndfile's limit


def check_audio_path(path, bits="24", channels=None, sample_rate=None):
    """Refuse, before any sound is computed, what could not be written.

    Parameters
    ----------
    path : str or path-like
    bits : {"16", "24", "32f"}
    channels : int, optional
    sample_rate : float [Hz], optional

    Returns
    -------
    target : pathlib.Path
        The file that will be replaced: ``path`` with its links followed.
    """
    path = pathlib.Path(path)
    kind = SUFFIXES.get(path.suffix.lower())
    if kind is None:
        raise AudioFileError(f"{path}: its suffix is {path.suffix!r}, .wav and .flac are legal")
    if str(bits) not in BITS:
        raise AudioFileError(f"{path}: {bits!r} bits were asked for, 16, 24 and 32f are legal")
    if channels is not None and not 1 <= channels <= MAX_CHANNELS:
        raise AudioFileError(f"{path}: {channels} channels were asked for, 1 to {MAX_CHANNELS} are legal")
    if sample_rate is not None and not (1 <= sample_rate < 2**31 and sample_rate == int(sample_rate)):
        raise AudioFileError(f"{path}: the sample rate is {sample_rate} Hz, an audio file needs a whole number of Hz")
    if kind == "FLAC":
        if str(bits) == "32f":
            raise AudioFileError(f"{path}: FLAC has no 32 bit float, 16 and 24 bits (or a .wav) are legal")
        if channels is not None and channels > FLAC_MAX_CHANNELS:
            raise AudioFileError(f"{path}: FLAC holds at most {FLAC_MAX_CHANNELS} channels, {channels} need a .wav")
        if sample_rate is not None and sample_rate > FLAC_MAX_RATE_HZ:
            raise AudioFileError(f"{path}: FLAC goes up to {FLAC_MAX_RATE_HZ} Hz, {sample_rate:g} Hz need a .wav")
    try:
        target = pathlib.Path(os.path.realpath(path))
        if not target.parent.is_dir():
            raise AudioFileError(f"{path}: there is no folder {target.parent}, an existing one is needed")
        if target.exists() and not target.is_file():
            raise AudioFileError(f"{path}: exists and is not a regular file, which alone can be replaced")
    except (OSError, ValueError) as error:  # ValueError: a NUL in the name
        raise AudioFileError(f"{path}: is no usable file name ({_reason(error)})") from None
    if target.exists() and not os.access(target, os.W_OK):
        raise AudioFileError(f"{path}: exists and may not be written, a writable file is needed")
    return target


class AudioWriter:
    """Writes one audio file block by block; use it as a context manager.

    Parameters
    ----------
    path : str or path-like
        ``.wav`` or ``.flac``.
    sample_rate : float [Hz]
        A whole number.
    channels : int
    bits : {"16", "24", "32f"}
        Also as an integer.
    overwrite : bool
        Whether an existing file may be replaced.
    max_frames : int, optional
        The most frames that may come; where a WAV of that length passes 4 GB it is written as RF64 (EBU Tech 3306).
    seed : int
        Of the dither.
    first_frame : int
        Where the file's first frame stands in a whole of which it is a part: it gets the dither that it has there.

    Attributes
    ----------
    frames : int
        Written so far.
    clipped_samples : int
        Samples beyond full scale, which integer formats clip; 0 for 32f.
    format : str
        ``WAV``, ``RF64`` or ``FLAC``.
    """

    def __init__(
        self, path, sample_rate, channels, bits="24", *, overwrite=True, max_frames=None, seed=0, first_frame=0
    ):
        self.path, self.bits, self.channels = pathlib.Path(path), str(bits), channels
        self._target = check_audio_path(path, self.bits, channels, sample_rate)
        if not overwrite and self._target.exists():
            raise AudioFileError(f"{path}: exists already, a new file name is needed")
        self.frames = self.clipped_samples = 0
        self._bytes_per_frame = channels * {"16": 2, "24": 3, "32f": 4}[self.bits]
        self.format = SUFFIXES[self.path.suffix.lower()]
        if self.format == "WAV" and max_frames is not None and max_frames * self._bytes_per_frame > WAV_MAX_BYTES:
            self.format = "RF64"
        generator = np.random.PCG64(seed).advance(2 * channels * first_frame)  # one step for each number drawn
        self._random = np.random.Generator(generator)
        self._part = self._target.with_name(f".ukrt-{secrets.token_hex(6)}.part")
        self._file = None
        try:
            os.close(os.open(self._part, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
            self._file = soundfile.SoundFile(
                self._part, "w", int(sample_rate), channels, subtype=BITS[self.bits], format=self.format
            )
        except (OSError, RuntimeError) as error:  # soundfile's own errors are RuntimeErrors
            self.discard()
            raise AudioFileError(f"{path}: cannot be written ({_reason(error)}), a writable folder is needed") from None
        except BaseException:
            self.discard()
            raise

    def write(self, block):
        """Append a block, float64 (n, channels), full scale 1.0."""
        block = np.asarray(block, dtype=np.float64).reshape(-1, self.channels)
        if not np.all(np.isfinite(block)):
            raise AudioFileError(f"{self.path}: a sample is not a finite number, which no audio file can hold")
        self.frames += len(block)
        if self.format == "WAV" and self.frames * self._bytes_per_frame > WAV_MAX_BYTES:
            raise AudioFileError(f"{self.path}: passes 4 GB, the most a WAV can hold; a .flac or fewer bits are needed")
        try:
            self._file.write(self._encode(block))
        except (OSError, RuntimeError, AssertionError) as error:  # soundfile asserts that all frames were taken
            free = shutil.disk_usage(self._target.parent).free
            reason = "the disk is full" if free < 2**20 else _reason(error) or "not all of it was taken"
            raise AudioFileError(
                f"{self.path}: cannot be written ({reason}), more room on the disk is needed"
            ) from None

    def _encode(self, block):
        """Samples as the file holds them: int16, int32 (24 bits left-aligned) or float32."""
        if self.bits == "32f":
            return block.astype(np.float32)
        full_scale = 2.0 ** (int(self.bits) - 1)
        scaled = block * full_scale
        if self.bits == "16":
            dither = self._random.random((len(block), 2, self.channels))
            scaled += (dither[:, 0] - dither[:, 1]) * np.any(block != 0.0, axis=1, keepdims=True)
        whole = np.rint(scaled)
        self.clipped_samples += int(np.count_nonzero((whole > full_scale - 1) | (whole < -full_scale)))
        whole = np.clip(whole, -full_scale, full_scale - 1)
        return whole.astype(np.int16) if self.bits == "16" else whole.astype(np.int32) << 8

    def close(self):
        """Finish the file and put it in its place."""
        if self._file is None:
            return
        try:
            self._file.close()
            if self.bits == "32f":
                _clear_peak_time(self._part)
            os.replace(self._part, self._target)
        except (OSError, RuntimeError) as error:
            self.discard()
            raise AudioFileError(
                f"{self.path}: cannot be finished ({_reason(error)}), a writable file is needed"
            ) from None
        self._file = None

    def discard(self):
        """Remove what was written; the target stays as it was."""
        try:
            if self._file is not None:
                self._file.close()
        except (OSError, RuntimeError):
            pass
        finally:
            self._file = None
            self._part.unlink(missing_ok=True)

    def __enter__(self):
        return self

    def __exit__(self, kind, error, trace):
        if kind is None:
            self.close()
        else:
            self.discard()


def _clear_peak_time(path):
    """Set the time of day in a float WAV's PEAK chunk to 0: it alone would make equal sound differ in bytes."""
    with open(path, "r+b") as file:
        head = file.read(4096)
        at = 12
        while at + 8 <= len(head) and head[at : at + 4] != b"data":
            if head[at : at + 4] == b"PEAK":
                file.seek(at + 12)  # after identifier, size and version
                file.write(bytes(4))
                return
            size = int.from_bytes(head[at + 4 : at + 8], "little")
            at += 8 + size + (size & 1)


def _reason(error):
    """A few words about an exception, without the hidden file's name."""
    if isinstance(error, OSError) and error.errno is not None:
        return "the disk is full" if error.errno == errno.ENOSPC else os.strerror(error.errno)
    return getattr(error, "error_string", "").rstrip(".") or str(error).rstrip(".")
