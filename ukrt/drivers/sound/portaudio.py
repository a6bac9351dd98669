"""Sound cards through PortAudio: an engine enters, its compiled callback is handed to PortAudio, sound leaves.

No Python runs in the audio thread: PortAudio is given the C function at ``engine.callback_address`` and the state at
``engine.userdata_address``. Both are kept alive here until closing the stream has returned, because PortAudio may call
the function until then, whatever became of the Python objects. PortAudio does not survive the death of a sound server
and never looks at the devices again: while playing it belongs in a process of its own (`audio_process`).
"""

import math
import sys
import threading
from dataclasses import dataclass

from ukrt.drivers.quiet import quiet_stderr
from ukrt.drivers.sound.claims import claim, release
from ukrt.errors import DeviceError, MissingExtraError

RATES = (8000.0, 768000.0)  # Hz: what any sound card has
MOST_FRAMES = 65536  # in a block: more is a mistake, and PortAudio allocates whatever it is told
MOST_SECONDS = 10.0  # of latency
MOST_CHANNELS = 256  # of a card
_OPEN = {}  # stream -> engine and host: everything that PortAudio may still call, whoever else has let go of it
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


def list_outputs(host_api=None):
    """All audio outputs (list of `OutputDevice`), empty where there is no sound card; with ``host_api``, a part of a
    host API's name such as ``"alsa"``, only those."""
    sounddevice = _portaudio()
    apis = sounddevice.query_hostapis()
    defaults = [api["default_output_device"] for api in apis if _is_meant(api["name"], host_api)]
    default = sounddevice.default.device[1]
    if default not in defaults:  # no host API says which; then the first API's own default counts
        default = next((d for d in defaults if d >= 0), -1)
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
        if d["max_output_channels"] > 0 and _is_meant(apis[d["hostapi"]]["name"], host_api)
    ]


def _is_meant(name, part):
    return part is None or part.casefold() in name.casefold()


def find_output(wanted=None, host_api=None):
    """The output with the index or the part of a name ``wanted``, else the default one; None where there is none.

    Raises
    ------
    DeviceError
        If ``wanted`` or ``host_api`` is given and no output fits, or more than one fits ``wanted``.
    """
    outputs = list_outputs(host_api)
    if not outputs and host_api is not None:
        names = sorted({o.host_api for o in list_outputs()})
        raise DeviceError(f"no audio output has the host API {host_api!r}; there is {', '.join(names) or 'none'}")
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


def choose_rate(device, wanted=None, channels=2, preferred=48000.0):
    """The sample rate [Hz] to open ``device`` at: ``wanted``, else ``preferred`` where it can, else its own."""
    if wanted is not None:
        check_settings(wanted)
        return float(wanted)
    sounddevice = _portaudio()
    try:
        with quiet_stderr():
            sounddevice.check_output_settings(
                device.index, min(channels, device.channels), "float32", samplerate=float(preferred)
            )
    except sounddevice.PortAudioError:
        return float(device.sample_rate)
    return float(preferred)


def check_settings(sample_rate=48000.0, block_size=None, latency="low", channels=None):
    """Refuse what PortAudio would take without a word, or die of: no number, or a number out of all proportion."""
    low, high = RATES
    if not _is_number(sample_rate) or not low <= sample_rate <= high:
        raise DeviceError(f"a sample rate of {sample_rate} is not possible; it must be from {low:g} to {high:g} Hz")
    if block_size is not None and (
        not _is_number(block_size) or block_size != int(block_size) or not 0 <= block_size <= MOST_FRAMES
    ):
        words = f"0, which leaves it to the device, or a whole number to {MOST_FRAMES} frames"
        raise DeviceError(f"a block size of {block_size} is not possible; it must be {words}")
    if latency not in ("low", "high") and not (_is_number(latency) and 0.0 <= latency <= MOST_SECONDS):
        raise DeviceError(
            f"a latency of {latency!r} is not possible; it must be 'low', 'high' or 0 to {MOST_SECONDS:g} s"
        )

    if channels is not None and channels not in range(1, MOST_CHANNELS + 1):
        raise DeviceError(f"{channels} channels are not possible; it must be a whole number from 1 to {MOST_CHANNELS}")


