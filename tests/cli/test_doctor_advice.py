"""What ``ukrt doctor`` advises for machines that are made up here, and how it counts."""

import time

import pytest

from ukrt.cli.doctor import turns_of
from ukrt.drivers.doctor.advice import GOOD, HINT, PROBLEM, advise, clearly_more, key_to_sound, recommend
from ukrt.drivers.doctor.measure import Slice, summarize, within_range
from ukrt.drivers.doctor.stress import WORDS, run_stress


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
        block=64.0,
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
