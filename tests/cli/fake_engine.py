"""An engine without physics for tests of what drives engines: its callback writes the number of each frame."""

import ctypes

import numpy as np

from ukrt.engine.callback_type import CALLBACK


class FakeEngine:
    """Counts frames as the real one does; writes frame / 1000 on every channel; keeps what it is sent."""

    channels = 2

    def __init__(self, sample_rate=48000.0, capacity=1000):
        self.sample_rate, self.capacity = sample_rate, capacity
        self.frame, self.blocks, self.sent, self.result = 0, 0, [], 0
        self.userdata_address = 0x1234
        self.userdata_seen = set()
        self._callback = CALLBACK(self._render)
        self.callback_address = ctypes.cast(self._callback, ctypes.c_void_p).value

    def _render(self, _input, out, frames, _time, _flags, userdata):
        samples = np.ctypeslib.as_array(ctypes.cast(out, ctypes.POINTER(ctypes.c_float)), (frames, self.channels))
        samples[:] = (self.frame + np.arange(frames))[:, None] / 1000.0
        self.userdata_seen.add(userdata)
        self.frame += frames
        self.blocks += 1
        return self.result

    def send(self, frame, status, data1, data2):
        if len(self.sent) >= self.capacity:
            return False
        self.sent.append((frame, status, data1, data2))
        return True
