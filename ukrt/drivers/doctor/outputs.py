"""Outputs that a measurement opens again and again: a driver's name enters, outputs at the asked block sizes leave.

All run in this process, so that whatever disturbs its Python is as near to the audio thread as it can be.
"""

import contextlib

from ukrt.drivers.doctor.sources import Empty, Interpreted, PythonStream
from ukrt.drivers.quiet import quiet_stderr
from ukrt.drivers.sound import null
from ukrt.drivers.sound import portaudio as audio
from ukrt.errors import DeviceError, MissingExtraError

_CLIENT = "ukrt-doctor"


class PortAudioOutputs:
    """The default sound card; where that is JACK, blocks are the server's periods.

    ``realtime`` of all outputs: whether the audio server runs with real-time priority (None: there is no server).

    Parameters
    ----------
    device : ukrt.drivers.sound.portaudio.OutputDevice
    rate : float [Hz], optional
    """

    driver = "portaudio"

    def __init__(self, device, rate=None):
        self._device = device
        self._jack = "jack" in device.host_api.lower()
        self.name = f"{device.name} ({device.host_api})"
        self.sample_rate = audio.choose_rate(device, rate)
        self.realtime = _is_realtime() if self._jack else None

    def blocks(self, asked, usual):
        """The block sizes to measure (list of int; 0: whatever comes), from those asked for, and a sentence or None."""
        return _server_blocks(asked) if self._jack else (list(asked or usual), None)

    def at(self, block):
        """A context in which the server runs at ``block`` frames, where it is a matter of the server."""
        return _jack_period(block) if self._jack and block else contextlib.nullcontext()

    def open(self, source, block):
        """An output for ``source`` that has not been started."""
        size = 0 if self._jack else block
        if isinstance(source, Interpreted):
            return PythonStream(source, self._device, size)
        return audio.AudioOutput(source, self._device, size)


class JackOutputs:
    """A JACK server that our own client joins."""

    driver = "jack"

    def __init__(self, rate=None):
        with _jack_client() as client:
            self.sample_rate, self.realtime = float(client.samplerate), bool(client.realtime)
        if rate is not None and float(rate) != self.sample_rate:
            raise DeviceError(f"the JACK server runs at {self.sample_rate:.0f} Hz, not {rate} (leave out --rate)")
        self.name = "the JACK server"

    def blocks(self, asked, usual):
        """As `PortAudioOutputs.blocks`."""
        return _server_blocks(asked)

    def at(self, block):
        """As `PortAudioOutputs.at`."""
        return _jack_period(block) if block else contextlib.nullcontext()

    def open(self, source, block):
        """An output for ``source`` that has not been started."""
        from ukrt.drivers.jack.client import JackOutput

        output = JackOutput(source, _CLIENT, midi=False, midi_inputs=0, silent=isinstance(source, Empty))
        if isinstance(source, Empty):
            source.follow(output.counts)
        return output


class NullOutputs:
    """A clock instead of a sound card."""

    driver = "null"
    name = "the null output (a clock in Python instead of a sound card)"
    realtime = None

    def __init__(self, rate=None):
        self.sample_rate = float(rate or 48000)

    def blocks(self, asked, usual):
        """As `PortAudioOutputs.blocks`."""
        return list(asked or usual), None

    def at(self, block):
        """Nothing to prepare."""
        return contextlib.nullcontext()

    def open(self, source, block):
        """An output for ``source`` that has not been started."""
        return null.NullOutput(source, block, silent=True)


def find_outputs(driver=None, rate=None):
    """The outputs to measure (one of the classes above), and a sentence about what was chosen or None.

    Parameters
    ----------
    driver : {"portaudio", "jack", "null"}, optional
        By default the sound card, or the null output where there is none.
    """
    if driver == "null":
        return NullOutputs(rate), None
    if driver == "jack":
        return JackOutputs(rate), None
    try:
        device = audio.find_output()
    except (DeviceError, MissingExtraError) as error:  # PortAudio itself is missing
        if driver is not None:
            raise
        return NullOutputs(rate), f"{error}; measuring the null output instead"
    if device is not None:
        return PortAudioOutputs(device, rate), None
    if driver is not None:
        raise DeviceError("there is no audio output to be measured (--driver null measures without one)")
    return NullOutputs(rate), "there is no sound card and no audio server; measuring the null output instead"


def _server_blocks(asked):
    """The periods to measure a JACK server at: its own, unless others are asked for."""
    try:
        with _jack_client() as client:
            own = int(client.blocksize)
    except MissingExtraError:
        return [0], "without JACK-Client (pip install 'ukrt[jack]') only the server's own period is measured"
    return list(asked or [own]), None


def _is_realtime():
    """Whether the JACK server runs with real-time priority (bool); None where nobody can be asked."""
    with contextlib.suppress(MissingExtraError), _jack_client() as client:
        return bool(client.realtime)
    return None


@contextlib.contextmanager
def _jack_period(block):
    """Change the server's period to ``block`` frames, and back again."""
    with _jack_client() as client:
        before = client.blocksize
        if before == block:
            yield
            return
        client.blocksize = block
    try:
        yield
    finally:
        with contextlib.suppress(DeviceError), _jack_client() as client:
            client.blocksize = before


@contextlib.contextmanager
def _jack_client():
    """A client of the JACK server for a moment."""
    try:
        import jack
    except (ImportError, OSError) as error:
        raise MissingExtraError("JACK's own driver needs JACK-Client: pip install 'ukrt[jack]'") from error
    try:
        with quiet_stderr():
            client = jack.Client(_CLIENT, no_start_server=True)
    except jack.JackOpenError as error:
        raise DeviceError("there is no JACK server to join (start one, such as: jackd -d alsa)") from error
    try:
        yield client
    finally:
        client.close()
