"""An output without a sound card: a clock calls the engine's C function block by block, and a WAV file keeps the sound.

It calls the same function pointer with the same arguments as PortAudio would, in real time, so that everything but the
loudspeaker is as on a machine with a sound card.
"""

import ctypes
import datetime
import os
import pathlib
import tempfile
import threading
import time

import numpy as np

from ..errors import AudioFileError

# int callback(const void *in, void *out, unsigned long frames, const void *time, unsigned long flags, void *userdata)
CALLBACK = ctypes.CFUNCTYPE(
    ctypes.c_int,
    ctypes.c_void_p,
    ctypes.c_void_p,
    ctypes.c_ulong,
    ctypes.c_void_p,
    ctypes.c_ulong,
    ctypes.c_void_p,
)
_LATE_SECONDS = 0.5  # further behind than this, the clock starts anew instead of catching up


class NullOutput:
    """A clocked output that plays into a WAV file (32-bit float).

    Parameters
    ----------
    engine : Engine
    block_size : int
        Frames per call.
    path : path-like, optional
        The WAV file; by default a new one in the current folder (see `new_recording_path`).
    """

    def __init__(self, engine, block_size=128, path=None):
        import soundfile

        self.path = pathlib.Path(path) if path else new_recording_path()
        self.name = "the null output"
        self.block_size, self.sample_rate = int(block_size), float(engine.sample_rate)
        self.latency = self.block_size / self.sample_rate
        self.late_blocks = 0
        self._engine = engine
        self._callback = CALLBACK(engine.callback_address)
        self._block = np.zeros((self.block_size, engine.channels), np.float32)
        try:
            self._file = soundfile.SoundFile(
                self.path, "w", int(round(self.sample_rate)), engine.channels, subtype="FLOAT", format="WAV"
            )
        except (OSError, soundfile.SoundFileError) as error:
            raise AudioFileError(f"cannot write {self.path}: {error}") from error
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="ukrt-null-output", daemon=True)

    def start(self):
        """Start the clock."""
        self._thread.start()

    @property
    def running(self):
        """Whether the clock goes on."""
        return self._thread.is_alive()

    def close(self):
        """Stop the clock and finish the file; True when both are done."""
        self._stop.set()
        if self._thread.ident is not None:
            self._thread.join()
        self._file.close()
        return True

    def _run(self):
        period, due = self.block_size / self.sample_rate, time.perf_counter()
        out = self._block.ctypes.data
        while not self._stop.is_set():
            wait = due - time.perf_counter()
            if wait > 0:
                time.sleep(wait)
            elif wait < -period:
                self.late_blocks += 1
                if wait < -_LATE_SECONDS:
                    due = time.perf_counter()
            result = self._callback(None, out, self.block_size, None, 0, self._engine.userdata_address)
            self._file.write(self._block)
            due += period
            if result != 0:  # paComplete or paAbort, as PortAudio would take it
                break


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
