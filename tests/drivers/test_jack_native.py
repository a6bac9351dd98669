"""``--driver jack``: our own client of a real server, played by another client, recorded by a third."""

import shutil
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

try:
    import jack  # noqa: F401
except (ImportError, OSError) as error:
    pytest.skip(f"needs JACK-Client and libjack: {error}", allow_module_level=True)
from drivers.jack_world import PulseEngine, Recorder, Sender, Server, wait_until

from ukrt.drivers import jack_library
from ukrt.drivers.jack import JackOutput, find_server, server_rate
from ukrt.engine import jack_layout as at
from ukrt.engine import stage_layout as stage
from ukrt.engine.engine import Engine
from ukrt.errors import DeviceError, MissingExtraError
from ukrt.model.presets import load_preset

pytestmark = [
    pytest.mark.jack,
    pytest.mark.skipif(shutil.which("jackd") is None, reason="needs jackd (Debian: apt-get install jackd2)"),
]


@pytest.fixture
def world(request, tmp_path, monkeypatch):
    """A server (``sync`` by parameter) and what was opened on it; all is closed and ended afterwards."""

    class World:
        def __init__(self):
            self.server = Server(tmp_path / "jackd.log", **getattr(request, "param", {}))
            self.opened = []

        def open(self, kind, *arguments, **options):
            self.opened.append(kind(*arguments, **options))
            return self.opened[-1]

        def close(self):
            while self.opened:
                self.opened.pop().close()

    world = World()
    monkeypatch.setenv("JACK_DEFAULT_SERVER", world.server.name)
    monkeypatch.setenv("JACK_NO_START_SERVER", "1")
    yield world
    world.close()
    world.server.end()


SYNC = pytest.mark.parametrize("world", [{"sync": True}], indirect=True)


def started(world, engine, **options):
    """A running output of the engine."""
    output = world.open(JackOutput, engine, **options)
    output.start()
    frame = engine.frame
    wait_until(lambda: engine.frame > frame)
    return output


def replayed(engine):
    """What a fresh engine gives to a card for the journal of ``engine``, as far as that has come."""
    again = Engine(load_preset("classical"), 48000.0)
    again.message_cap = 0
    again.apply(engine.settings())
    _, entries, lost = engine.journal(0)
    assert lost == 0 and len(entries) > 0
    for frame, word in entries.tolist():
        assert again.send(frame, word >> 16, word >> 8, word)
    samples = again.process_card(engine.frame)
    again.close()
    return samples


@pytest.fixture
def engine(world):
    """The guitar, as live; closed after all that calls it."""
    engine = Engine(load_preset("classical"), 48000.0, shared=True)
    engine.output_gain, engine.shed_budget = 0.3, 0.0
    yield engine
    world.close()
    engine.close()


def play(sender, messages, seconds=0.02):
    """Send messages, each at a frame of its own and at odd distances; waits until they are out."""
    begin = sender.client.frame_time + 2400
    step = int(seconds * 48000)
    sender.waiting += [(begin + k * step + k * 37 % min(step, 128), data) for k, data in enumerate(messages)]
    wait_until(lambda: not sender.waiting)


NOTES = [bytes([0x90, 40 + 5 * k % 32, 60 + 9 * k % 60]) for k in range(12)] + [b"\xe0\x00\x50", b"\x80\x28\x40"]


