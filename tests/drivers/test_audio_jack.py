"""PortAudio in its child process on a real server, and a session that outlives both; JACK's own driver likewise."""

import os
import signal
import subprocess

import pytest
from devices import wait_until
from jack_servers import NEEDS_JACK, running_server
from live_bench import make_engine

from ukrt.drivers.live.session import LiveSession
from ukrt.drivers.sound import process as audio_process
from ukrt.drivers.sound.process import AudioProcess
from ukrt.errors import DeviceError
from ukrt.model.presets import load_preset

pytestmark = NEEDS_JACK


@pytest.fixture
def jack(tmp_path, monkeypatch):
    """A running JACK server that this process and its children find."""
    with running_server(tmp_path, monkeypatch) as server:
        yield server


@pytest.fixture
def engine():
    engine = make_engine()
    yield engine
    engine.close()


def open_jack(engine):
    """JACK without PortAudio between, where its optional dependency is installed."""
    pytest.importorskip("jack")
    from ukrt.drivers.jack.client import JackOutput

    return JackOutput(engine)


@pytest.fixture(params=[AudioProcess, open_jack], ids=["portaudio", "native"])
def open_output(request):
    return request.param


class Bench:
    """A session on the server's output, with a note that is held."""

    def __init__(self, engine, open_output=AudioProcess):
        self.engine, self.news = engine, []
        self.session = LiveSession(engine, lambda: open_output(engine))

    def turn(self):
        self.session.tend()
        self.news += self.session.news()

    def wait(self, condition):
        wait_until(condition, 30.0, self.turn)
        self.turn()

    def advance(self, seconds=0.3):
        end = self.engine.frame + seconds * self.engine.sample_rate
        self.wait(lambda: self.engine.frame >= end)

    def hold_a_note(self):
        self.engine.send(-1, 0x90, 52, 90)
        self.advance()
        self.check_the_note()

    def check_the_note(self, sounds=True):
        """The one note is still held and sounds; nothing was ever reset."""
        counters = self.engine.counters()
        assert [(note["midi"], note["end_s"]) for note in self.engine.note_log()] == [(52, None)]
        assert counters["resets"] == counters["nonfinite_resets"] == 0
        assert self.engine.energy() > 1e-9 or not sounds

    def is_back(self, times):
        self.wait(lambda: self.session.reconnections == times)
        assert not self.session.away and "JACK" in self.session.output.name
        self.advance()


def test_the_child_plays_and_ends(jack, engine):
    device, rate = audio_process.probe()
    assert (device.name, rate) == ("system", 48000.0)
    assert [o.name for o in audio_process.list_outputs("jack")] == ["system"]
    output = AudioProcess(engine, "system", host_api="jack", latency="low")
    assert (output.sample_rate, output.block_size) == (48000.0, 0) and output.latency > 0
    assert engine.frame == 0 and output.running
    output.start()
    try:
        wait_until(lambda: engine.frame >= 9600)
        began, at_ns = engine.stamp()  # engine.frame itself may be read in the middle of a block
        assert began % 128 == 0 and at_ns > 0
        assert all(note.endswith(("log in again", "allow it", "call for it")) for note in output.news())
        assert output.news() == []
    finally:
        assert output.close()
    assert not output.running and not os.path.exists(f"/proc/{output.pid}")
    frame = engine.frame
    assert frame % 128 == 0
    assert engine.process_card(64).shape == (64, 2) and engine.frame == frame + 64
    assert not engine.recover()


@pytest.mark.parametrize(("outputs", "channels", "opened"), [(1, None, 1), (6, None, 2), (6, 1, 1), (6, 5, 5)])
def test_cards_of_one_and_of_many_channels(jack, engine, outputs, channels, opened):
    jack.end()
    jack.start(outputs=outputs)
    output = AudioProcess(engine, channels=channels)
    output.start()
    try:
        wait_until(lambda: engine.frame >= 4800)
        assert sum(port.startswith("PortAudio:") for port in jack.ask("jack_lsp").split()) == opened
    finally:
        assert output.close()


def test_what_cannot_be_opened_is_told_in_the_words_of_this_process(jack, engine):
    with pytest.raises(DeviceError, match="no audio output 'piano'; there is 0 "):
        AudioProcess(engine, "piano")
    with pytest.raises(DeviceError, match=r"refuses 96000 Hz, 2 channels, .*its own rate is 48000 Hz"):
        AudioProcess(engine, sample_rate=96000.0)
    with pytest.raises(DeviceError, match="no audio output has the host API 'asio'"):
        audio_process.probe(host_api="asio")


