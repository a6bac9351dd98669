"""The instrument as a thing that can be run: a guitar and a sample rate enter, blocks of samples leave.

An `Engine` owns the arrays of one instance and calls one compiled C function on them; live, the audio driver calls the
same function on the same arrays. It knows no clock and no device.
"""

import ctypes
import time

import numpy as np

from ukrt.engine import layout as at
from ukrt.engine.discretize import aligned, fill_instance, make_arrays
from ukrt.engine.kernels.convolve import convolver_prepare, convolver_reset, convolver_size
from ukrt.engine.kernels.energy import total_energy
from ukrt.engine.kernels.machine import ticks_now
from ukrt.engine.kernels.player import player_reset
from ukrt.engine.kernels.process import callback
from ukrt.engine.note_log import read_counters, read_note_log
from ukrt.engine.player_tables import make_player_tables
from ukrt.errors import ParameterError
from ukrt.model.intonation import make_intonation
from ukrt.radiation.impulse_response import load_impulse_response

SIGNALS = {"pressure": at.SIGNAL_PRESSURE, "bridge-force": at.SIGNAL_FORCE, "strings": at.SIGNAL_STRINGS}
MAX_BLOCK = 8192
_SILENCE = np.zeros((1, 2, 2))
_POINTER, _ULONG = ctypes.c_void_p, ctypes.c_ulong
CALLBACK = ctypes.CFUNCTYPE(ctypes.c_int, _POINTER, _POINTER, _ULONG, _POINTER, _ULONG, _POINTER)  # PaStreamCallback