@SYNC
def test_another_clients_recording_equals_the_journal_replayed(world, engine):
    """Bit for bit; and each message acts at just the frame at which it was sent."""
    output = started(world, engine)
    sender, recorder = world.open(Sender), world.open(Recorder)
    output.tend()
    for source, target in zip(("out_left", "out_right"), recorder.ports, strict=True):
        recorder.client.connect(f"{output.name.split()[0]}:{source}", target)
    play(sender, NOTES)
    wait_until(lambda: engine.frame > engine.journal(0)[1][-1, 0] + 24000)
    end, blocks = engine.frame, len(recorder.blocks)
    wait_until(lambda: len(recorder.blocks) > blocks + 1)  # what is computed is heard in the same cycle
    output.close()
    frames = engine.journal(0)[1][:, 0]
    assert len(frames) == len(NOTES)
    delays = {int(frame) - when for frame, (when, _) in zip(frames, sender.sent, strict=True)}
    assert len(delays) == 1
    first, recorded = recorder.sound()
    first += delays.pop()
    begin = int(frames[0]) - 100
    expected = replayed(engine)[begin:end].view(np.int32)
    assert np.abs(expected.view(np.float32)).max() > 0.01
    different = np.flatnonzero(recorded[begin - first : end - first].view(np.int32) != expected)
    assert different.tolist() == []
    assert output.counts()["missed_frames"] == output.counts()["lost_events"] == 0


@SYNC
@pytest.mark.skipif(shutil.which("jack_capture") is None, reason="needs jack_capture")
def test_jack_capture_hears_the_same_bits(world, engine, tmp_path):
    import soundfile

    path = tmp_path / "heard.wav"
    output, sender = started(world, engine), world.open(Sender)
    output.tend()
    command = ["jack_capture", "-ns", "-as", "-b", "FLOAT", "-c", "2", "-mc", "-d", "2", str(path)]
    capture = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    client = sender.client
    wait_until(lambda: len(client.get_ports("jack_capture.*", is_input=True)) == 2)
    for source, target in zip(("left", "right"), client.get_ports("jack_capture.*", is_input=True), strict=True):
        client.connect(f"{output.name.split()[0]}:out_{source}", target)
    play(sender, NOTES)
    assert capture.wait(20) == 0
    output.close()
    heard, expected = soundfile.read(path, dtype="float32")[0], replayed(engine)
    onset, at_ = np.flatnonzero(np.abs(expected) > 1e-3)[0] // 2, np.flatnonzero(np.abs(heard) > 1e-3)[0] // 2
    n = min(len(expected) - onset, len(heard) - at_)
    assert n > 24000
    assert np.array_equal(heard[at_ : at_ + n].view(np.int32), expected[onset : onset + n].view(np.int32))


@pytest.mark.parametrize("world", [{}, {"sync": True}, {"period": 1024}], indirect=True)
def test_every_event_is_heard_at_its_own_frame(world):
    engine = PulseEngine()
    output = started(world, engine)
    sender, recorder = world.open(Sender), world.open(Recorder)
    output.tend()
    recorder.client.connect(output._outs[0], recorder.ports[0])
    play(sender, [bytes([0x90, 1 + k, 100]) for k in range(60)])
    wait_until(lambda: recorder.sound()[0] + len(recorder.sound()[1]) > sender.sent[-1][0] + 1024)
    first, sound = recorder.sound()
    places = np.flatnonzero(sound[:, 0])
    heard = {round(float(sound[p, 0]) * 128): first + int(p) for p in places}
    sent = {data[1]: when for when, data in sender.sent}
    missing = output.counts()["missed_frames"]
    assert missing or len(heard) == 60  # a cycle that the server left out takes its events along
    assert {heard[note] - sent[note] for note in heard} == {0} and len(heard) > 30


@pytest.mark.skipif(shutil.which("jack_midiseq") is None, reason="needs jack_midiseq (Debian: in jackd2)")
def test_a_thread_that_holds_the_interpreter_delays_nothing(world):
    """A sequencer in C plays; for a second no other Python code can run at all."""
    import ctypes

    engine = PulseEngine()
    sequencer = subprocess.Popen(["jack_midiseq", "sequencer", "2400", "0", "60", "1200"], stdout=subprocess.DEVNULL)
    try:
        output = started(world, engine, midi="sequencer")
        wait_until(lambda: output.tend() or output.counts()["messages"] > 0)
        before, frame = output.counts(), engine.frame
        ctypes.PyDLL(None).usleep(1_000_000)  # PyDLL keeps the lock
        after, frames = output.counts(), engine.frame - frame
    finally:
        sequencer.send_signal(signal.SIGTERM)
        sequencer.wait(10)
    assert frames > 24000  # of 48000; a callback in Python would have computed none
    assert abs((after["messages"] - before["messages"]) - 2 * frames / 2400) <= 3 + after["missed_frames"] // 1200


