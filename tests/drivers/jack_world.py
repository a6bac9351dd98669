"""What tests of the JACK driver stand on: a server of their own, another client that sends, a third that records."""

import time

import numpy as np
import pytest
from numba import carray, cfunc, types

try:
    import jack
except (ImportError, OSError) as error:
    pytest.skip(f"needs JACK-Client and libjack: {error}", allow_module_level=True)

from jack_servers import JackServer

from ukrt.drivers.jack.client import JackOutput
from ukrt.engine import stage_layout as stage
from ukrt.engine.kernels.machine import integers_at
from ukrt.engine.kernels.queue import first_frame, take_first


class World:
    """A server and what was opened on it, our process led to it; all is closed and ended afterwards."""

    def __init__(self, folder, monkeypatch, sync=False, period=128):
        self.server = JackServer(folder / "jackd.log", sync, realtime=True)
        self._opened = []
        self.server.start(period=period)
        self.server.lead(monkeypatch)

    def open(self, kind, *arguments, **options):
        """Open something that has a ``close``."""
        self._opened.append(kind(*arguments, **options))
        return self._opened[-1]

    def started(self, engine, **options):
        """A running output of the engine."""
        output = self.open(JackOutput, engine, **options)
        output.start()
        frame = engine.frame
        wait_until(lambda: engine.frame > frame)
        return output

    def close(self):
        """Close what was opened, the last first."""
        while self._opened:
            self._opened.pop().close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        try:
            self.close()
        finally:
            self.server.end()


def wait_until(condition, otherwise=lambda: pytest.fail("it did not happen in time"), seconds=20.0):
    """Wait until a condition holds."""
    ends = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > ends:
            otherwise()
            return
        time.sleep(0.01)


class Sender:
    """A client with a MIDI output: each message goes out at the frame of JACK's time that it names."""

    def __init__(self, name="keyboard"):
        self.client = jack.Client(name, no_start_server=True)
        self.port = self.client.midi_outports.register("out", is_physical=True)
        self.waiting, self.sent = [], []
        self.client.set_process_callback(self._process)
        self.client.activate()

    def _process(self, frames):
        self.port.clear_buffer()
        start = self.client.last_frame_time
        while self.waiting and self.waiting[0][0] < start + frames:
            when, data = self.waiting.pop(0)
            when = max(when, start)
            self.port.write_midi_event(when - start, data)
            self.sent.append((when, data))

    def close(self):
        self.client.deactivate()
        self.client.close()


class Recorder:
    """A client that records: blocks with the frame of JACK's time at which each began."""

    def __init__(self, channels=2, name="recorder"):
        self.client = jack.Client(name, no_start_server=True)
        self.ports = [self.client.inports.register(f"in_{k}") for k in range(channels)]
        self.blocks = []
        self.client.set_process_callback(self._process)
        self.client.activate()

    def _process(self, _frames):
        block = np.array([port.get_array() for port in self.ports])
        self.blocks.append((self.client.last_frame_time, block))

    def heard(self):
        """The samples (n, channels) of all cycles, one after another, whatever the server left out between them."""
        return np.concatenate([block.T for _, block in self.blocks[:]])

    def place(self, frame):
        """Where in `heard` a frame of JACK's time stands that lies in one of the cycles (int)."""
        place = 0
        for start, block in self.blocks[:]:
            if 0 <= frame - start < block.shape[1]:
                return place + frame - start
            place += block.shape[1]
        raise ValueError(f"no cycle holds frame {frame}")

    def skipped(self):
        """Frames by which the server's time ran ahead between two cycles of one period: it was late (int)."""
        cycles = [(start, block.shape[1]) for start, block in self.blocks[:]]
        pairs = zip(cycles, cycles[1:], strict=False)
        return sum(max(0, later - start - n) for (start, n), (later, m) in pairs if n == m)

    def sound(self):
        """(frame of JACK's time of the first sample, samples (n, channels)); cycles that were missed are zeros."""
        blocks = list(self.blocks)
        first, (last, block) = blocks[0][0], blocks[-1]
        sound = np.zeros((last - first + block.shape[1], len(self.ports)), np.float32)
        for start, block in blocks:
            sound[start - first : start - first + block.shape[1]] = block.T
        return first, sound

    def close(self):
        self.client.deactivate()
        self.client.close()


_ULONG = types.uint32 if np.dtype("L").itemsize == 4 else types.uint64
_SIGNATURE = types.int32(types.voidptr, types.voidptr, _ULONG, types.voidptr, _ULONG, types.CPointer(types.int64))


@cfunc(_SIGNATURE, nopython=True)
def _pulse(_input, output, n_frames, _time, _flags, words):
    """One sample of height note / 128 at each message's frame."""
    table = carray(words, stage.WORDS)
    si = integers_at(table[stage.W_SI], stage.SI_SIZE)
    out = carray(output, (np.int64(n_frames), 2), np.float32)
    for k in range(np.int64(n_frames)):
        out[k, 0] = out[k, 1] = 0.0
        while (
            si[stage.LANE_READ + stage.LANE_STEP * stage.LANE_JACK]
            < si[stage.LANE_WRITE + stage.LANE_STEP * stage.LANE_JACK]
            and first_frame(si, stage.LANE_JACK) <= si[stage.G_FRAME]
        ):
            word = take_first(si, stage.LANE_JACK)
            out[k, 0] += ((word >> 8) & 0x7F) / 128.0
        si[stage.G_FRAME] += 1
    return 0


class PulseEngine:
    """Stands for an engine whose answer to a message is one sample, at the message's frame."""

    channels, sample_rate = 2, 48000.0

    def __init__(self):
        self._si, self._words = np.zeros(stage.SI_SIZE, np.int64), np.zeros(stage.WORDS, np.int64)
        self._words[stage.W_MAGIC] = stage.MAGIC
        self._words[stage.W_SI] = self._si.ctypes.data
        self.callback_address, self.userdata_address = _pulse.address, self._words.ctypes.data

    @property
    def frame(self):
        """The next frame to be computed (int)."""
        return int(self._si[stage.G_FRAME])

    def send(self, *_message, lane):
        """Let go of keys as the output closes: nothing rings."""
        return lane == stage.LANE_JACK
