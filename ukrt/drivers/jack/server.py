"""libjack, as far as this package asks it: a server that runs is found, clients of it are opened and closed.

No server is ever started. Every call that a dead or frozen server could hold up is made in a thread of its own and
given up after a while, so that whoever asks gets an answer. Nothing that libjack prints reaches the terminal: what
matters is told in one sentence.
"""

import ctypes
import os
import threading
from dataclasses import dataclass

from ukrt.errors import DeviceError, MissingExtraError

_PATIENCE_SECONDS = 5.0  # a server that answers does so within milliseconds
_THROUGH = "midi through"  # ALSA's loop from programs to programs is no device


@dataclass(frozen=True)
class Server:
    """A JACK server that runs."""

    name: str
    sample_rate: float
    block_size: int
    realtime: bool
    outputs: tuple
    midi_sources: tuple


def load_jack():
    """The module ``jack`` of JACK-Client, or a sentence about what is missing."""
    try:
        import jack
    except ImportError as error:
        raise MissingExtraError(
            "--driver jack needs JACK-Client, which is missing: pip install 'ukrt[jack]'"
        ) from error
    except OSError as error:
        raise DeviceError(
            "the JACK library is missing (on Debian: apt-get install libjack-jackd2-0 or pipewire-jack)"
        ) from error
    _silence(jack)
    return jack


def function_address(jack, name):
    """The address of libjack's function ``name`` (int)."""
    try:
        return ctypes.cast(getattr(ctypes.CDLL(jack._libname), name), ctypes.c_void_p).value
    except AttributeError as error:
        raise DeviceError(f"the JACK library {jack._libname} has no {name}; a newer one is needed") from error


def latency_range(jack, port, mode):
    """The latency range of the port at address ``port``: capture (0) or playback (1) (least, most) [frames]."""
    function, pair = ctypes.CDLL(jack._libname).jack_port_get_latency_range, (ctypes.c_uint32 * 2)()
    function.argtypes, function.restype = [ctypes.c_void_p, ctypes.c_int, ctypes.c_void_p], None
    function(port, mode, ctypes.addressof(pair))
    return tuple(pair)


def set_callback(jack, setter, client, callback, argument):
    """Call a setter of libjack that JACK-Client does not declare, or declares otherwise; all but its name are
    addresses."""
    function = getattr(ctypes.CDLL(jack._libname), setter)
    function.argtypes, function.restype = [ctypes.c_void_p] * 3, ctypes.c_int
    return function(client, callback, argument)


def find_server():
    """The server that ``JACK_DEFAULT_SERVER`` names, or the default one (`Server`); None where none runs."""
    jack = load_jack()
    try:
        client = open_client(jack, "ukrt-look")
    except DeviceError:
        return None
    try:
        outputs = tuple(port.name for port in physical_outputs(client))
        sources = tuple(port.name for port in midi_sources(client))
        return Server(
            server_name(), float(client.samplerate), int(client.blocksize), bool(client.realtime), outputs, sources
        )
    finally:
        close_client(jack, client)


def server_rate():
    """The sample rate of the JACK server [Hz].

    Raises
    ------
    DeviceError
        Where no server runs.
    """
    jack = load_jack()
    client = open_client(jack, "ukrt-look")
    try:
        return float(client.samplerate)
    finally:
        close_client(jack, client)


def server_name():
    """The name of the server that is asked (str)."""
    return os.environ.get("JACK_DEFAULT_SERVER") or "default"


def physical_outputs(client):
    """The ports of sound cards to play to, in the server's order (list of jack.Port)."""
    return client.get_ports(is_audio=True, is_input=True, is_physical=True)


def midi_sources(client, physical=True):
    """The ports that MIDI comes from (list of jack.Port): of devices, or of all clients but ours."""
    ports = client.get_ports(is_midi=True, is_output=True, **({"is_physical": True} if physical else {}))
    return [port for port in ports if not client.owns(port) and not (physical and _THROUGH in port.name.casefold())]


def open_client(jack, name):
    """A new client of the running server, its name made unique by the server.

    Raises
    ------
    DeviceError
        Where no server runs, or it takes no client.
    """
    try:
        return patiently(
            lambda: jack.Client(name, no_start_server=True),
            f"the JACK server {server_name()!r}",
            too_late=lambda client: client.close(),
        )
    except jack.JackOpenError as error:
        status = error.status
        if status.server_failed or status.server_error:
            raise DeviceError(
                f"no JACK server {server_name()!r} answers; start one (qjackctl does, or: jackd -d alsa), or choose "
                "another driver"
            ) from error
        raise DeviceError(f"the JACK server {server_name()!r} refuses the client {name!r}: {status}") from error


def close_client(jack, client):
    """Leave the server; False if libjack does not come back, in which case the client must stay alive as it is."""
    pointer, client._ptr = client._ptr, jack._ffi.NULL  # nobody else, the garbage collector least of all, closes again
    if not pointer:
        return True

    def leave():
        jack._lib.jack_deactivate(pointer)
        jack._lib.jack_client_close(pointer)

    try:
        patiently(leave, "closing")
    except DeviceError:
        return False
    return True


def patiently(function, asked, too_late=lambda _result: None):
    """The result of ``function``, called in a thread of its own; ``too_late`` is given what comes after all.

    Raises
    ------
    DeviceError
        If it has not come back in time.
    """
    answers, lock, done = [], threading.Lock(), threading.Event()
    given_up = False

    def run():
        try:
            answer = (function(), None)
        except Exception as error:
            answer = (None, error)
        with lock:
            answers.append(answer)
            late = given_up
        done.set()
        if late and answer[1] is None:
            too_late(answer[0])

    threading.Thread(target=run, name="ukrt-jack", daemon=True).start()
    done.wait(_PATIENCE_SECONDS)
    with lock:
        given_up = not answers
    if given_up:
        raise DeviceError(f"{asked} has not answered for {_PATIENCE_SECONDS:.0f} s")
    result, failure = answers[0]
    if failure is not None:
        raise failure
    return result


def _silence(jack):
    """Let libjack say nothing; its messages are about what its return values tell already."""
    from ukrt.engine.kernels.jack_notices import say_nothing

    for setter in (jack._lib.jack_set_error_function, jack._lib.jack_set_info_function):
        setter(jack._ffi.cast("void (*)(const char *)", say_nothing.address))