@pytest.mark.parametrize("how", [signal.SIGTERM, signal.SIGKILL])
def test_the_server_dies_and_another_comes(world, engine, how):
    """The engine goes on where it was: its strings ring, no frame is left out, none is computed twice."""
    output, sender = started(world, engine), world.open(Sender)
    output.tend()
    play(sender, NOTES)
    wait_until(lambda: len(engine.journal(0)[1]) == len(NOTES))
    world.server.end(how)
    wait_until(lambda: not output.running)
    assert "has let go of ukrt" in output.reason and output.tend() == [] and output.ports() == {}
    assert output.close() and output.close()
    world.close()
    frame, energy = engine.frame, engine.energy()
    assert energy > 0.0 and find_server() is None
    with pytest.raises(DeviceError, match="no JACK server"):
        JackOutput(engine)
    world.server.start(period=256)
    again = started(world, engine)
    assert again.running and again.block_size == 256 and again.counts()["frames"] <= engine.frame - frame
    assert again.close()
    assert engine.frame == frame + again.counts()["frames"]
    samples = engine.recorded(0)[1]
    assert np.array_equal(samples.view(np.int32), replayed(engine)[: len(samples)].view(np.int32))


@SYNC
def test_the_period_changes_while_playing(world, engine):
    output, sender, recorder = started(world, engine), world.open(Sender), world.open(Recorder)
    output.tend()
    recorder.client.connect(output._outs[0], recorder.ports[0])
    play(sender, NOTES[:6])
    for period in (64, 32, 2048, 128):
        sender.client.blocksize = period
        wait_until(lambda period=period: output.block_size == period)
        frame = engine.frame
        wait_until(lambda frame=frame: engine.frame > frame + 4096)
        assert output.running
    blocks = [block for _, block in recorder.blocks]
    output.close()
    assert {block.shape[1] for block in blocks} == {128, 64, 32, 2048}
    heard = np.concatenate([block[0] for block in blocks])
    expected = replayed(engine)[:, 0]
    shift = np.flatnonzero(np.abs(heard) > 1e-3)[0] - np.flatnonzero(np.abs(expected) > 1e-3)[0]
    begin = max(0, -shift)
    assert shift <= 0 or not heard[:shift].any()
    heard = heard[begin + shift :][: len(expected) - begin]
    assert len(heard) > 24000 and np.array_equal(heard, expected[begin : begin + len(heard)])
    assert output.counts()["missed_frames"] == 0


def test_refusals_are_sentences(world, monkeypatch):
    other = PulseEngine()
    other.sample_rate = 44100.0
    with pytest.raises(DeviceError, match=r"runs at 48000 Hz, not at 44100 Hz \(--rate 48000\)"):
        world.open(JackOutput, other).start()
    other.channels = 17
    with pytest.raises(DeviceError, match="1 to 16"):
        JackOutput(other)
    assert server_rate() == 48000.0
    with monkeypatch.context() as absent, pytest.raises(MissingExtraError, match=r"pip install 'ukrt\[jack\]'"):
        absent.setitem(sys.modules, "jack", None)
        find_server()
    monkeypatch.setenv("JACK_DEFAULT_SERVER", "ukrt-nobody")
    assert find_server() is None
    with pytest.raises(DeviceError, match="no JACK server 'ukrt-nobody' answers"):
        server_rate()


