"""``ukrt doctor``: what it finds out as data and in words, and what it advises for machines that are made up here."""

import contextlib
import io
import json
import os
import shutil
import subprocess
import sys
import time
import uuid

import pytest

from ukrt.cli.doctor import turns_of
from ukrt.cli.main import main
from ukrt.drivers import doctor_outputs
from ukrt.drivers.doctor_advice import GOOD, HINT, PROBLEM, advise, clearly_more, key_to_sound, recommend
from ukrt.drivers.doctor_measure import Slice, summarize, within_range
from ukrt.drivers.midi_host import MARGIN_SECONDS
from ukrt.drivers.stress import WORDS, run_stress
from ukrt.drivers.system_facts import system_facts

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


# Advice on made-up facts ---------------------------------------------------------------------------------------------
def machine(**changes):
    """A machine with nothing to complain about, and what is changed of it as ``section__key=value``."""
    facts = {
        "system": {"name": "Linux", "realtime_kernel": False, "python": "3.13", "machine": "x86_64"},
        "scheduling": {"allowed": True, "reason": None, "rtprio_limit": 95, "rttime_limit_us": -1},
        "memory_lock": {"allowed": True, "reason": None, "limit_bytes": -1},
        "processor": {
            "model": "A",
            "cores": 4,
            "governors": ["performance"],
            "load_average": 0.2,
            "hypervisor": False,
        },
        "jit_cache": {"folder": "/cache", "warm": True, "writable": True},
        "libraries": {"portaudio": "19", "rtmidi": "1.5", "jack_client": "0.5", "jack_server": "jackd"},
        "audio_outputs": ["0: card (ALSA)"],
        "midi_inputs": ["0: keys (ALSA)"],
    }
    for key, value in changes.items():
        section, _, name = key.partition("__")
        if name:
            facts[section][name] = value
        else:
            facts[section] = value
    return facts


def cell(block=64, load=0.1, missing=0, xruns=0, empty_missing=0, empty_xruns=0, stress="none"):
    def result(missing, xruns, load):
        percent = 100.0 * missing / (10_000 + missing)
        counted = {"blocks": 10_000, "missing": missing, "xruns": xruns, "missing_percent": percent}
        loads = None if load is None else {"p50": 0.5 * load, "p99": 0.9 * load, "p99.9": load, "max": 1.1 * load}
        return counted | {"load": loads, "longest_gap_ms": 3.0}

    return {
        "stress": stress,
        "words": WORDS[stress],
        "block_frames": block,
        "sources": {"compiled": result(missing, xruns, load), "empty": result(empty_missing, empty_xruns, None)},
    }


def advice(facts=None, cells=(), realtime=True, latency=0.003):
    delays = {one["block_frames"]: key_to_sound(one["block_frames"], 48000.0, latency, 480) for one in cells}
    return advise(facts or machine(), {"realtime": realtime}, list(cells), delays)


def severities(found, words):
    return [one.severity for one in found if words in one.words]


def test_a_good_machine_gets_good_words_only():
    found = advice(cells=[cell(64), cell(128)])
    assert {one.severity for one in found} == {GOOD}
    assert severities(found, "--block 64") == [GOOD]


@pytest.mark.parametrize(
    ("changes", "severity", "words"),
    [
        ({"scheduling__allowed": False, "scheduling__reason": "the limit is 0"}, PROBLEM, "the limit is 0"),
        ({"scheduling__rttime_limit_us": 200_000}, HINT, "200 ms"),
        ({"memory_lock__allowed": False, "memory_lock__reason": "64 KiB"}, HINT, "64 KiB"),
        ({"processor__governors": ["performance", "powersave"]}, HINT, "cpupower"),
        ({"processor__cores": 1}, HINT, "one processor core"),
        ({"processor__load_average": 5.5}, PROBLEM, "5.5 cores"),
        ({"processor__hypervisor": True}, HINT, "virtual machine"),
        ({"jit_cache__writable": False}, PROBLEM, "UKRT_CACHE_DIR"),
        ({"jit_cache__warm": False}, HINT, "/cache"),
        ({"libraries__portaudio": None}, PROBLEM, "libportaudio2"),
        ({"libraries__rtmidi": None}, PROBLEM, "MIDI"),
        ({"audio_outputs": []}, PROBLEM, "No audio output"),
        ({"midi_inputs": []}, HINT, "No MIDI input"),
    ],
)
def test_each_fact_has_its_advice(changes, severity, words):
    assert severities(advice(machine(**changes)), words) == [severity]
    assert severities(advice(machine()), words) == []


def test_systems_that_tell_nothing_are_not_blamed():
    unknown = machine(scheduling__allowed=None, processor__governors=None, processor__load_average=None)
    unknown["processor"]["hypervisor"] = None
    assert advice(unknown) == []


def test_a_server_without_priority_is_a_problem():
    assert severities(advice(realtime=False), "jackd -R") == [PROBLEM]