class Engine:
    """One instance of the instrument.

    Parameters
    ----------
    guitar : ukrt.model.parameters.Guitar
    sample_rate : float [Hz]
        From 44100 to 192000.
    signal : {"pressure", "bridge-force", "strings"}
        Stereo pressure [Pa], the force on the bridge [N], or one channel per string's share of it [N].
    impulse_response : ukrt.radiation.impulse_response.ImpulseResponse, optional
        Instead of the one that the guitar names.
    max_block : int
        Most frames that `process` takes at once.

    Raises
    ------
    ParameterError
        A value out of range.
    ImpulseResponseError
        An impulse response that cannot be used.
    """

    def __init__(self, guitar, sample_rate=48000.0, *, signal="pressure", impulse_response=None, max_block=MAX_BLOCK):
        if signal not in SIGNALS:
            raise ParameterError("signal", signal, f"it must be one of {', '.join(SIGNALS)}")
        self.guitar, self.sample_rate, self.signal = guitar, float(sample_rate), signal
        self.max_block = max_block
        self.channels = {"pressure": 2, "bridge-force": 1, "strings": len(guitar.strings)}[signal]
        self.intonation = make_intonation(guitar)
        self._d, self._i = make_arrays()
        fill_instance(self._d, self._i, guitar, self.intonation, self.sample_rate)
        response = _SILENCE
        if signal == "pressure":
            impulse_response = impulse_response or load_impulse_response(
                guitar.radiation.impulse_response, self.sample_rate
            )
            response = impulse_response.samples
        self.response_frames = len(response) if signal == "pressure" else 0
        n_v, n_vi = convolver_size(len(response))
        self._v, self._vi = aligned(n_v, np.float64), aligned(n_vi, np.int64)
        convolver_prepare(response, self._v, self._vi)
        self._buffer = aligned(max_block * self.channels, np.float64)
        self.lead_frames = max(1, round(guitar.pluck.duration * self.sample_rate))
        self._finish()
        self._words = self._make_instance()
        self._address = self._words.ctypes.data
        self._function = CALLBACK(callback.address)

    def _finish(self):
        """What an instance at rest needs beside its physics: player, output, the counters' rates."""
        i = self._i
        i[at.H_SIGNAL], i[at.H_CHANNELS] = SIGNALS[self.signal], self.channels
        i[at.H_CONVOLVE] = self.signal == "pressure"
        self._d[at.METER + at.M_GAIN] = 1.0
        player_reset(self._d, i)
        make_player_tables(self.guitar, self.intonation, self.sample_rate, self._d, i)
        self._d[at.METER + at.M_TICKS_PER_FRAME] = tick_rate() / self.sample_rate

    def _make_instance(self):
        words = np.zeros(at.INSTANCE_WORDS, np.int64)
        words[at.W_MAGIC], words[at.W_VERSION] = at.MAGIC, at.VERSION
        for word, array in (
            (at.W_D, self._d),
            (at.W_I, self._i),
            (at.W_V, self._v),
            (at.W_VI, self._vi),
            (at.W_OUT, self._buffer),
        ):
            words[word], words[word + 1] = array.ctypes.data, array.size
        return words

    @property
    def callback_address(self):
        """Address of the C function with PortAudio's callback signature (int)."""
        return callback.address

    @property
    def userdata_address(self):
        """Address of this instance's table of words, the callback's user data (int); valid while the engine lives."""
        return self._address

    @property
    def frame(self):
        """The next frame to be computed (int)."""
        return int(self._i[at.H_FRAME])

    @property
    def n_modes(self):
        """Modes of strings (both polarizations) and body, without the pseudo-modes (int)."""
        rows = (at.STRING_I + s * at.STRING_I_SIZE for s in range(len(self.guitar.strings)))
        return int(sum(2 * self._i[row + at.SI_MODES] for row in rows)) + len(self.guitar.body.frequencies_hz)

    @property
    def output_gain(self):
        """Gain of what the callback gives to a sound card [1]; `process` is not affected."""
        return float(self._d[at.METER + at.M_GAIN])

    @output_gain.setter
    def output_gain(self, gain):
        self._d[at.METER + at.M_GAIN] = gain

    def send(self, frame, status, data1=0, data2=0):
        """Queue a MIDI message for ``frame``; frames must not decrease.

        Returns
        -------
        bool
            False if the queue is full; the message is then lost and counted.
        """
        i = self._i
        write = i[at.H_MIDI_WRITE]
        if write - i[at.H_MIDI_READ] >= at.MIDI_QUEUE:
            i[at.H_MIDI_DROPPED] += 1
            return False
        slot = at.MIDI + 2 * (write % at.MIDI_QUEUE)
        i[slot], i[slot + 1] = frame, (status & 0xFF) << 16 | (data1 & 0xFF) << 8 | data2 & 0xFF
        i[at.H_MIDI_WRITE] = write + 1  # last: the callback reads up to here
        return True

    def process(self, n_frames):
        """Compute the next ``n_frames`` frames.

        Returns
        -------
        ndarray (n_frames, channels) float64 [Pa] or [N]
        """
        out = np.empty((n_frames, self.channels))
        self.process_into(out)
        return out

    def process_into(self, out):
        """Compute the next frames into ``out``, a C-contiguous float64 array (n, channels)."""
        if out.dtype != np.float64 or not out.flags.c_contiguous or out.shape[1:] != (self.channels,):
            words = f"it must be C-contiguous float64 (n, {self.channels})"
            raise ParameterError("out", f"{out.dtype} {out.shape}", words)
        if len(out):
            address = out.__array_interface__["data"][0]  # ten times quicker than out.ctypes
            self._function(None, address, len(out), None, at.DOUBLE_OUTPUT, self._address)

    def energy(self):
        """Energy of strings, body and fingers [J]: what still sounds."""
        return float(total_energy(self._d, self._i))

    def counters(self):
        """Everything that was counted since the start or the last reset.

        Returns
        -------
        dict
            Numbers by name; ``load_histogram`` is a list of (share of the block's period, blocks).
        """
        i = self._i
        heads = {
            "frames": at.H_FRAME,
            "blocks": at.H_BLOCKS,
            "midi_received": at.H_MIDI_COUNT,
            "midi_dropped": at.H_MIDI_DROPPED,
            "late_messages": at.H_MIDI_LATE,
            "gestures_executed": at.H_GESTURES_DONE,
            "gestures_dropped": at.H_GESTURES_DROPPED,
            "nonfinite_resets": at.H_NONFINITE,
            "underflows": at.H_UNDERFLOWS,
            "overflows": at.H_OVERFLOWS,
            "clipped_samples": at.H_CLIPPED,
        }
        counts = {name: int(i[place]) for name, place in heads.items()}
        bins = i[at.LOAD : at.LOAD + at.LOAD_BINS]
        loads = [(2.0 ** ((k + 0.5 - at.LOAD_FULL) / at.LOAD_PER_OCTAVE), int(bins[k])) for k in np.flatnonzero(bins)]
        return counts | {"peak": float(self._d[at.METER + at.M_PEAK])} | read_counters(i) | {"load_histogram": loads}

    def note_log(self):
        """The notes so far, oldest first: see `ukrt.engine.note_log.read_note_log`."""
        return read_note_log(self._d, self._i, self.sample_rate)

    def reset(self):
        """All strings at rest, no note held, no message waiting, frame 0."""
        gain = self.output_gain
        fill_instance(self._d, self._i, self.guitar, self.intonation, self.sample_rate)
        convolver_reset(self._v, self._vi)
        self._finish()
        self.output_gain = gain

    def close(self):
        """Let go of the memory; call it only after the driver has stopped calling."""
        self._words[at.W_MAGIC] = 0


_tick_rate = None


def tick_rate(seconds=0.02):
    """Ticks per second of the counter that measures the callback's load [1/s]; 0 where there is none. Measured once."""
    global _tick_rate
    if _tick_rate is None:
        began, first = time.perf_counter(), ticks_now()
        time.sleep(seconds)
        _tick_rate = (ticks_now() - first) / (time.perf_counter() - began)
    return _tick_rate
