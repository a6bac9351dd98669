"""A JACK client of our own: an engine enters, sound leaves through JACK's ports, MIDI is taken in the same cycle.

Everything that JACK calls is compiled: the process callback (see kernels/jack.py) plays a cycle's MIDI events at their
frames within that same cycle, and the callbacks of JACK's other threads only note what they are told. So no Python
thread, whatever it does to the interpreter's lock, can delay sound or MIDI or hold up the server.
"""

import atexit

import numpy as np

from ukrt.drivers.jack.server import (
    close_client,
    find_server,
    function_address,
    latency_range,
    load_jack,
    open_client,
    patiently,
    server_name,
    server_rate,
    set_callback,
)
from ukrt.drivers.jack.table import FUNCTIONS, held_messages, shutdown_words
from ukrt.drivers.jack.wiring import Wiring
from ukrt.drivers.sound.claims import claim, release
from ukrt.drivers.sound.scheduling import lock_memory
from ukrt.engine import jack_layout as at
from ukrt.engine.kernels.jack import process
from ukrt.engine.kernels.jack_notices import (
    count_connection,
    count_port,
    count_up,
    note_shutdown,
    note_value,
    tell_latency,
)
from ukrt.engine.stage_layout import AT_ONCE, LANE_JACK
from ukrt.errors import DeviceError

__all__ = ["JackOutput", "find_server", "server_rate"]

_OPEN = {}  # output -> all that JACK may still call or read, whoever else has let go of it


