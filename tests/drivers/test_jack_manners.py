"""Our JACK client among others: names, connections, latencies, transport; and what it says where it cannot play."""

import sys
import time

import pytest
from drivers.jack_world import PulseEngine, Recorder, Sender, World, wait_until
from jack_servers import NEEDS_JACK

from ukrt.drivers.jack import server as jack_library
from ukrt.drivers.jack.client import JackOutput, find_server, server_rate
from ukrt.engine import jack_layout as at
from ukrt.errors import DeviceError, MissingExtraError

pytestmark = NEEDS_JACK


@pytest.fixture
def world(request, tmp_path, monkeypatch):
    """A server (its options by parameter) and what is opened on it."""
    with World(tmp_path, monkeypatch, **getattr(request, "param", {})) as world:
        yield world


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
    one, two = world.started(PulseEngine()), world.started(PulseEngine(), connect=False, midi="key")
    assert (one.name, two.name) == ("ukrt (JACK)", "ukrt-01 (JACK)")
    assert one.ports() == {"out_left": ["system:playback_1"], "out_right": ["system:playback_2"], "midi_in": []}
    sender = world.open(Sender, "Keyboard")
    wait_until(lambda: "MIDI from Keyboard:out is connected" in one.tend())
    wait_until(lambda: "MIDI from Keyboard:out is connected" in two.tend())
    assert two.ports() == {"out_left": [], "out_right": [], "midi_in": ["Keyboard:out"]}
    assert one.tend() == []
    sender.client.disconnect("Keyboard:out", "ukrt:midi_in")
    wait_until(lambda: one.tend() == ["MIDI from Keyboard:out is gone"])
    assert one.tend() == [] and one.ports()["midi_in"] == []
    sender.client.connect("Keyboard:out", "ukrt:midi_in")
    wait_until(lambda: one.tend() == ["MIDI from Keyboard:out is connected"])
    ranges = one.latency_ranges()
    playback = ranges["out_left"][1]
    assert playback[0] == playback[1] >= 128 and ranges["midi_in"][1] == playback
    assert one.latency == playback[1] / 48000.0 and two.latency == 128 / 48000.0
    port = sender.client.get_port_by_name("ukrt:out_left")
    assert port.is_terminal and not port.is_physical
    sender.close()
    wait_until(lambda: one.tend() == ["MIDI from Keyboard:out is gone"])
    three = world.started(PulseEngine(), connect="nowhere", midi=False)
    assert three.ports()["out_left"] == []
    assert three.tend() == ["the JACK server has no audio inputs named 'nowhere' to connect to yet"]
    world.open(Recorder, name="Nowhere")
    wait_until(lambda: three.tend() == [] and three.ports()["out_left"] == ["Nowhere:in_0"])


def test_transport_freewheel_silence_and_another_rate(world):
    engine = PulseEngine()
    output, client = world.started(engine), world.open(Recorder).client
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
    output = world.started(engine)
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
