"""``ukrt play`` on the null output: pieces, recordings, reports, guitars that change, devices that go."""

import json
import pathlib
import signal
import threading

import mido
import numpy as np
import pytest
import soundfile
from take_check import FILES, assert_take_is_what_was_heard

import ukrt.cli.play
from ukrt.cli import play_parts
from ukrt.cli.main import main
from ukrt.cli.play_parts import Way
from ukrt.drivers.files.bundled import ROMANCE
from ukrt.drivers.files.midi import load_midi_file
from ukrt.drivers.sound.null import NullOutput
from ukrt.errors import DeviceError

NULL = ("--driver", "null", "--midi-in", "none")


@pytest.fixture(autouse=True)
def quick(monkeypatch, tmp_path):
    """Open strings ring for many seconds, in which nothing new would be seen."""
    monkeypatch.setattr(ukrt.cli.play, "_TAIL_SECONDS", 0.2)
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def play(tmp_path):
    """Runs ``ukrt play`` with a recording and a report, checks that the take gives the same bits; gives the report."""

    def run(*arguments, code=0):
        assert main(["play", *map(str, arguments), *FILES]) == code
        assert_take_is_what_was_heard(tmp_path)
        return json.loads((tmp_path / "report.json").read_text())

    return run


def texts(report):
    """The news of a report, one after another."""
    times = [news["seconds"] for news in report["news"]]
    assert times == sorted(times)
    return " | ".join(news["text"] for news in report["news"])


@pytest.fixture
def on_news(monkeypatch):
    """Gives a function: when words are said, call what belongs to them, once each and in order."""
    from ukrt.cli.status import StatusLine

    say = StatusLine.say

    def react(*reactions):
        waiting = list(reactions)

        def listen(self, sentence):
            say(self, sentence)
            if waiting and waiting[0][0] in sentence:
                waiting.pop(0)[1]()

        monkeypatch.setattr(StatusLine, "say", listen)

    return react


def interrupt():
    signal.raise_signal(signal.SIGINT)


def test_a_piece_is_played_kept_and_reported(play, piece, capsys):
    report = play(piece, *NULL, "--block", 256)
    out, err = capsys.readouterr()
    assert "blocks   " in out and "notes    2, dropped 0" in out and "recorded take.mid" in out
    assert "null output" in err and err.count("\n") == 1 and "Traceback" not in err
    counters, forcing = report["counters"], 2 * 4  # for each note: string and position, told and taken back
    assert (counters["notes_on"], counters["midi_received"], counters["midi_dropped"]) == (2, 4 + forcing, 0)
    assert report["ended"] == "the piece is over" and report["seconds"] > 0.5
    assert report["fingering"]["choice"] == "look-ahead" and counters["forces_refused"] == 0
    load = report["load"]
    assert 0 < load["p50"] <= load["p99"] <= load["p99_9"] <= load["max"]
    assert sum(blocks for _, blocks in report["load_histogram"]) == counters["blocks"]
    assert report["block_size"] == 256 and report["session"]["output"] == "the null output"
    assert set(report["flags"]) == {"underflows", "overflows", "input_underflows", "input_overflows", "priming"}
    assert report["recorded"]["files"] == ["take.mid", "heard.wav"] and report["settings"]["limiter"] is True
    assert report["recorded"]["take_frames"] == report["recorded"]["sound_frames"] == counters["frames"]
    assert {"numba", "numpy", "python"} <= set(report["versions"]) and report["options"]["driver"] == "null"
    assert report["reconnections"] == report["xruns"] - report["session"]["xruns"] == 0


def test_what_was_played_is_what_would_be_rendered(tmp_path, piece):
    """The live path, its thread and its clock add nothing but a delay of whole frames, where nothing is limited."""
    assert main(["play", str(piece), *NULL, "--no-limiter", "--record-audio", "heard.wav"]) == 0
    played, _ = soundfile.read(tmp_path / "heard.wav", always_2d=True, dtype="float64")
    rendered, _ = ukrt.render(piece)
    rendered = rendered[: int(0.5 * 48000)]
    start = np.flatnonzero(np.abs(played).max(axis=1) > 0)[0] - np.flatnonzero(np.abs(rendered).max(axis=1) > 0)[0]
    best = min(
        np.abs(played[at : at + len(rendered)] - rendered).max()
        for at in range(max(0, start - 2000), start + 2000)
        if len(played) >= at + len(rendered)
    )
    assert best < 1e-6 * max(1.0, np.abs(rendered).max())  # float32 of the live path


def test_a_loop_goes_on_until_the_time_is_over(play, piece):
    report = play(piece, *NULL, "--loop", "--seconds", 2.2)
    assert report["ended"] == "2.2 s are over" and 2.2 <= report["seconds"] < 3.5
    assert report["counters"]["notes_on"] >= 6


def test_knobs_reach_the_engine(play, piece):
    report = play(piece, *NULL, "--no-limiter", "--no-shedding", "--rate", 48000, "--set", "pluck.place=0.8")
    assert report["settings"]["limiter"] is False and report["options"]["overrides"] == [["pluck.place", "0.8"]]


