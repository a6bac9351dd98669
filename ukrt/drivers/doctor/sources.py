"""Three callbacks to be compared on one server: the instrument compiled, nothing, and the instrument from Python.

Enter an engine or a sample rate; leave objects that any output takes for an engine, with one way to read what they
counted. All six strings of the instrument ring: plucked again each 2 s, each stopped by the finger's contacts.
"""

import ctypes
import time

import numpy as np

from ukrt.engine import stage_layout as at
from ukrt.engine.callback_type import CALLBACK
from ukrt.engine.kernels import idle
from ukrt.model.fingerboard import fingerboard

PLUCK_SECONDS = 2.0
_FIRST_SECONDS = 0.05  # from the start of a slice to its first pluck
_VELOCITY = 100
_PATIENCE_SECONDS = 2.0  # for the end of a block: a busy machine may interrupt whoever computes it for a while
_PAUSE_SECONDS = 2e-4  # between two attempts to read between two blocks
_FLAG_KINDS = ("input_underflows", "input_overflows", "underflows", "overflows", "priming")  # PortAudio's bits 0 to 4


class Compiled:
    """The instrument as it is played live: the audio thread calls compiled code.

    Parameters
    ----------
    engine : Engine
    """

    name = "compiled"

    def __init__(self, engine):
        self.engine = engine
        self._last = 0
        # The first fret of all strings: a chord that only a finger across all of them can play.
        self._chord = [key + 1 for key in fingerboard(engine.guitar).open_keys]

    def __getattr__(self, name):  # whatever else an output asks of an engine
        return getattr(self.engine, name)

    def prepare(self, seconds):
        """Queue the plucks of the coming ``seconds`` [s], so that nobody need send anything while they pass."""
        rate = self.engine.sample_rate
        first = max(self._last, self.engine.frame + int(_FIRST_SECONDS * rate))
        for k in range(int(seconds / PLUCK_SECONDS) + 1):
            for note in self._chord:
                self._last = first + int(k * PLUCK_SECONDS * rate)
                self.engine.send(self._last, 0x90, note, _VELOCITY)

    def counts(self):
        """Frames, blocks, flags by kind and the histogram of loads so far (dict)."""
        frames, counters = self._between_blocks()
        return {
            "frames": frames,
            "blocks": counters["blocks"],
            "flags": {kind: counters.get(kind, 0) for kind in _FLAG_KINDS},
            "loads": dict(counters["load_histogram"]),
        }

    def _between_blocks(self):
        """Frames and counters that belong together: read while no block is computed, where that can be had."""
        si, ends = self.engine.stage.si, time.monotonic() + _PATIENCE_SECONDS
        while True:
            sequence, busy = int(si[at.G_STAMP_SEQ]), si[at.G_BUSY]
            read = self.engine.frame, self.engine.counters()
            if (not busy and sequence == si[at.G_STAMP_SEQ]) or time.monotonic() > ends:
                return read
            time.sleep(_PAUSE_SECONDS)

    def strings_plucked(self):
        """How many different strings have been plucked."""
        return len({note["string"] for note in self.engine.note_log() if note["string"] is not None})


class Empty:
    """A compiled callback that plays nothing."""

    name = "empty"

    def __init__(self, sample_rate, channels=2):
        self.sample_rate, self.channels = float(sample_rate), channels
        self._words = np.zeros(idle.WORDS, np.int64)
        self._words[idle.CHANNELS] = channels
        self.callback_address = idle.count_blocks.address
        self.userdata_address = self._words.ctypes.data
        self._cycles = None

    def follow(self, cycles):
        """Let an output that writes silence by itself count; ``cycles()`` gives its ``frames`` and ``cycles``."""
        self._cycles = cycles

    @property
    def frame(self):
        """Frames so far (int)."""
        return self._cycles()["frames"] if self._cycles else int(self._words[idle.FRAMES])

    def prepare(self, seconds):
        """Forget the longest gap, which the pause between two streams would else be."""
        self._words[idle.LAST] = self._words[idle.LONGEST_GAP] = 0

    def counts(self):
        """Frames, blocks, flags by kind so far (dict); what it does takes no time to speak of."""
        flags = self._words[idle.FLAGS : idle.FLAGS + idle.KINDS].tolist()
        return {
            "frames": self.frame,
            "blocks": self._cycles()["cycles"] if self._cycles else int(self._words[idle.BLOCKS]),
            "flags": dict(zip(_FLAG_KINDS, flags, strict=True)),
            "loads": {},
        }

    def longest_gap(self):
        """Longest time between two calls since `prepare` [s]; None where nobody measured it."""
        from ukrt.engine.host import tick_rate

        return int(self._words[idle.LONGEST_GAP]) / tick_rate() if tick_rate() and not self._cycles else None


class Interpreted(Compiled):
    """The same work the way Python programs usually do it: the audio thread calls a Python function."""

    name = "python"

    def __init__(self, engine):
        super().__init__(engine)
        self._seen, self._flags = (0, 0), [0] * len(_FLAG_KINDS)
        self._loads = {}
        self._function = CALLBACK(self._as_c)
        self.callback_address = ctypes.cast(self._function, ctypes.c_void_p).value
        self.userdata_address = engine.userdata_address

    def render(self, out, flags=0):
        """Fill ``out``, float32 (frames, channels); ``flags`` are PortAudio's."""
        began, frames = time.perf_counter(), len(out)
        out[:] = self.engine.process_card(frames)
        for kind in range(len(_FLAG_KINDS)):
            self._flags[kind] += (flags >> kind) & 1
        load = (time.perf_counter() - began) * self.engine.sample_rate / frames
        rounded = float(f"{load:.2g}")
        self._loads[rounded] = self._loads.get(rounded, 0) + 1
        self._seen = (self._seen[0] + frames, self._seen[1] + 1)  # at once: another thread reads both

    def counts(self):
        """As `Compiled.counts`, from what the Python function saw."""
        flags = dict(zip(_FLAG_KINDS, self._flags, strict=True))
        frames, blocks = self._seen
        return {"frames": frames, "blocks": blocks, "flags": flags, "loads": dict(self._loads)}

    def _as_c(self, _input, out, frames, _time, flags, _userdata):
        shape = (frames, self.engine.channels)
        self.render(np.ctypeslib.as_array(ctypes.cast(out, ctypes.POINTER(ctypes.c_float)), shape), flags)
        return 0


class PythonStream:
    """An `Interpreted` source through sounddevice's own callback interface, as its users write it."""

    def __init__(self, source, device, block_size):
        import sounddevice

        from ukrt.errors import DeviceError

        def callback(outdata, _frames, _time, status):
            source.render(outdata, status._flags)

        try:
            self._stream = sounddevice.OutputStream(
                device=device.index,
                channels=source.channels,
                samplerate=source.sample_rate,
                blocksize=block_size,
                latency="low",
                dtype="float32",
                callback=callback,
            )
        except sounddevice.PortAudioError as error:
            raise DeviceError(f"the audio output {device.name!r} cannot be opened: {error}") from error
        self.latency = self._stream.latency

    def start(self):
        """Let PortAudio call from now on."""
        self._stream.start()

    def close(self):
        """Stop and close."""
        self._stream.stop()
        self._stream.close()
        return True
