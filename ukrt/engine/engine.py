"""The instrument as a thing that can be run: a guitar and a sample rate enter, blocks of samples leave.

An `Engine` owns a stage and the one or two instances on it, and calls one compiled C function on them; live, the audio
driver calls the same function on the same arrays, in this process or in another. It knows no clock and no device.
"""

import ctypes

import numpy as np

from ukrt.engine import layout as instance_at
from ukrt.engine import stage_layout as at
from ukrt.engine.callback_type import CALLBACK
from ukrt.engine.compiled import lane_push, total_energy
from ukrt.engine.host import Host
from ukrt.engine.instance import Instance
from ukrt.engine.note_log import count_logged, read_note_log
from ukrt.engine.slots import Slots
from ukrt.engine.stage import Stage
from ukrt.errors import ParameterError


class Engine:
    """An instrument that can be run.

    Parameters
    ----------
    guitar : ukrt.model.parameters.Guitar
    sample_rate : float [Hz]
        From 44100 to 192000.
    signal : {"pressure", "bridge-force", "strings"}
        Stereo pressure [Pa], the force on the bridge [N], or one channel per string's share of it [N].
    impulse_response : ukrt.radiation.impulse_response.ImpulseResponse, optional
        Instead of the one that the guitar names.
    shared : bool
        Whether other processes shall be able to run it, and its output is kept for a recorder: live playing.

    Raises
    ------
    ParameterError
        A value out of range.
    ImpulseResponseError
        An impulse response that cannot be used.
    """

    def __init__(self, guitar, sample_rate=48000.0, *, signal="pressure", impulse_response=None, shared=False):
        self.signal, self.shared = signal, shared
        instance = Instance(guitar, sample_rate, signal, impulse_response, shared)
        self.channels = instance.channels
        self._stage = Stage(self.channels, shared)
        self._stage.reset(instance.sample_rate)
        self._si = self._stage.si
        self._host = Host(self._stage.arrays)
        self._slots = Slots(self._stage, self._host, instance)
        self._address = self._host.userdata_address
        self._function = CALLBACK(self._host.callback_address)

    # What is being played --------------------------------------------------------------------------------------------
    @property
    def instance(self):
        """The instance that is heard (Instance)."""
        return self._slots.heard

    @property
    def guitar(self):
        """The guitar that is heard (Guitar)."""
        return self.instance.guitar

    @property
    def sample_rate(self):
        """Frames per second [Hz]."""
        return self.instance.sample_rate

    @property
    def intonation(self):
        """Tensions and fret places of the guitar that is heard (Intonation)."""
        return self.instance.intonation

    @property
    def lead_frames(self):
        """Frames from a note-on to the release of its string (int)."""
        return self.instance.lead_frames

    @property
    def response_frames(self):
        """Frames for which the sound outlasts its cause (int)."""
        return self.instance.response_frames

    @property
    def n_modes(self):
        """Modes of strings (both polarizations) and body, without the pseudo-modes (int)."""
        return self.instance.n_modes

    @property
    def frame(self):
        """The next frame to be computed (int)."""
        return int(self._si[at.G_FRAME])

    @property
    def output_gain(self):
        """Gain of what goes to a sound card [1]; `process` is not affected."""
        return float(self._d[instance_at.METER + instance_at.M_GAIN])

    @output_gain.setter
    def output_gain(self, gain):
        self._d[instance_at.METER + instance_at.M_GAIN] = gain

    _d = property(lambda self: self.instance.d)
    _i = property(lambda self: self.instance.i)
    _v = property(lambda self: self.instance.v)
    _vi = property(lambda self: self.instance.vi)

    # Messages --------------------------------------------------------------------------------------------------------
    def send(self, frame, status, data1=0, data2=0, lane=at.LANE_PLAYER):
        """Queue a MIDI message for ``frame`` (AT_ONCE: for the next block); frames of one lane must not decrease.

        Returns
        -------
        bool
            False if the lane refuses it because it is full; the message is then lost and counted.
        """
        word = (status & 0xFF) << 16 | (data1 & 0xFF) << 8 | data2 & 0xFF
        return bool(lane_push(self._si, lane, frame, word))

    def send_event(self, frame, kind, value, lane=at.LANE_PLAYER):
        """Queue one of the stage's own events (KIND_SHED; KIND_RESET of some frames), as `journal` gave them; see
        `send`."""
        return bool(lane_push(self._si, lane, frame, kind << at.KIND_SHIFT | value & at.VALUE_MASK))

    def recover(self, torn=False):
        """Let everything come to rest at the next block if a host died within the callback; True if one did.

        Only when nobody calls the callback any more.

        Parameters
        ----------
        torn : bool
            That one did is known (from a take).
        """
        torn = torn or bool(self._si[at.G_BUSY])
        if torn:
            self._si[at.G_BUSY], self._si[at.G_TORN] = 0, 1
            self._stage.fill_ring()
        self._si[at.G_THREAD] = 0
        return torn

    # Another guitar while playing ------------------------------------------------------------------------------------
    @property
    def swapping(self):
        """See `Slots.swapping`."""
        return self._slots.swapping

    def load(self, instance, gain=None):
        """See `Slots.load`."""
        self._slots.load(instance, gain)

    def swap(self, frame=at.AT_ONCE):
        """See `Slots.swap`."""
        return self._slots.swap(frame)

    # Sound -----------------------------------------------------------------------------------------------------------
    @property
    def callback_address(self):
        """Address of the C function with PortAudio's callback signature (int)."""
        return self._host.callback_address

    @property
    def userdata_address(self):
        """Address of this process's table of words, the callback's user data (int); valid while the engine lives."""
        return self._address

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
        """Compute the next frames into ``out``, a writable C-contiguous float64 array (n, channels)."""
        if out.dtype != np.float64 or not out.flags.carray or out.shape[1:] != (self.channels,):
            words = f"it must be writable C-contiguous float64 (n, {self.channels})"
            raise ParameterError("out", f"{out.dtype} {out.shape}", words)
        if len(out):
            address = ctypes.addressof(ctypes.c_char.from_buffer(out))  # five times quicker than NumPy's own ways
            self._function(None, address, len(out), None, at.DOUBLE_OUTPUT, self._address)

    def process_card(self, n_frames):
        """Compute the next ``n_frames`` frames as a sound card gets them: with gain and limiter.

        Returns
        -------
        ndarray (n_frames, channels) float32
        """
        out = np.empty((n_frames, self.channels), np.float32)
        if n_frames:
            self._function(None, out.__array_interface__["data"][0], n_frames, None, 0, self._address)
        return out

    # What the stage tells, and is told -------------------------------------------------------------------------------
    @property
    def stage(self):
        """The stage: stamps, journal, ring of samples, settings (Stage)."""
        return self._stage

    def stamp(self):
        """See `Stage.stamp`."""
        return self._stage.stamp()

    def journal(self, since):
        """See `Stage.journal`."""
        return self._stage.journal(since)

    def recorded(self, since):
        """See `Stage.recorded`."""
        return self._stage.recorded(since)

    def settings(self):
        """All that a take must keep beside the guitar (dict, ready for JSON)."""
        return self._stage.settings() | {"output_gain": self.output_gain}

    def apply(self, settings):
        """Take over what `settings` gave."""
        self._stage.apply(settings)
        self.output_gain = settings["output_gain"]

    limiter = property(
        lambda self: self._stage.limiter, lambda self, on: setattr(self._stage, "limiter", on), doc="See `Stage`."
    )
    message_cap = property(
        lambda self: self._stage.message_cap,
        lambda self, cap: setattr(self._stage, "message_cap", cap),
        doc="See `Stage`.",
    )
    shed_budget = property(
        lambda self: self._stage.shed_budget,
        lambda self, load: setattr(self._stage, "shed_budget", load),
        doc="See `Stage`.",
    )

    def peak_recent(self):
        """See `Stage.peak_recent`."""
        return self._stage.peak_recent()

    def energy(self):
        """Energy of strings, body and fingers [J]: what still sounds."""
        return float(total_energy(self._d, self._i))

    def counters(self):
        """Everything that was counted since the start or the last reset: see `Stage.counters`."""
        return self._stage.counters(self._i)

    @property
    def notes_logged(self):
        """How many notes there have been in the log, those that it holds no more included (int)."""
        return count_logged(self._i)

    def note_log(self):
        """The notes so far, oldest first: see `ukrt.engine.note_log.read_note_log`."""
        return read_note_log(self._d, self._i, self.sample_rate)

    def manifest(self):
        """What another process needs to run this engine (dict, ready for JSON); only of a shared one."""
        return {
            "stage": self._stage.block.manifest(),
            "slots": self._slots.manifest(),
            "sample_rate": self.sample_rate,
            "channels": self.channels,
        }

    def reset(self):
        """All strings at rest, no note held, no message waiting, frame 0; counters at zero."""
        gain, sample_rate = self.output_gain, self.sample_rate
        self._slots.reset()
        self._stage.reset(sample_rate)
        self.output_gain = gain

    def close(self):
        """Give the memory back; what was counted can still be read. Only after the driver has stopped calling."""
        self._host.close()
        self._slots.close()
        self._si = None
        self._stage.close()
        self._si = self._stage.si
