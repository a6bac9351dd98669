"""What MIDI channels stand for, from the command line: options, refusals, tablature, takes that replay alone."""

import tomllib

import mido
import numpy as np
import pytest
import soundfile

import ukrt
from ukrt.cli.main import main
from ukrt.drivers.takes.recorder import Recorder
from ukrt.engine.engine import Engine
from ukrt.model.presets import load_preset


@pytest.fixture
def strings(tmp_path):
    """A MIDI guitar's file: B4 on channel 7, the third string when channel 5 is the highest, slurred to C5."""
    track = mido.MidiTrack()
    for kind, key, time in (("note_on", 71, 0), ("note_on", 72, 480), ("note_off", 71, 10), ("note_off", 72, 470)):
        track.append(mido.Message(kind, channel=6, note=key, time=time))
    path = tmp_path / "strings.mid"
    mido.MidiFile(tracks=[track]).save(path)
    return path


def test_options_are_short_for_keys_and_presets_keep_them(capsys):
    assert main(["presets", "classical", "--mode", "guitar", "--base-channel", "5"]) == 0
    playing = tomllib.loads(capsys.readouterr().out)["playing"]
    assert (playing["midi_mode"], playing["base_channel"]) == ("guitar", 5)


@pytest.mark.parametrize(
    ("argv", "words"),
    [
        (("--mode", "piano"), ("playing.midi_mode", "piano", "guitar-mpe")),
        (("--base-channel", "17"), ("playing.base_channel", "17", "1 to 16")),
        (("--mode", "guitar", "--base-channel", "12"), ("playing.base_channel", "12", "1 to 11")),
    ],
)
@pytest.mark.parametrize("command", ["tab", "render"])
def test_refusals(capsys, tmp_path, strings, command, argv, words):
    target = tmp_path / ("a.wav" if command == "render" else "a.txt")
    assert main([command, str(strings), "-o", str(target), *argv]) == 2
    out, err = capsys.readouterr()
    assert out == "" and err.count("\n") == 1 and all(word in err for word in words)
    assert not list(tmp_path.glob("a.*"))


def test_tablature_shows_the_strings_that_were_sent(capsys, strings):
    assert main(["tab", str(strings), "--mode", "guitar", "--base-channel", "5"]) == 0
    (line,) = [line for line in capsys.readouterr().out.splitlines() if "16" in line]
    assert line.startswith("G3|") and "h17" in line


def test_python_renders_in_a_mode(strings):
    overrides = {"playing.midi_mode": "guitar", "playing.base_channel": "5"}
    _, report = ukrt.render(strings, overrides=overrides, end=0.1)
    assert [note["string"] for note in report["notes"]] == [3]
    assert report["fingering"]["choice"] == "causal" and "guitar" in report["fingering"]["why"]


def test_a_take_of_a_mode_replays_alone(tmp_path):
    settings = {"playing.midi_mode": "guitar-mpe"}
    engine = Engine(load_preset("classical", settings), 44100, shared=True)
    recorder = Recorder(engine, tmp_path / "take.mid", tmp_path / "take.wav")
    for frame, *message in ((100, 0xE2, 0, 72), (200, 0x92, 60, 100), (3000, 0x92, 62, 90), (4000, 0xE0, 0, 90)):
        engine.send(frame, *message)
    engine.process_card(12_000)
    assert [note["articulation"] for note in engine.note_log()] == ["pluck", "hammer-on"]
    recorder.close()
    engine.close()
    assert main(["render", str(tmp_path / "take.mid"), "-o", str(tmp_path / "out.wav")]) == 0
    heard, again = (soundfile.read(tmp_path / name, dtype="float32")[0] for name in ("take.wav", "out.wav"))
    assert np.any(heard) and np.array_equal(heard.view(np.uint32), again.view(np.uint32))
