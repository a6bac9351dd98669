"""Sound cards through PortAudio: an engine enters, its compiled callback is handed to PortAudio, sound leaves.

No Python runs in the audio thread: PortAudio is given the C function at ``engine.callback_address`` and the state at
``engine.userdata_address``. Both are kept alive here until closing the stream has returned, because PortAudio may call
the function until then, whatever became of the Python objects.
"""

import threading
from dataclasses import dataclass

from ..errors import DeviceError, MissingExtraError
from .quiet import quiet_stderr

_OPEN = {}  # stream -> engine: everything that PortAudio may still call, whoever else has let go of it
_CLOSE_SECONDS = 3.0  # closing hangs for ever where an audio server died; measured closings take 0.05 s


@dataclass(frozen=True)
class OutputDevice:
    """One audio output of this machine."""

    index: int
    name: str
    host_api: str
    channels: int
    sample_rate: float
    is_default: bool


def list_outputs():
    """All audio outputs (list of `OutputDevice`); empty where there is no sound card."""
    sounddevice = _portaudio()
    apis = sounddevice.query_hostapis()
    default = sounddevice.default.device[1]
    if default < 0:  # no host API says which; then the first API's own default counts
        default = next((a["default_output_device"] for a in apis if a["default_output_device"] >= 0), -1)
    return [
        OutputDevice(
            d["index"],
            d["name"],
            apis[d["hostapi"]]["name"],
            d["max_output_channels"],
            d["default_samplerate"],
            d["index"] == default,
        )
        for d in sounddevice.query_devices()
        if d["max_output_channels"] > 0
    ]


def find_output(wanted=None):
    """The output with the index or the part of a name ``wanted``, else the default one; None where there is none.

    Raises
    ------
    DeviceError
        If ``wanted`` is given and no output, or more than one, fits.
    """
    outputs = list_outputs()
    if wanted is None:
        return next((o for o in outputs if o.is_default), outputs[0] if outputs else None)
    return choose(outputs, wanted, "audio output")


def choose(candidates, wanted, kind):
    """The one of ``candidates`` (with ``index`` and ``name``) that ``wanted``, an index or part of a name, means."""
    wanted = str(wanted)
    by_index = [c for c in candidates if str(c.index) == wanted]
    exact = [c for c in candidates if c.name == wanted]
    partial = [c for c in candidates if wanted.casefold() in c.name.casefold()]
    fitting = by_index or exact or partial
    if len(fitting) == 1:
        return fitting[0]
    names = ", ".join(f"{c.index} ({c.name})" for c in (fitting or candidates)) or "none on this machine"
    if fitting:
        raise DeviceError(f"the {kind} {wanted!r} is ambiguous; it fits {names}")
    raise DeviceError(f"there is no {kind} {wanted!r}; there is {names}")


def choose_rate(device, wanted=None, channels=2):
    """The sample rate [Hz] to open ``device`` at: ``wanted`` if given, else 48000 where possible, else its own."""
    if wanted is not None:
        return float(wanted)
    sounddevice = _portaudio()
    try:
        with quiet_stderr():
            sounddevice.check_output_settings(device.index, channels, "float32", samplerate=48000.0)
    except sounddevice.PortAudioError:
        return float(device.sample_rate)
    return 48000.0


class AudioOutput:
    """A running sound card that plays an engine.

    Parameters
    ----------
    engine : Engine
        Gives ``callback_address``, ``userdata_address``, ``channels`` and ``sample_rate``.
    device : OutputDevice
    block_size : int, optional
        Frames per callback; 0 lets the host decide, which is JACK's way and the default there, elsewhere 128.
    """

    def __init__(self, engine, device, block_size=None):
        sounddevice = _portaudio()
        import cffi

        ffi = cffi.FFI()
        if block_size is None:
            block_size = 0 if "jack" in device.host_api.lower() else 128
        try:
            with quiet_stderr():
                self._stream = sounddevice._StreamBase(
                    kind="output",
                    device=device.index,
                    channels=engine.channels,
                    dtype="float32",
                    samplerate=engine.sample_rate,
                    blocksize=block_size,
                    latency="low",
                    callback=ffi.cast("void *", engine.callback_address),
                    userdata=ffi.cast("void *", engine.userdata_address),
                )
        except sounddevice.PortAudioError as error:
            raise DeviceError(_refusal(device, engine, block_size, error)) from error
        _OPEN[self._stream] = engine
        self.name = f"{device.name} ({device.host_api})"
        self.block_size = block_size
        self.sample_rate = self._stream.samplerate
        self.latency = self._stream.latency

    def start(self):
        """Let PortAudio call the engine from now on."""
        self._stream.start()

    @property
    def running(self):
        """Whether PortAudio says that it goes on calling."""
        return self._stream.active

    def close(self):
        """Stop and close; False if PortAudio does not come back, as happens when an audio server died.

        In that case nothing of PortAudio may be called again in this process, and what it may still call stays alive.
        """
        done = threading.Event()

        def stop_and_close():
            self._stream.stop()
            self._stream.close()
            _OPEN.pop(self._stream, None)
            done.set()

        threading.Thread(target=stop_and_close, name="ukrt-close", daemon=True).start()
        return done.wait(_CLOSE_SECONDS)


def _portaudio():
    """The module sounddevice, or a sentence about what is missing."""
    try:
        with quiet_stderr():
            import sounddevice
    except ImportError as error:
        raise MissingExtraError("live sound needs sounddevice, which is missing: pip install 'ukrt[live]'") from error
    except OSError as error:
        raise DeviceError(
            "the PortAudio library is missing (on Debian: apt-get install libportaudio2; on macOS and Windows it comes "
            "with sounddevice)"
        ) from error
    return sounddevice


def _refusal(device, engine, block_size, error):
    """One sentence about why PortAudio would not open a stream, with what would be legal where that is known."""
    reason = str(error.args[0]).split(":", 1)[-1].strip() if error.args else "no reason given"
    hint = ""
    if "sample rate" in reason.lower():
        hint = f"; its own rate is {device.sample_rate:.0f} Hz (--rate {device.sample_rate:.0f})"
    asked = f"{engine.sample_rate:.0f} Hz, {engine.channels} channels, blocks of {block_size or 'any number of'} frames"
    return f"the audio output {device.name!r} refuses {asked}: {reason}{hint}"
