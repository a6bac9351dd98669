"""What ``tools/bench_peers`` plays, counts and leaves out; no peer is needed here."""

import dataclasses
import io
import pathlib
import struct
import sys

import mido
import numpy as np
import pytest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tools"))

from peers import csound, faust, install, measure, paper_numpy, piece, supercollider, tables
from peers.__main__ import PEERS, chosen, prepared
from peers.modes import modes
from peers.peer import Peer, PeerError, Ready, Work, last_line, program_path
from rich.console import Console

from ukrt.experiment.case import Case, HeldString
from ukrt.model.presets import load_preset
from ukrt.reference import definition
from ukrt.reference.system import make_system

SOUND = "import sys, numpy, soundfile; n = int(48000 * float(sys.argv[1])); "


def sounding(events):
    """The most that sound at once, ends before beginnings at the same time."""
    now = most = 0
    for _, is_on, _ in events:
        now += 1 if is_on else -1
        most = max(most, now)
    assert now == 0
    return most


@pytest.mark.parametrize("seed", (piece.SEED, 1, 2))
def test_the_piece_can_be_played_on_six_strings(seed):
    notes = piece.make_piece(seed)
    assert len(notes) == 495
    assert sounding(piece.events(notes)) <= 6 == len(piece.OPEN_KEYS)
    assert max(note.end for note in notes) <= 60.0
    for string, open_key in enumerate(piece.OPEN_KEYS):
        mine = [note for note in notes if note.string == string]
        assert all(0 <= note.key - open_key <= 12 for note in mine)
        assert all(one.end < two.start for one, two in zip(mine, mine[1:], strict=False))
    for bar in range(30):  # what is stopped in a bar lies under one hand
        held = [note for note in notes if 2 * bar <= note.start < 2 * (bar + 1)]
        frets = {note.key - piece.OPEN_KEYS[note.string] for note in held} - {0}
        assert max(frets) - min(frets) <= 3


def test_the_piece_is_always_the_same_and_six_sound_at_once():
    assert piece.make_piece() == piece.make_piece()
    assert sounding(piece.events(piece.make_piece())) == 6


@pytest.mark.parametrize(("seconds", "count"), ((60.0, 495), (1.0, 9)))
def test_the_midi_file_holds_the_piece(tmp_path, seconds, count):
    path = pathlib.Path(Work(tmp_path).midi(seconds))
    file = mido.MidiFile(path)
    assert file.length == pytest.approx(seconds, abs=1e-3)
    on = [message.note for message in file if message.type == "note_on"]
    assert on == [note.key for note in sorted(piece.make_piece(), key=lambda n: n.start)[:count]]
    assert sum(message.type == "note_off" for message in file) == count


def test_the_price_of_starting_is_taken_out():
    for start_s in (0.0, 3.0):
        assert measure.times_real_time((1.0, start_s + 0.02), (60.0, start_s + 1.2)) == pytest.approx(50.0)
    with pytest.raises(PeerError, match="too short"):
        measure.times_real_time((1.0, 0.2), (60.0, 0.2))


def peer(name, words, **how):
    """A peer that is a Python one-liner: SECONDS OUT.wav."""

    def command(seconds, target):
        return [sys.executable, "-c", words, str(seconds), target]

    return Peer(name, "nothing", ("nothing-of-the-kind",), lambda _: Ready(command, "1", **how))


def test_what_is_missing_or_broken_is_named_and_left_out(tmp_path):
    write = "soundfile.write(sys.argv[2], 0.1 * numpy.sin(numpy.arange({n}){to}), 48000)"
    work_enough = "sum(k * k for k in range(n)); "  # so that the longer render costs more
    peers = [
        peer("good", SOUND + work_enough + write.format(n="n", to="")),
        Peer("absent", "nothing", ("no-such-package",), lambda _: program_path("no-such-program")),
        peer("silent", SOUND + write.format(n="n", to=" * 0")),
        peer("short", SOUND + write.format(n="n // 2", to="")),
        peer("broken", "raise SystemExit('error: no font')"),
        peer("mute", ""),
    ]
    work = Work(tmp_path)
    ready, left_out = prepared(peers, work, {}, lambda _: None)
    assert left_out == {"absent": "no-such-program is not installed (Debian: no-such-package)"}
    results, failed = measure.in_turns(ready, (1.0, 20.0), 2, work, lambda _: None)
    assert list(results) == ["good"] and len(results["good"]["runs"]) == 2
    assert "no sound" in failed.pop("silent") and "instead of" in failed.pop("short")
    assert failed == {"broken": "error: no font", "mute": "it wrote no sound file"}

    [row] = tables.speed_rows(peers, ready, results)
    assert row["of_ukrt"] is None and row["times_real_time"] == pytest.approx(np.median(row["runs"]))
    page = io.StringIO()
    Console(file=page, width=140).print(tables.speed_table([row]))
    assert "good" in page.getvalue() and "absent" not in page.getvalue()
    assert tables.left_out_lines(left_out) == [f"left out: absent: {left_out['absent']}"]


