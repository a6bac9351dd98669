"""``--driver jack``: our own client of a real server, played by another client, recorded by a third."""

import shutil
import signal
import subprocess

import numpy as np
import pytest
from drivers.jack_world import PulseEngine, Recorder, Sender, World, wait_until
from jack_servers import NEEDS_JACK

from ukrt.drivers.jack.client import JackOutput, find_server
from ukrt.engine import stage_layout as stage
from ukrt.engine.engine import Engine
from ukrt.errors import DeviceError
from ukrt.model.presets import load_preset

pytestmark = NEEDS_JACK


@pytest.fixture
def world(request, tmp_path, monkeypatch):
    """A server (its options by parameter) and what is opened on it."""
    with World(tmp_path, monkeypatch, **getattr(request, "param", {})) as world:
        yield world


SYNC = pytest.mark.parametrize("world", [{"sync": True}], indirect=True)


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


def waiting(engine):
    """Messages in JACK's lane (list of (frame, word))."""
    si, lane, step = engine._si, stage.LANE_JACK, stage.LANE_STEP
    numbers = range(si[stage.LANE_READ + step * lane], si[stage.LANE_WRITE + step * lane])
    slots = [stage.QUEUES + stage.LANE_SIZE * lane + 2 * (k % stage.QUEUE) for k in numbers]
    return [(int(si[slot]), int(si[slot + 1])) for slot in slots]


NOTES = [bytes([0x90, 40 + 5 * k % 32, 60 + 9 * k % 60]) for k in range(12)] + [b"\xe0\x00\x50", b"\x80\x28\x40"]


@SYNC
def test_another_clients_recording_equals_the_journal_replayed(world, engine):
    """Bit for bit; and each message acts at just the frame at which it was sent."""
    sender, recorder = world.open(Sender), world.open(Recorder)
    output = world.started(engine)
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
    delays = {int(frame) - recorder.place(when) for frame, (when, _) in zip(frames, sender.sent, strict=True)}
    assert len(delays) == 1
    delay = delays.pop()
    begin = int(frames[0]) - 100
    expected = replayed(engine)[begin:end].view(np.int32)
    assert np.abs(expected.view(np.float32)).max() > 0.01
    different = np.flatnonzero(recorder.heard()[begin - delay : end - delay].view(np.int32) != expected)
    assert different.tolist() == []
    assert output.counts()["lost_events"] == 0
    assert output.counts()["missed_frames"] <= recorder.skipped()  # 0, unless the machine holds up the server itself


@SYNC
@pytest.mark.skipif(shutil.which("jack_capture") is None, reason="needs jack_capture")
def test_jack_capture_hears_the_same_bits(world, engine, tmp_path):
    import soundfile

    path = tmp_path / "heard.wav"
    output, sender = world.started(engine), world.open(Sender)
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


@pytest.mark.parametrize("world", [{"sync": True}, {"sync": True, "period": 1024}, {"period": 1024}], indirect=True)
def test_every_event_is_heard_at_its_own_frame(world):
    engine = PulseEngine()
    output = world.started(engine)
    sender, recorder = world.open(Sender), world.open(Recorder)
    output.tend()
    recorder.client.connect(output._outs[0], recorder.ports[0])
    play(sender, [bytes([0x90, 1 + k, 100]) for k in range(60)])
    wait_until(lambda: recorder.sound()[0] + len(recorder.sound()[1]) > sender.sent[-1][0] + 1024)
    first, sound = recorder.sound()
    places = np.flatnonzero(sound[:, 0])
    heard = {round(float(sound[p, 0]) * 128): first + int(p) for p in places}
    sent = {data[1]: when for when, data in sender.sent}
    # Where the server does not wait, a cycle that the sender missed takes its events along.
    assert len(heard) == 60 or (len(heard) > 30 and not world.server.sync)
    assert {heard[note] - sent[note] for note in heard} == {0}