def _is_number(value):
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


class AudioOutput:
    """A running sound card that plays an engine.

    Parameters
    ----------
    engine : Engine or Attached
        Gives ``callback_address`` and ``userdata_address``; the callback writes ``engine.channels`` interleaved ones.
    device : OutputDevice
    block_size : int, optional
        Frames per callback; 0 lets the host decide, which is JACK's way and the default there, elsewhere 128.
    latency : {"low", "high"} or float [s]
        What is asked of PortAudio; what comes of it is the attribute ``latency``.
    sample_rate : float [Hz], optional
        By default the engine's.
    channels : int, optional
        How many of the card's channels to open; by default the engine's, or fewer where the card has no more. See
        `spread` for what is heard on which.
    """

    def __init__(self, engine, device, block_size=None, *, latency="low", sample_rate=None, channels=None):
        sample_rate = engine.sample_rate if sample_rate is None else sample_rate
        check_settings(sample_rate, block_size, latency, channels)
        channels = min(engine.channels, device.channels) if channels is None else channels
        sounddevice = _portaudio()
        import cffi

        ffi = cffi.FFI()
        if block_size is None:
            block_size = 0 if "jack" in device.host_api.lower() else 128
        if channels > device.channels:
            words = f"the audio output {device.name!r} has {device.channels} channels, {channels} were asked for"
            raise DeviceError(words)
        host = engine
        if channels != engine.channels:
            from ukrt.drivers.sound.spread import Spread

            host = Spread(engine, channels)
        try:
            with quiet_stderr():
                self._stream = sounddevice._StreamBase(
                    kind="output",
                    device=device.index,
                    channels=channels,
                    dtype="float32",
                    samplerate=sample_rate,
                    blocksize=int(block_size),
                    latency=latency,
                    callback=ffi.cast("void *", host.callback_address),
                    userdata=ffi.cast("void *", host.userdata_address),
                )
        except sounddevice.PortAudioError as error:
            asked = f"{sample_rate:.0f} Hz, {channels} channels, blocks of {block_size or 'any number of'} frames"
            raise DeviceError(_refusal(device, asked, error)) from error
        self._engine = engine
        _OPEN[self._stream] = engine, host
        self.name = f"{device.name} ({device.host_api})"
        self.block_size = int(block_size)
        self.sample_rate = float(self._stream.samplerate)
        self.latency = float(self._stream.latency)

    def start(self):
        """Let PortAudio call the engine from now on."""
        claim(self._engine, self)
        self._stream.start()

    @property
    def running(self):
        """Whether PortAudio says that it goes on calling."""
        return self._stream.active

    def xruns(self):
        """None of its own: PortAudio's flags are counted by the engine (int)."""
        return 0

    def refresh(self):
        """Nothing to do: this output shares the engine's memory and reads it anew at every block."""

    def close(self):
        """Stop and close; False if PortAudio does not come back, as happens when an audio server died.

        In that case nothing of PortAudio may be called again in this process, and what it may still call stays alive.
        """
        done = threading.Event()

        def stop_and_close():
            # An unplugged card makes stop complain; the stream must be closed all the same.
            self._stream.stop(ignore_errors=True)
            self._stream.close(ignore_errors=True)
            _OPEN.pop(self._stream, None)
            release(self._engine, self)
            done.set()

        threading.Thread(target=stop_and_close, name="ukrt-close", daemon=True).start()
        return done.wait(_CLOSE_SECONDS)


def leave():
    """Let go of all sound systems, as their servers expect: one whose client just vanishes waits for it, seconds long.

    Where a server has died this may never return.
    """
    if (sounddevice := sys.modules.get("sounddevice")) is not None:
        with quiet_stderr():
            sounddevice._terminate()


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


def _refusal(device, asked, error):
    """One sentence about why PortAudio would not open a stream, with what would be legal where that is known."""
    reason = str(error.args[0]).split(":", 1)[-1].strip() if error.args else "no reason given"
    hint = ""
    if "sample rate" in reason.lower():
        hint = f"; its own rate is {device.sample_rate:.0f} Hz (--rate {device.sample_rate:.0f})"
    return f"the audio output {device.name!r} refuses {asked}: {reason}{hint}"
