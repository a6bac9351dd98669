"""An output without a sound card: a clock calls the engine's C function block by block; a WAV file may keep the sound.

It calls the same function pointer with the same arguments as PortAudio would, in real time, so that everything but the
loudspeaker is as on a machine with a sound card. The clock is a thread of Python's: what computes beside it makes its
blocks late, though not wrong, and by no more than it takes to catch up.
"""

import datetime
import os
import pathlib
import tempfile
import threading
import time

import numpy as np

from ukrt.drivers.sound.claims import claim, release
from ukrt.engine.callback_type import CALLBACK
from ukrt.errors import AudioFileError

_LATE_SECONDS = 0.5  # further behind than this, the clock starts anew instead of catching up


class NullOutput:
    """A clocked output that plays into a WAV file (32-bit float) or into silence.

    Parameters
    ----------
    engine : Engine
    block_size : int
        Frames per call.
    path : path-like, optional
        The WAV file; by default a new one in the current folder (see `new_recording_path`).
    silent : bool
        No file: the clock alone, as a stand-in while a device is away.
    """

    def __init__(self, engine, block_size=128, path=None, *, silent=False):
        self.path = None if silent else pathlib.Path(path) if path else new_recording_path()
        self.name = "the null output"
        self.block_size = int(block_size)
        self.late_blocks = 0  # that began more than a block after their time
        self.skipped_seconds = 0.0  # that the clock let go instead of catching up
        self._engine = engine
        self._callback = CALLBACK(engine.callback_address)
        self._block = np.zeros((self.block_size, engine.channels), np.float32)
        self._set_rate(engine.sample_rate)
        self._file = None if silent else _open_file(self.path, self.sample_rate, engine.channels)
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="ukrt-null-output", daemon=True)

    def start(self):
        """Start the clock."""
        claim(self._engine, self)
        self._thread.start()

    @property
    def running(self):
        """Whether the clock goes on."""
        return self._thread.is_alive()

    def xruns(self):
        """Blocks that came too late (int)."""
        return self.late_blocks

    def refresh(self):
        """Nothing to do: this output shares the engine's memory and reads it anew at every block."""

    def _set_rate(self, sample_rate):
        self.sample_rate = float(sample_rate)
        self.latency = self.block_size / self.sample_rate

    def close(self):
        """Stop the clock and finish the file; True when both are done."""
        self._stop.set()
        if self._thread.ident is not None:
            self._thread.join()
        release(self._engine, self)
        if self._file is not None:
            self._file.close()
        return True

    def _run(self):
        out, userdata = self._block.ctypes.data, self._engine.userdata_address
        began, blocks = time.perf_counter(), 0
        while not self._stop.is_set():
            if self._engine.sample_rate != self.sample_rate:  # another instance plays: count from here at its rate
                self._set_rate(self._engine.sample_rate)
                began, blocks = time.perf_counter(), 0
            # From the start, not from the block before: adding periods would let the rounding add up to a drift.
            wait = began + blocks * self.latency - time.perf_counter()
            if wait > 0:
                time.sleep(wait)
            elif wait < -self.latency:
                self.late_blocks += 1
                if wait < -_LATE_SECONDS:
                    self.skipped_seconds -= wait
                    began -= wait
            result = self._callback(None, out, self.block_size, None, 0, userdata)
            if self._file is not None:
                self._file.write(self._block)
            blocks += 1
            if result != 0:  # paComplete or paAbort, as PortAudio would take it
                break


def _open_file(path, sample_rate, channels):
    import soundfile

    try:
        return soundfile.SoundFile(path, "w", int(round(sample_rate)), channels, subtype="FLOAT", format="WAV")
    except (OSError, soundfile.SoundFileError) as error:
        raise AudioFileError(f"cannot write {path}: {error}") from error


def new_recording_path():
    """A file name that is not taken, with date and time, in the current folder or, where that is not writable, in the
    system's folder for temporary files (Path)."""
    folder = pathlib.Path.cwd()
    if not os.access(folder, os.W_OK):
        folder = pathlib.Path(tempfile.gettempdir())
    stem = f"ukrt-play-{datetime.datetime.now():%Y%m%d-%H%M%S}"
    path, number = folder / f"{stem}.wav", 1
    while path.exists():
        path, number = folder / f"{stem}-{number}.wav", number + 1
    return path