class JackOutput:
    """A client of the running JACK server that plays an engine.

    Parameters
    ----------
    engine : Engine
        Gives ``callback_address``, ``userdata_address``, ``channels`` and ``sample_rate``, which must be the server's
        when it starts.
    name : str
        Of the client; the server makes it unique.
    connect : bool or str
        True: to the first physical outputs; False: nowhere; else to the ports whose names contain these words.
    midi : bool, str or list of str
        True: from all MIDI devices, those too that come later (as long as `tend` is called); False: from none; else
        from all MIDI ports whose names contain one of these words.
    midi_inputs : int
        Number of MIDI input ports, 0 to 8; the first is the one that is connected.
    silent : bool
        Only take part in the server's cycle and write silence: to measure the server and the machine without engine.

    Raises
    ------
    DeviceError
        No server, or ports that cannot be made.
    MissingExtraError
        Without JACK-Client.
    """

    def __init__(self, engine, name="ukrt", connect=True, midi=True, *, midi_inputs=1, silent=False):
        self._jack = load_jack()
        self._engine = engine
        self._started, self._closed = False, None
        if not 1 <= engine.channels <= at.MAX_PORTS or not 0 <= midi_inputs <= at.MAX_MIDI:
            raise DeviceError(
                f"JACK ports for {engine.channels} channels and {midi_inputs} MIDI inputs were asked for; "
                f"1 to {at.MAX_PORTS} and 0 to {at.MAX_MIDI} can be had"
            )
        self._table = np.zeros(at.TABLE_WORDS, np.int64)
        self._scratch = np.zeros(at.SCRATCH_FRAMES * engine.channels, np.float32)
        self._client = open_client(self._jack, name)
        try:
            self._register_ports(midi_inputs)
            self._fill_table(silent)
            self._set_callbacks()
            self._wiring = Wiring(self._client, self._outs, self._ins, connect, midi)
        except BaseException as error:
            close_client(self._jack, self._client)
            if isinstance(error, self._jack.JackError):
                raise DeviceError(f"the JACK server {server_name()!r} refuses the client {name!r}: {error}") from error
            raise
        self.sample_rate = float(self._client.samplerate)
        self.name = f"{self._client.name} (JACK)"
        _OPEN[id(self)] = (engine, self._table, self._scratch, self._client, self._jack)

    # What every output has ---------------------------------------------------------------------------------------
    def start(self):
        """Take part in the server's cycle from now on, then connect; the process's memory is locked where it may be.

        Raises
        ------
        DeviceError
            The engine runs at another rate or is played by another output, or the server does not answer.
        """
        self._check_rate()
        claim(self._engine, self)
        patiently(self._client.activate, f"the JACK server {server_name()!r}")
        self._started = True
        self._news = self._wiring.tend() + [note for note in [lock_memory()] if note]

    @property
    def running(self):
        """Whether JACK goes on calling, at the rate that the engine runs at."""
        return self._started and self._closed is None and self.reason is None

    @property
    def reason(self):
        """Why it no longer runs (str), None while nothing is wrong."""
        t = self._table
        if t[at.T_SHUTDOWN]:
            words = shutdown_words(t)
            return f"the JACK server has let go of {self.name}" + (f": {words}" if words else "")
        if t[at.T_RATE_NOW] != t[at.T_RATE]:
            return f"the JACK server now runs at {t[at.T_RATE_NOW]} Hz, not at {t[at.T_RATE]} Hz"
        if t[at.T_FAILED]:
            return "the engine has been closed"
        return None

    @property
    def block_size(self):
        """Frames of a period now (int); the server may change it at any time."""
        return int(self._table[at.T_BLOCK])

    @property
    def latency(self):
        """From the start of a cycle to its sound leaving the computer, as the server tells it [s]; at least a period.

        A MIDI event is played in the cycle that brings it, so this is also what JACK adds to a key's way to the ear,
        besides the period in which the event was waiting for its cycle.
        """
        frames = self.block_size
        if self.running:
            frames = max([frames] + [self._range(port, at.PLAYBACK)[1] for port in self._outs])
        return frames / self.sample_rate

    def xruns(self):
        """How often the server was late, whoever was to blame (int)."""
        return int(self._table[at.T_XRUNS])

    def refresh(self):
        """Nothing: the engine's slots are seen by the callback as they are."""

    def close(self):
        """Leave the server; False if libjack does not come back. What it may still call stays alive then.

        Keys and pedals that are held go up, as nobody is left to let them go.
        """
        if self._closed is None:
            self._closed = close_client(self._jack, self._client)
            self._table[at.T_MAGIC] = 0  # whatever still calls finds nothing to do
            if self._closed:  # the lane is without a writer now
                _OPEN.pop(id(self), None)
                release(self._engine, self)
                for message in held_messages(self._table):
                    self._engine.send(AT_ONCE, *message, lane=LANE_JACK)
        return self._closed

    # What JACK has besides -----------------------------------------------------------------------------------------
    def tend(self):
        """Connect what has come since the last call; returns what there is to say (list of str).

        Where a source of MIDI has gone, all keys and pedals that JACK's MIDI holds are let go: nobody else would.
        """
        if not self.running:
            return []
        news, self._news = self._news, []
        news += self._wiring.tend(int(self._table[at.T_PORTS_SEEN]))
        if self._wiring.lost:
            self._wiring.lost = False
            self._table[at.T_END_HELD] += 1
        return news

    def ports(self):
        """What each port is connected to (dict of short name -> list of names)."""
        return self._wiring.connections() if self.running else {}

    def counts(self):
        """Cycles, frames, MIDI events and what went wrong so far (dict of int), see jack_layout.py."""
        counts = self._table[at.T_COUNTS : at.T_COUNTS + len(at.COUNT_NAMES)].tolist()
        return dict(zip(at.COUNT_NAMES, counts, strict=True))

    def transport(self):
        """Whether JACK's transport rolls, and its frame at the start of the last cycle (bool, int)."""
        return self.transport_stamp()[:2]

    def transport_stamp(self):
        """The same, and the engine's frame at that moment (bool, int, int): the piece's place at any engine frame."""
        t = self._table
        while True:
            before = int(t[at.T_POSITION_SEQ])
            state, frame, engine = (int(t[k]) for k in (at.T_POSITION_STATE, at.T_POSITION_AT, at.T_POSITION_ENGINE))
            if before % 2 == 0 and before == int(t[at.T_POSITION_SEQ]):
                return state == at.ROLLING, frame, engine

    def latency_ranges(self):
        """(capture, playback) of each port, each (least, most) frames (dict by short name)."""
        ports = [*self._outs, *self._ins]
        return {p.shortname: (self._range(p, at.CAPTURE), self._range(p, at.PLAYBACK)) for p in ports}

    @property
    def silent(self):
        """Whether silence is written and the engine stands still; may be changed while running."""
        return not self._table[at.T_CALLBACK]

    @silent.setter
    def silent(self, silent):
        self._table[at.T_CALLBACK] = 0 if silent else self._engine.callback_address

    # -----------------------------------------------------------------------------------------------------------------
    def _check_rate(self):
        rate, wanted = self._engine.sample_rate, self.sample_rate
        if rate != wanted and not getattr(self._engine, "swapping", False):
            raise DeviceError(
                f"the JACK server {server_name()!r} runs at {wanted:.0f} Hz, not at {rate:.0f} Hz (--rate {wanted:.0f})"
            )

    def _register_ports(self, midi_inputs):
        """Ports of a synthesizer: "terminal", since what they give comes from no other audio port.

        Their names speak for themselves. JACK's metadata (pretty names) are left alone: jack2 keeps them in a database
        on which clients and server hang once a process has died over it (jack2 issue 647).
        """
        channels, client = self._engine.channels, self._client
        names = {1: ["out"], 2: ["out_left", "out_right"]}.get(channels, [f"out_{k + 1}" for k in range(channels)])
        self._outs = [client.outports.register(name, is_terminal=True) for name in names]
        names = ["midi_in", *[f"midi_in_{k + 2}" for k in range(midi_inputs - 1)]][:midi_inputs]
        self._ins = [client.midi_inports.register(name, is_terminal=True) for name in names]

    def _fill_table(self, silent):
        t, engine = self._table, self._engine
        for word, name in FUNCTIONS.items():
            t[word] = function_address(self._jack, name)
        t[at.T_CLIENT] = self._number(self._client._ptr)
        t[at.T_CHANNELS], t[at.T_MIDI_PORTS] = len(self._outs), len(self._ins)
        for first, ports in ((at.T_AUDIO, self._outs), (at.T_MIDI, self._ins)):
            t[first : first + len(ports)] = [self._number(port._ptr) for port in ports]
        t[at.T_RATE] = t[at.T_RATE_NOW] = self._client.samplerate
        t[at.T_BLOCK] = self._client.blocksize
        t[at.T_USERDATA], t[at.T_SCRATCH] = engine.userdata_address, self._scratch.ctypes.data
        self.silent = silent
        t[at.T_MAGIC] = at.J_MAGIC

    def _set_callbacks(self):
        lib, cast, client = self._jack._lib, self._jack._ffi.cast, self._client._ptr
        table = self._table.ctypes.data

        def word(number):
            return cast("void *", table + 8 * number)

        code = lib.jack_set_process_callback(client, cast("JackProcessCallback", process.address), word(0))
        lib.jack_on_info_shutdown(client, cast("JackInfoShutdownCallback", note_shutdown.address), word(0))
        value = cast("JackBufferSizeCallback", note_value.address)
        code |= lib.jack_set_buffer_size_callback(client, value, word(at.T_BLOCK))
        value = cast("JackSampleRateCallback", note_value.address)
        code |= lib.jack_set_sample_rate_callback(client, value, word(at.T_RATE_NOW))
        code |= lib.jack_set_xrun_callback(client, cast("JackXRunCallback", count_up.address), word(at.T_XRUNS))
        ports = cast("JackPortRegistrationCallback", count_port.address)
        code |= lib.jack_set_port_registration_callback(client, ports, word(at.T_PORTS_SEEN))
        ports = cast("JackPortConnectCallback", count_connection.address)
        code |= lib.jack_set_port_connect_callback(client, ports, word(at.T_PORTS_SEEN))
        number = self._number(client)
        code |= set_callback(self._jack, "jack_set_latency_callback", number, tell_latency.address, table)
        # PipeWire 0.3 calls only the older of the two; jack2 only the newer where both are set.
        set_callback(self._jack, "jack_on_shutdown", number, count_up.address, table + 8 * at.T_SHUTDOWN)
        if code:
            raise DeviceError(f"the JACK server {server_name()!r} takes no callbacks")

    def _range(self, port, mode):
        return latency_range(self._jack, self._number(port._ptr), mode)

    def _number(self, pointer):
        return int(self._jack._ffi.cast("uintptr_t", pointer))


@atexit.register
def _leave():
    """Close what is still open before the interpreter takes the memory away."""
    for _, table, _, client, jack in list(_OPEN.values()):
        close_client(jack, client)
        table[at.T_MAGIC] = 0