def test_without_a_sound_card_the_sound_goes_into_a_file(tmp_path, piece, monkeypatch, capsys):
    def nothing_there(args):
        raise DeviceError("no sound card was found")

    monkeypatch.setattr(play_parts, "_portaudio", nothing_there)
    assert main(["play", str(piece)]) == 0
    (heard,) = tmp_path.glob("ukrt-play-*.wav")
    out, err = capsys.readouterr()
    assert "no sound card was found" in err and heard.name in err and f"recorded {heard}" in out
    samples, _ = soundfile.read(heard)
    assert np.abs(samples).max() > 0.001
    for words in (("--driver", "portaudio"), ("--audio-out", "loud"), ("--latency", "low")):
        assert main(["play", str(piece), *words]) == 2, "who names a card does not want a file"


def test_programs_of_a_piece_choose_among_the_presets(play, tmp_path, on_news):
    file = mido.MidiFile(ticks_per_beat=480)
    file.tracks.append(track := mido.MidiTrack())
    for message in (
        mido.Message("note_on", note=52, velocity=90),
        mido.Message("program_change", program=7, time=240),
        mido.Message("program_change", program=1, time=0),
        mido.Message("note_on", note=64, velocity=90, time=480),
    ):
        track.append(message)
    file.save(tmp_path / "programs.mid")
    on_news(("now drop-d", interrupt))
    report = play("programs.mid", *NULL, "--preset", "classical", "--preset", "drop-d", "--loop", "--seconds", 60)
    words = texts(report)
    assert words.index("program 1: drop-d") < words.index("now drop-d") and "program 7" not in words
    assert report["counters"]["swaps"] == report["session"]["changes"] == 1 and report["guitar"] == "drop-d"
    assert report["programs"]["unknown"] >= 1 and report["counters"]["programs"] >= 2
    assert words.count("no guitar answers to program change 7") == 1 and report["counters"]["messages_ignored"] == 0
    assert report["counters"]["notes_dropped"] == 0 and report["ended"] == "interrupted"


def test_a_preset_file_is_followed_while_it_is_played(play, piece, tmp_path, on_news):
    mine = tmp_path / "mine.toml"
    versions = ["[pluck]\nplace = 0.8\n", "[pluck]\nplace = 8\n", "[pluck]\nplace = 0.85\n"]

    def write(version):
        mine.write_text('base = "classical"\n' + versions[version], encoding="utf-8")

    write(0)
    on_news(("Ctrl-C ends", lambda: write(1)), ("plays on", lambda: write(2)), ("the guitar is now", interrupt))
    report = play(piece, *NULL, "--loop", "--preset", mine, "--seconds", 60)
    words = texts(report)
    at = [words.index(w) for w in ("pluck.place", "plays on", "mine.toml has changed", "the guitar is now")]
    assert at == sorted(at) and words.count("plays on") == 1 and report["counters"]["swaps"] == 1


class Vanishing(NullOutput):
    """An output that ends by itself after half a second."""

    def __init__(self, engine):
        super().__init__(engine, 128, silent=True)
        self.name = "the card"

    def start(self):
        super().start()
        threading.Timer(0.5, self._stop.set).start()


@pytest.mark.parametrize("comes_back", [True, False])
def test_an_output_that_goes_is_replaced_and_told_at_the_end(play, piece, monkeypatch, capsys, comes_back):
    opened = []

    def open_output(engine):
        opened.append(engine)
        if len(opened) == 1:
            return Vanishing(engine)
        if not comes_back:
            raise DeviceError("the card is still not there")
        return NullOutput(engine, 64, silent=True)

    monkeypatch.setattr(ukrt.cli.play, "find_way", lambda args: Way("portaudio", 48000.0, open_output))
    report = play(piece, "--midi-in", "none", "--loop", "--seconds", 2.5, code=0 if comes_back else 1)
    words = texts(report)
    assert "the card has ended" in words and report["reconnections"] == comes_back
    assert ("null output is back" in words, "still not there" in words) == (comes_back, not comes_back)
    assert report["counters"]["notes_on"] >= 6, "the piece goes on meanwhile"
    assert ("while the output was away" in capsys.readouterr().err) == (not comes_back)


def test_a_session_that_never_began_leaves_no_file(piece, tmp_path, monkeypatch, capsys):
    def refuse(engine):
        raise DeviceError("the card is taken")

    monkeypatch.setattr(ukrt.cli.play, "find_way", lambda args: Way("portaudio", 48000.0, refuse))
    assert main(["play", str(piece), *FILES]) == 2
    assert capsys.readouterr().err == "ukrt: the card is taken\n"
    assert [path.name for path in tmp_path.iterdir()] == ["piece.mid"]


def test_a_fault_of_the_program_is_reported_and_shown(tmp_path, piece, monkeypatch):
    def fail(self):
        raise ZeroDivisionError("what a fault")

    monkeypatch.setattr(ukrt.cli.play.Playing, "_choose_program", fail)
    with pytest.raises(ZeroDivisionError):
        main(["play", str(piece), *NULL, "--record", "take.mid", "--report", "report.json"])
    assert "what a fault" in json.loads((tmp_path / "report.json").read_text())["ended"]
    assert main(["render", "take.mid", "-o", "again.wav"]) == 0


def test_the_bundled_piece_has_two_voices_and_a_minute():
    score = load_midi_file(ROMANCE)
    assert score.duration_s >= 60 and score.n_notes > 100 and score.warnings == ()
    assert pathlib.Path(ROMANCE).is_relative_to(pathlib.Path(ukrt.__file__).parent)
