"""The guitar as plugin hosts know instruments: notes and controllers enter, blocks of samples leave.

>>> import ukrt
>>> synth = ukrt.Synth("classical", sample_rate=48000, block_size=256)
>>> synth.note_on(64, 90)
>>> synth.process(256).shape
(256, 2)
"""

import numbers

from .drivers.midi.stream import MidiStream
from .errors import ParameterError, UkrtError
from .model.presets import load_preset
from .units import db_to_gain

MAX_BLOCK = 8192


class Synth:
    """One guitar that is played by calls.

    Parameters
    ----------
    preset : str, path-like or Guitar
        A preset's name, a TOML file, or a guitar.
    sample_rate : float [Hz]
    block_size : int
        Frames that `process` computes when it is not told how many. Sound does not depend on it.
    signal : {"pressure", "bridge-force", "strings"}
        Stereo sound, the bridge's force [N], or each string's share of it [N]. ``pressure`` comes with the preset's
        gain, so that normal playing peaks near -12 dBFS.
    overrides : dict, optional
        Dotted preset keys and their values, as ``--set`` takes them: ``{"pluck.place": 0.85}``.

    Notes
    -----
    An event without ``frame`` acts at the next frame to be computed. With ``frame`` it acts at that absolute frame;
    frames must not decrease from event to event. The string is released a constant ``latency`` frames after its event,
    which is the time the plucking finger pulls.
    """

    def __init__(self, preset="classical", sample_rate=48000, block_size=512, *, signal="pressure", overrides=None):
        self.block_size = _whole("block_size", block_size, 1, MAX_BLOCK)
        guitar = load_preset(preset, overrides) if isinstance(preset, str) or hasattr(preset, "__fspath__") else preset
        from .engine.engine import Engine

        self._engine = Engine(guitar, float(sample_rate), signal=signal)
        self._gain = db_to_gain(guitar.radiation.gain_db) if signal == "pressure" else 1.0
        self._last_frame = 0

    @property
    def guitar(self):
        """The guitar that is played (Guitar)."""
        return self._engine.guitar

    @property
    def sample_rate(self):
        """Sample rate [Hz]."""
        return self._engine.sample_rate

    @property
    def channels(self):
        """Channels of what `process` returns."""
        return self._engine.channels

    @property
    def frame(self):
        """The next frame to be computed, counted from the first one ever (int)."""
        return self._engine.frame

    @property
    def latency(self):
        """Frames from an event to the release of its string (int)."""
        return self._engine.lead_frames

    def note_on(self, note, velocity, channel=0, frame=None):
        """Pluck MIDI note ``note`` (0 to 127) with ``velocity`` (0 to 127; 0 is a note-off)."""
        self._send(0x90, channel, _whole("note", note, 0, 127), _whole("velocity", velocity, 0, 127), frame)

    def note_off(self, note, channel=0, frame=None):
        """End MIDI note ``note``: a finger damps its string, unless the pedal holds it."""
        self._send(0x80, channel, _whole("note", note, 0, 127), 0, frame)

    def control_change(self, controller, value, channel=0, frame=None):
        """Set controller ``controller`` (0 to 127) to ``value`` (0 to 127), such as 64, the sustain pedal."""
        self._send(0xB0, channel, _whole("controller", controller, 0, 127), _whole("value", value, 0, 127), frame)

    def articulate(self, channel=0, frame=None, **controls):
        """Say how notes to come are played, by names: ``articulate(attack=20, release=0, strum_direction=127)``.

        Names are those that controllers are learned by (``ukrt.engine.controller_names``, with ``_`` for ``-``), values
        (0 to 127) those of the table of controllers in ``ukrt/playing/README.md``.
        """
        from .engine.controller_names import FUNCTIONS

        numbers = {name.replace("-", "_"): number for name, number in FUNCTIONS.items()}
        for name, value in controls.items():
            if name not in numbers:
                raise ParameterError(name, value, f"no such control exists; there are {', '.join(numbers)}")
            _whole(name, value, 0, 127)
        for name, value in controls.items():
            self.control_change(numbers[name], value, channel, frame)

    def pitch_bend(self, bend, channel=0, frame=None):
        """Bend by ``bend``, from -8192 to 8191 of 8192 parts of the bend range."""
        position = _whole("bend", bend, -8192, 8191) + 8192
        self._send(0xE0, channel, position & 0x7F, position >> 7, frame)

    def sysex(self, data, frame=None):
        """Send a whole SysEx message, ``data`` (bytes) from F0 to F7: tunings, master volume, General MIDI's reset."""
        data = bytes(data)
        if len(data) < 2 or data[0] != 0xF0 or data[-1] != 0xF7 or max(data[1:-1], default=0) > 0x7F:
            words = "it must begin with F0, end with F7, and be below 80 between"
            raise ParameterError("data", data.hex(" ")[:40], words)
        for status, data1, data2 in MidiStream().feed(data):
            self._send(status, 0, data1, data2, frame)

    def process(self, n=None):
        """Compute the next ``n`` frames (default ``block_size``).

        Returns
        -------
        ndarray (n, channels) float64
            Full scale 1.0.
        """
        n = self.block_size if n is None else _whole("n", n, 1, MAX_BLOCK)
        return self._engine.process(n) * self._gain

    def reset(self):
        """All strings at rest, no note held, frame 0."""
        self._engine.reset()
        self._last_frame = 0

    def close(self):
        """Give back the memory; the synth cannot be used afterwards."""
        self._engine.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def _send(self, status, channel, data1, data2, frame):
        channel = _whole("channel", channel, 0, 15)
        earliest = max(self._last_frame, self._engine.frame)
        frame = earliest if frame is None else _whole("frame", frame, earliest, 2**62)
        if not self._engine.send(frame, status | channel, data1, data2):
            raise UkrtError("too many events wait to be played; call process before sending more")
        self._last_frame = frame


def _whole(name, value, low, high):
    """``value`` as an int within its range, or a sentence."""
    if isinstance(value, bool) or not isinstance(value, numbers.Integral) or not low <= value <= high:
        raise ParameterError(name, value, f"it must be a whole number from {low} to {high}")
    return int(value)