def test_names_connections_and_latencies(world):
    server = find_server()
    assert (server.sample_rate, server.block_size) == (48000.0, 128)
    assert server.outputs == ("system:playback_1", "system:playback_2") and server.midi_sources == ()
    one, two = started(world, PulseEngine()), started(world, PulseEngine(), connect=False, midi="key")
    assert (one.name, two.name) == ("ukrt (JACK)", "ukrt-01 (JACK)")
    assert one.ports() == {"out_left": ["system:playback_1"], "out_right": ["system:playback_2"], "midi_in": []}
    sender = world.open(Sender, "Keyboard")
    wait_until(lambda: one.tend() == ["MIDI from Keyboard:out is connected"])
    wait_until(lambda: two.tend() == ["MIDI from Keyboard:out is connected"])
    assert two.ports() == {"out_left": [], "out_right": [], "midi_in": ["Keyboard:out"]}
    assert one.tend() == []
    ranges = one.latency_ranges()
    playback = ranges["out_left"][1]
    assert playback[0] == playback[1] >= 128 and ranges["midi_in"][1] == playback
    assert one.latency == playback[1] / 48000.0 and two.latency == 128 / 48000.0
    port = sender.client.get_port_by_name("ukrt:out_left")
    assert port.is_terminal and not port.is_physical
    sender.close()
    wait_until(lambda: one.tend() == ["MIDI from Keyboard:out is gone"])
    three = started(world, PulseEngine(), connect="nowhere", midi=False)
    assert three.ports()["out_left"] == [] and three.tend() == []


def test_transport_freewheel_silence_and_another_rate(world):
    engine = PulseEngine()
    output, client = started(world, engine), world.open(Recorder).client
    client.transport_frame = 48000
    client.transport_start()
    wait_until(lambda: output.transport()[0])
    one, two = output.transport_stamp(), output.transport_stamp()
    wait_until(lambda: output.transport_stamp() != one)
    two = output.transport_stamp()
    assert two[1] - one[1] == two[2] - one[2] > 0 and one[1] >= 48000
    client.transport_stop()
    wait_until(lambda: not output.transport()[0])
    frame = engine.frame
    client.set_freewheel(True)
    wait_until(lambda: engine.frame > frame + 480_000)
    client.set_freewheel(False)
    output.silent = True
    wait_until(lambda: output.counts()["cycles"] % 2 == 0)
    cycles, frame = output.counts()["cycles"], engine.frame
    wait_until(lambda: output.counts()["cycles"] > cycles + 10)
    assert engine.frame <= frame + output.block_size
    output.silent = False
    wait_until(lambda: engine.frame > frame + 1000)
    assert output.running and output.reason is None and output.xruns() >= 0
    output._table[at.T_RATE_NOW] = 44100  # as the server's notice does it; jackd itself cannot change its rate
    assert not output.running and output.reason == "the JACK server now runs at 44100 Hz, not at 48000 Hz"


def test_a_frozen_server_holds_nobody_up(world, monkeypatch):
    monkeypatch.setattr(jack_library, "_PATIENCE_SECONDS", 0.3)
    engine = PulseEngine()
    output = started(world, engine)
    world.server.suspend(True)
    try:
        with pytest.raises(DeviceError, match="has not answered"):
            server_rate()
        assert find_server() is None
    finally:
        world.server.suspend(False)
    frame = engine.frame
    wait_until(lambda: engine.frame > frame + 4800)
    assert output.running
    time.sleep(0.3)  # what came too late is closed by itself meanwhile


def test_random_bytes_from_a_client_harm_nothing(world, engine):
    """JACK carries any bytes; afterwards all notes can be ended and the guitar plays on."""
    output, sender = started(world, engine), world.open(Sender)
    output.tend()
    noise = np.random.default_rng(3).integers(0, 256, (2000, 10)).astype(np.uint8)
    play(sender, [row.tobytes() for row in noise], 0.0005)
    ends = [bytes([0xB0 | c, d, 0]) for c in range(16) for d in (64, 66, 123)]
    play(sender, [b"\xf7", *ends], 0.001)
    last = sum(engine.counters()[k] for k in ("midi_received", "midi_dropped"))
    wait_until(lambda: engine.frame > 48000 and not engine._si[stage.G_CAP_HELD])
    assert last > 1000 and output.running
    wait_until(lambda: all(n["end_s"] is not None for n in engine.note_log() if n["string"] is not None))
    assert np.abs(engine.recorded(0)[1]).max() <= 1.0
    assert engine.counters()["nonfinite_resets"] == 0