@SYNC  # else a cycle that the sequencer misses takes its events along
@pytest.mark.skipif(shutil.which("jack_midiseq") is None, reason="needs jack_midiseq (Debian: in jackd2)")
def test_a_thread_that_holds_the_interpreter_delays_nothing(world):
    """A sequencer in C plays; for a second no other Python code can run at all."""
    import ctypes

    engine = PulseEngine()
    sequencer = subprocess.Popen(["jack_midiseq", "sequencer", "2400", "0", "60", "1200"], stdout=subprocess.DEVNULL)
    try:
        output = world.started(engine, midi="sequencer")
        wait_until(lambda: (output.tend(), output.counts()["messages"] > 0)[1])  # a sentence may say: not there yet
        before = output.counts()
        ctypes.PyDLL(None).usleep(1_000_000)  # PyDLL keeps the lock
        after = output.counts()
    finally:
        sequencer.send_signal(signal.SIGTERM)
        sequencer.wait(10)
    frames, messages = (after[name] - before[name] for name in ("frames", "messages"))
    assert frames > 24000  # of 48000; a callback in Python would have computed none
    assert abs(messages - 2 * frames / 2400) <= 3


@SYNC
@pytest.mark.parametrize("how", [signal.SIGTERM, signal.SIGKILL])
def test_the_server_dies_and_another_comes(world, engine, how):
    """The engine goes on where it was: its strings ring, no frame is left out, none is computed twice."""
    output, sender = world.started(engine), world.open(Sender)
    output.tend()
    play(sender, NOTES)
    wait_until(lambda: len(engine.journal(0)[1]) == len(NOTES))
    world.server.end(how)
    wait_until(lambda: not output.running)
    assert output.reason.startswith("the JACK server has let go of ukrt (JACK): ")
    assert output.tend() == [] and output.ports() == {}
    assert output.close() and output.close()
    world.close()
    still = {int(word) >> 8 & 0x7F for frame, word in engine.journal(0)[1] if word >> 16 == 0x90} - {0x28}
    assert {word >> 8 & 0x7F for _, word in waiting(engine)} == still and len(still) > 3  # keys that nobody lets go
    frame, energy = engine.frame, engine.energy()
    assert energy > 0.0 and find_server() is None
    with pytest.raises(DeviceError, match="no JACK server"):
        JackOutput(engine)
    world.server.start(period=256)
    again = world.started(engine)
    assert again.running and again.block_size == 256 and again.counts()["frames"] <= engine.frame - frame
    assert again.close()
    assert engine.frame == frame + again.counts()["frames"]
    samples = engine.recorded(0)[1]
    assert np.array_equal(samples.view(np.int32), replayed(engine)[: len(samples)].view(np.int32))


@SYNC
def test_the_period_changes_while_playing(world, engine):
    sender, recorder = world.open(Sender), world.open(Recorder)
    output = world.started(engine)
    output.tend()
    recorder.client.connect(output._outs[0], recorder.ports[0])
    play(sender, NOTES[:6])
    for period in (64, 32, 2048, 128):
        sender.client.blocksize = period
        wait_until(lambda period=period: output.block_size == period)
        frame = engine.frame
        wait_until(lambda frame=frame: engine.frame > frame + 4096)
        assert output.running
    heard = recorder.heard()[:, 0]
    output.close()
    assert {block.shape[1] for _, block in recorder.blocks} == {128, 64, 32, 2048}
    expected = replayed(engine)[:, 0]
    shift = np.flatnonzero(np.abs(heard) > 1e-3)[0] - np.flatnonzero(np.abs(expected) > 1e-3)[0]
    begin = max(0, -shift)
    assert shift <= 0 or not heard[:shift].any()
    heard = heard[begin + shift :][: len(expected) - begin]
    assert len(heard) > 24000 and np.array_equal(heard, expected[begin : begin + len(heard)])
    assert output.counts()["missed_frames"] <= recorder.skipped()  # 0, unless the machine holds up the server itself


@SYNC
def test_a_keyboard_that_goes_lets_go_of_its_keys(world, engine):
    output, sender = world.started(engine), world.open(Sender)
    output.tend()
    play(sender, [b"\xb0\x40\x7f", b"\x90\x28\x50", b"\x90\x34\x50", b"\x80\x34\x00"])
    wait_until(lambda: len(engine.journal(0)[1]) == 4)
    assert [note["end_s"] for note in engine.note_log()] == [None, None]  # held by the key and by the pedal
    sender.close()
    wait_until(lambda: "MIDI from keyboard:out is gone" in output.tend())
    wait_until(lambda: None not in [note["end_s"] for note in engine.note_log()])
    assert {int(word) for word in engine.journal(0)[1][4:, 1]} == {0xB04000, 0x802800}


def test_random_bytes_from_a_client_harm_nothing(world, engine):
    """JACK carries any bytes; afterwards all notes can be ended and the guitar plays on."""
    output, sender = world.started(engine), world.open(Sender)
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