def test_who_is_to_blame():
    """What the empty callback loses as well is the machine's; the rest is the instrument's."""
    ours = advice(cells=[cell(missing=200, xruns=50)])
    assert severities(ours, "the instrument's own") == [PROBLEM]
    theirs = advice(cells=[cell(missing=200, xruns=50, empty_missing=190, empty_xruns=60, stress="gc")])
    assert severities(theirs, "the instrument's own") == []
    assert severities(theirs, "not the instrument") == [PROBLEM]
    assert severities(theirs, WORDS["gc"]) == [PROBLEM]
    assert severities(advice(cells=[cell(load=0.8)]), "80 %") == [HINT]
    assert severities(advice(cells=[cell(load=1.2)]), "larger blocks") == [PROBLEM, PROBLEM]


def test_chance_is_no_difference():
    assert not clearly_more(3, 2) and not clearly_more(0, 0) and not clearly_more(5, 50)
    assert clearly_more(12, 0) and clearly_more(200, 120)


def test_the_recommended_block_did_well_under_every_stress():
    cells = [cell(32, load=0.9), cell(64), cell(64, missing=50, stress="gc"), cell(128), cell(128, stress="gc")]
    assert recommend(cells) == 128
    assert recommend([cell(32, missing=500)]) is None
    slow = advice(cells=[cell(256)], latency=0.02)
    assert severities(slow, "35.3 ms") == [HINT]


# Counting ------------------------------------------------------------------------------------------------------------
def one_slice(source="compiled", frames=48000, missing_frames=0, xruns=0, loads=None):
    return Slice(
        source=source,
        stress="none",
        asked_block=64,
        seconds=1.0,
        frames=frames,
        blocks=frames // 64,
        missing_frames=missing_frames,
        flags={"underflows": 0},
        xruns=xruns,
        loads=loads or {0.1: 700, 0.4: 50},
        latency=0.002,
        longest_gap_ms=None,
    )


def test_missing_callbacks_are_whole_blocks():
    assert one_slice(missing_frames=63).missing == 0  # where the slice was cut
    assert one_slice(missing_frames=640).missing == 10
    assert one_slice(missing_frames=640).missing_percent == pytest.approx(100 * 10 / 760)


def test_slices_add_up():
    total = summarize([one_slice(missing_frames=640, xruns=1), one_slice(xruns=4, loads={0.1: 740, 0.9: 10})])
    assert (total["missing"], total["missing_range"], total["xruns"], total["xruns_range"]) == (10, [0, 10], 5, [1, 4])
    assert total["load"] == {"p50": 0.1, "p99": 0.4, "p99.9": 0.9, "max": 0.9}


def test_the_range_of_nothing():
    empty = [one_slice("empty", missing_frames=640), one_slice("empty", xruns=3)]
    assert within_range([one_slice(xruns=2), one_slice(xruns=4)], empty) == {"xruns": True, "missing": True}
    assert within_range([one_slice(missing_frames=64 * 30)] * 2, empty) == {"xruns": True, "missing": False}


def test_time_is_shared_in_turns():
    assert turns_of(60) == (6, pytest.approx(60 / 18))
    assert turns_of(1) == (1, pytest.approx(1 / 3))
    assert turns_of(13) == (2, pytest.approx(13 / 6))


@pytest.mark.parametrize("name", WORDS)
def test_a_stress_lasts_as_long_as_asked(name):
    began = time.monotonic()
    run_stress(name, 0.1)
    assert time.monotonic() - began >= 0.1


# On a server ---------------------------------------------------------------------------------------------------------
@pytest.fixture
def jack(tmp_path):
    """A JACK server of our own; gives the environment that leads clients to it."""
    if shutil.which("jackd") is None:
        pytest.skip("needs jackd (Debian: apt-get install jackd2)")
    name = f"ukrt-test-{uuid.uuid4().hex[:8]}"
    log = tmp_path / "jackd.log"
    with log.open("w") as file:
        command = ["jackd", "-n", name, "--no-realtime", "-d", "dummy", "-r", "48000", "-p", "128"]
        server = subprocess.Popen(command, stdout=file, stderr=subprocess.STDOUT)
    try:
        ends = time.monotonic() + 10
        wait = ["jack_wait", "-s", name, "-c"]
        while not subprocess.run(wait, capture_output=True, text=True).stdout.startswith("running"):
            if server.poll() is not None or time.monotonic() > ends:
                pytest.skip(f"jackd does not start here: {log.read_text()[-300:]}")
            time.sleep(0.1)
        yield {**os.environ, "JACK_DEFAULT_SERVER": name, "JACK_NO_START_SERVER": "1"}
    finally:
        server.terminate()
        server.wait(10)


@pytest.mark.jack
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


@pytest.mark.jack
def test_a_rate_that_the_server_does_not_run_at_is_refused(jack, ukrt_process):
    pytest.importorskip("jack")
    code, out, err = ukrt_process("doctor", "--driver", "jack", "--rate", "44100", environment=jack)
    assert (code, out) == (2, "")
    assert err.splitlines()[-1].startswith("ukrt: ") and "48000" in err