def test_a_server_that_does_not_answer_is_given_up(jack):
    child = audio_process.Child()
    with jack.frozen(), pytest.raises(DeviceError, match="does not answer: asked to list, it has said nothing for 2 s"):
        child.ask("list", 2.0)
    assert not child.running


def test_the_child_does_not_outlive_its_parent(jack, tmp_path):
    """Neither SIGINT (a terminal sends it to both) nor SIGTERM ends the child, but the end of its parent does."""
    script = (
        "import os, time\n"
        "from ukrt.drivers.sound.process import AudioProcess\n"
        "from ukrt.engine.engine import Engine\n"
        "from ukrt.model.presets import load_preset\n"
        "engine = Engine(load_preset('paper'), shared=True)\n"
        "output = AudioProcess(engine)\n"
        "output.start()\n"
        "print(output.pid, flush=True)\n"
        "time.sleep(60)\n"
    )
    root = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
    parent = subprocess.Popen(
        [os.sys.executable, "-c", script], stdout=subprocess.PIPE, text=True, cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": root},
    )  # fmt: skip
    try:
        child = int(parent.stdout.readline())
        os.kill(child, signal.SIGINT)
        os.kill(child, signal.SIGTERM)
        with pytest.raises(subprocess.TimeoutExpired):
            parent.wait(0.5)
        os.kill(child, 0)
    finally:
        parent.kill()
        parent.communicate()

    def gone():
        try:
            os.kill(child, 0)
        except ProcessLookupError:
            return True
        with open(f"/proc/{child}/stat") as stat:
            return stat.read().rsplit(")", 1)[1].split()[0] == "Z"

    wait_until(gone)


def test_a_session_outlives_its_server_at_another_rate_too(jack, engine, open_output):
    bench = Bench(engine, open_output)
    with bench.session as session:
        bench.hold_a_note()
        jack.end()
        bench.wait(lambda: session.away)
        bench.advance()
        bench.check_the_note()
        bench.wait(lambda: any("still no sound" in sentence for sentence in bench.news))
        jack.start()
        bench.is_back(1)
        bench.check_the_note()
        jack.end()
        bench.wait(lambda: session.away)
        jack.start(rate=44100, period=256)
        bench.is_back(2)
        bench.check_the_note(sounds=False)  # how much of its motion can be taken over to another rate is not asked
        assert engine.sample_rate == session.output.sample_rate == 44100.0
        engine.send(-1, 0x80, 52)
        engine.send(-1, 0x90, 55, 90)
        bench.wait(lambda: len(engine.note_log()) == 2)
        assert session.closed_cleanly
    assert engine.counters()["notes_on"] == 2 and engine.counters()["swaps"] == 1
    assert "is back, now at 44100 Hz" in bench.news[-1]


def test_a_session_outlives_its_child(jack, engine):
    """Killed from outside; if that was in the middle of a block the strings come to rest, else nothing is lost."""
    bench = Bench(engine)
    with bench.session as session:
        bench.hold_a_note()
        os.kill(session.output.pid, signal.SIGKILL)
        bench.is_back(1)
        if not engine.counters()["resets"]:
            bench.check_the_note()
    assert session.closed_cleanly


def test_a_session_outlives_a_server_that_freezes(jack, engine, open_output):
    bench = Bench(engine, open_output)
    with bench.session as session:
        bench.hold_a_note()
        with jack.frozen():
            bench.wait(lambda: session.away)
            bench.advance()
        bench.is_back(1)
        bench.check_the_note()
    assert "has asked for no sound for 1." in bench.news[0]


def test_the_period_may_change_while_playing(jack, engine, open_output):
    bench = Bench(engine, open_output)
    with bench.session as session:
        bench.hold_a_note()
        for period in (64, 512, 64):
            jack.ask("jack_bufsize", str(period))
            bench.wait(lambda: session.state()["block_size"] == period)  # noqa: B023
            bench.advance()
        bench.check_the_note()
        assert session.reconnections == 0


def test_another_guitar_takes_over(jack, engine, open_output):
    bench = Bench(engine, open_output)
    with bench.session as session:
        bench.hold_a_note()
        for name in ("drop-d", "no such preset", "paper"):
            said = len(bench.news)
            session.change_preset(lambda: load_preset(name))  # noqa: B023
            bench.wait(lambda: len(bench.news) > said)  # noqa: B023
            bench.advance()
        bench.wait(lambda: engine.counters()["swaps"] == 2)
        assert engine.counters()["resets"] == 0 and session.reconnections == 0
        assert [note["end_s"] for note in engine.note_log()] == [None]
    assert [sentence[:24] for sentence in bench.news] == [
        "the guitar is now drop-d",
        "the guitar stays as it i",
        "the guitar is now paper",
    ]