def test_a_system_that_counts_its_own_time_is_believed(tmp_path):
    words = (
        SOUND + "soundfile.write(sys.argv[2], 0.1 * numpy.sin(numpy.arange(n)), 48000); print('said', n / 48000 / 8)"
    )
    ready = {"own": peer("own", words, counts_itself=True).prepare(None)}
    results, failed = measure.in_turns(ready, (1.0, 3.0), 1, Work(tmp_path), lambda _: None)
    assert results["own"]["runs"] == [pytest.approx(8.0)] and not failed


def test_why_a_package_could_not_be_installed_is_told(tmp_path):
    absent = Peer("absent", "nothing", ("no-such-package",), lambda _: program_path("no-such-program"))
    _, left_out = prepared([absent], Work(tmp_path), {"no-such-package": "E: Unable to locate"}, lambda _: None)
    assert left_out["absent"].startswith("E: Unable to locate")


def test_no_peer_takes_another_package_away(monkeypatch):
    """Commands as apt-get would get them, in their order: JACK 2's headers before what would else bring JACK 1's."""
    commands = []
    monkeypatch.setattr(install.os, "geteuid", lambda: 0, raising=False)
    monkeypatch.setattr(install, "_is_installed", lambda name: name == "g++")
    monkeypatch.setattr(install, "called", lambda *words, **_: commands.append(words))
    assert install.install([name for one in PEERS for name in one.packages], lambda _: None) == {}
    assert commands[0][:2] == ("apt-get", "update")
    assert all(words[1] == "install" and "--no-remove" in words for words in commands[1:])
    names = [words[-1] for words in commands[1:]]
    assert names.index("libjack-jackd2-dev") < names.index("libstk-dev") and "g++" not in names


def test_ratios_are_those_within_a_turn():
    ours, other = PEERS[0], dataclasses.replace(PEERS[0], name="other")
    ready = dict.fromkeys((ours.name, "other"), Ready(list, "1"))
    results = {ours.name: {"runs": [10.0, 20.0, 40.0]}, "other": {"runs": [20.0, 40.0, 40.0]}}
    rows = tables.speed_rows((ours, other), ready, results)
    assert [row["of_ukrt"] for row in rows] == [1.0, 2.0]
    assert [row["times_real_time"] for row in rows] == [20.0, 40.0]


def test_systems_are_chosen_by_parts_of_their_names():
    assert [one.name for one in chosen(PEERS, "stk, klank")] == [
        "STK Guitar",
        "STK Plucked",
        "SuperCollider Klank, 800 modes",
    ]
    assert chosen(PEERS, None) == list(PEERS)


def test_the_last_line_is_one_that_speaks_of_an_error():
    assert last_line("loading\nfluidsynth: error: no such file\n\ndone\n") == "fluidsynth: error: no such file"
    assert last_line("one\ntwo\n\n") == "two" and last_line("") == ""


def test_every_bank_has_the_same_800_modes():
    wanted = [hz for hz, _, _ in modes()]
    assert len(wanted) == 800 and max(wanted) < 48000 / np.pi  # beyond it Csound's mode is unstable
    assert faust.bank().count("pm.modeFilter(") == 800
    assert csound.orchestra().count(" mode gastrike") == 800
    data = supercollider.definition()
    name = data.index(b"\x05Klank") + 6
    rate, inputs, outputs = struct.unpack(">bii", data[name : name + 9])
    assert (rate, inputs, outputs) == (2, 4 + 3 * 800, 1)


def test_a_score_of_supercollider_strikes_every_note():
    notes, at, stamps, strikes = piece.make_piece(), 0, [], 0
    data = supercollider.score(notes, 60.0)
    while at < len(data):
        (size,) = struct.unpack(">i", data[at : at + 4])
        bundle = data[at + 4 : at + 4 + size]
        assert bundle.startswith(b"#bundle\0") and size % 4 == 0
        whole, fraction = struct.unpack(">II", bundle[8:16])
        stamps.append(whole + fraction / 2**32)
        strikes += bundle[20:].startswith(b"/n_set\0")
        at += 4 + size
    assert strikes == 495 and stamps == sorted(stamps) and stamps[-1] == 60.0


def test_the_quick_scheme_is_the_papers():
    """Against the plain definition, linear, in the first 12 ms of a pluck: pull and release are in it."""
    guitar = load_preset("paper")
    slack = tuple(dataclasses.replace(string, axial_stiffness=0.0) for string in guitar.strings)
    loose = dataclasses.replace(guitar, strings=slack)
    seconds, step = 0.012, paper_numpy.STEP
    system = make_system(loose, Case("test", seconds, loose, held=(HeldString("E2", 0.2509),)).held_points(0.0))
    note = piece.Note(0.0, 1.0, 1, 45, 100)
    found = paper_numpy.run(system, [note], seconds)

    steps = int(round(seconds / step))
    ramp = np.arange(1, steps + 1) * paper_numpy.PULL_N * note.velocity / 127 / (paper_numpy.PULL_S / step)
    ramp[int(round(paper_numpy.PULL_S / step)) :] = 0.0
    shape = system.shape(1, paper_numpy.PLACE * system.modes[1].length, "Y")
    still, b = np.zeros((3, system.count)), np.zeros((steps, len(system.A)))
    _, v, _ = definition.run(system, still, step, ramp[:, None], shape[None, :], b, range(0, steps, paper_numpy.KEEP))
    expected = v[:, system.body].sum(axis=1)
    assert np.abs(found - expected).max() < 1e-9 * np.abs(expected).max()
