"""``ukrt doctor``: what it finds out, as data and in words, without devices and on a JACK server of its own."""

import contextlib
import io
import json
import sys
import threading

import pytest
from jack_servers import NEEDS_JACK

from ukrt.cli.main import main
from ukrt.drivers.doctor import outputs as doctor_outputs
from ukrt.drivers.doctor.advice import PROBLEM
from ukrt.drivers.doctor.sources import Compiled
from ukrt.drivers.doctor.system_facts import system_facts
from ukrt.drivers.midi.host import MARGIN_SECONDS
from ukrt.engine import stage_layout as at
from ukrt.engine.engine import Engine
from ukrt.model.presets import load_preset

SOURCES = ("compiled", "empty", "python")


def doctor(*arguments):
    """The report of a short run."""
    text = io.StringIO()
    with contextlib.redirect_stdout(text):
        assert main(["doctor", "--json", "--seconds", "1", *arguments]) == 0
    return json.loads(text.getvalue())


@pytest.fixture(scope="module")
def report():
    return doctor("--driver", "null", "--block", "64")


def test_the_report_tells_what_was_measured(report):
    assert report["output"] == {
        "driver": "null",
        "name": doctor_outputs.NullOutputs.name,
        "rate_hz": 48000.0,
        "realtime": None,
    }
    assert (report["strings"], report["strings_plucked"], report["contacts"]) == (6, 6, 3)
    (cell,) = report["cells"]
    assert (cell["stress"], cell["block_frames"]) == ("none", 64)
    assert [one["source"] for one in cell["slices"]] == list(SOURCES)
    for name in SOURCES:
        result = cell["sources"][name]
        assert result["blocks"] > 100 and result["block_frames"] == 64
        assert result["seconds"] == pytest.approx(1 / 3, rel=0.5)
    assert list(cell["sources"]["empty"]["load"] or ()) == []
    for name in ("compiled", "python"):
        loads = list(cell["sources"][name]["load"].values())
        assert loads == sorted(loads) and loads[0] > 0


def test_the_report_tells_what_the_machine_allows(report):
    machine = report["machine"]
    assert machine["processor"]["cores"] >= 1
    assert machine["jit_cache"]["writable"] and isinstance(machine["jit_cache"]["warm"], bool)
    assert system_facts()["jit_cache"]["warm"]  # now at the latest, after the run
    assert machine["scheduling"]["allowed"] in (True, False, None)
    assert (machine["scheduling"]["reason"] is None) or not machine["scheduling"]["allowed"]
    assert (machine["memory_lock"]["reason"] is None) == machine["memory_lock"]["allowed"]
    assert set(machine["libraries"]) == {"portaudio", "rtmidi", "jack_client", "jack_server"}


def test_the_delay_is_the_sum_of_its_parts(report):
    delay = report["cells"][0]["delay"]
    assert delay["midi_ms"] == pytest.approx(1e3 * (64 / 48000 + MARGIN_SECONDS))
    assert delay["pluck_ms"] == pytest.approx(10.0, abs=0.1)  # the classical preset's pluck
    assert delay["total_ms"] == pytest.approx(delay["midi_ms"] + delay["output_ms"] + delay["pluck_ms"])


def test_words_for_people(capsys, monkeypatch, tmp_path):
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setattr(doctor_outputs.audio, "find_output", lambda: None)
    picture = tmp_path / "doctor.png"
    options = ["--plot", str(picture)] if _has_matplotlib() else []
    assert main(["doctor", "--seconds", "1", "--block", "64", "--stress", "all", *options]) == 0
    out, err = capsys.readouterr()
    assert "no sound card" in out and "real-time priority" in out and "from key to sound" in out
    assert all(f" {stress} " in out for stress in ("python", "gc", "gil"))
    assert "…" not in out and max(map(len, out.splitlines()[-20:])) <= 80
    assert "Traceback" not in err
    assert picture.exists() == bool(options)


def _has_matplotlib():
    try:
        import matplotlib.figure  # noqa: F401
    except ImportError:
        return False
    return True


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--block", "64,banana"], "16 to 8192"),
        (["--block", "8"], "16 to 8192"),
        (["--block", "64,64"], "twice"),
        (["--seconds", "0"], "1 to 3600"),
        (["--driver", "asio"], "portaudio"),
        (["--stress", "coffee"], "gil"),
    ],
)
def test_what_makes_no_sense_is_refused(capsys, arguments, words):
    assert main(["doctor", *arguments]) == 2
    out, err = capsys.readouterr()
    assert out == "" and len(err.splitlines()) == 1 and words in err


def test_missing_extras_are_named(capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "jack", None)
    assert main(["doctor", "--driver", "jack"]) == 2
    assert "ukrt[jack]" in capsys.readouterr().err
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    assert main(["doctor", "--driver", "null", "--plot", "x.png"]) == 2
    assert "matplotlib" in capsys.readouterr().err


def test_without_portaudio_the_null_output_is_measured_and_said_so(monkeypatch):
    monkeypatch.setitem(sys.modules, "sounddevice", None)
    report = doctor("--block", "256")
    assert report["output"]["driver"] == "null"
    assert any("ukrt[live]" in note for note in report["notes"])
    assert report["machine"]["libraries"]["portaudio"] is None
    assert any(one["severity"] == PROBLEM and "PortAudio" in one["words"] for one in report["advice"])


def test_counters_are_read_when_a_block_that_is_interrupted_has_ended():
    """A busy machine stops the audio thread in the middle of a block, between the frames and the count of the block."""
    engine = Engine(load_preset("paper"))
    engine.process_card(128)
    si = engine.stage.si
    si[at.G_BUSY] = 1
    si[at.G_FRAME] += 128

    def go_on():
        si[at.N_BLOCKS] += 1
        si[at.G_BUSY] = 0

    later = threading.Timer(0.2, go_on)
    later.start()
    counts = Compiled(engine).counts()
    later.join()
    assert (counts["frames"], counts["blocks"]) == (256, 2)
    engine.close()


# On a server ---------------------------------------------------------------------------------------------------------
@pytest.fixture
def jack(server):
    """What leads clients to a JACK server of our own."""
    return server.environment


@NEEDS_JACK[0]
@NEEDS_JACK[1]
@pytest.mark.parametrize("driver", ["portaudio", "jack"])
def test_a_server_at_its_own_period_and_another(jack, ukrt_process, driver):
    """Asked for 64 frames, the server's period is changed and given back: the second run finds the first one's."""
    if driver == "jack":
        pytest.importorskip("jack")
    common = ("doctor", "--seconds", "1", "--json", "--driver", driver)
    code, out, err = ukrt_process(*common, "--block", "64", environment=jack)
    assert code == 0, err
    report = json.loads(out)
    assert report["output"]["driver"] == driver and report["output"]["realtime"] is False
    (cell,) = report["cells"]
    assert cell["block_frames"] == 64 and report["strings_plucked"] == 6
    assert all(cell["sources"][name]["blocks"] > 50 for name in SOURCES)
    assert any("without real-time priority" in one["words"] for one in report["advice"])
    code, out, err = ukrt_process(*common, environment=jack)
    assert code == 0, err
    assert json.loads(out)["cells"][0]["block_frames"] == 128


@NEEDS_JACK[0]
@NEEDS_JACK[1]
def test_a_rate_that_the_server_does_not_run_at_is_refused(jack, ukrt_process):
    pytest.importorskip("jack")
    code, out, err = ukrt_process("doctor", "--driver", "jack", "--rate", "44100", environment=jack)
    assert (code, out) == (2, "")
    assert err.splitlines()[-1].startswith("ukrt: ") and "48000" in err
