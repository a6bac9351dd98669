"""``ukrt render`` on takes: as they were played by default, as any MIDI file where something else is asked for."""

import json

import numpy as np
import pytest
import soundfile

from ukrt.cli.main import main
from ukrt.drivers.takes.recorder import Recorder
from ukrt.engine.engine import Engine
from ukrt.model.presets import load_preset

RATE = 44100


@pytest.fixture
def take(tmp_path):
    """A take of half a second with two notes of the drop-d guitar, beside the recording of its sound."""
    engine = Engine(load_preset("drop-d"), RATE, shared=True)
    engine.output_gain = 20.0
    recorder = Recorder(engine, tmp_path / "take.mid", tmp_path / "take.wav")
    engine.send(100, 0x90, 38, 100)
    engine.send(5000, 0x90, 62, 90)
    engine.process_card(RATE // 2)
    recorder.close()
    engine.close()
    return tmp_path / "take.mid"


def render(*argv):
    return main(["render", *map(str, argv)])


def sound(path):
    return soundfile.read(path, dtype="float32")[0]


@pytest.mark.parametrize("options", [(), ("--block", 7), ("--rate", RATE, "--signal", "pressure", "--bits", "32f")])
def test_a_take_is_rendered_bit_for_bit_as_it_was_played(capsys, tmp_path, take, options):
    target = tmp_path / "out.wav"
    assert render(take, "-o", target, "--report", tmp_path / "out.json", *options) == 0
    out, err = capsys.readouterr()
    assert "bit for bit" in out and err == ""
    heard = sound(tmp_path / "take.wav")
    np.testing.assert_array_equal(sound(target).view(np.uint32), heard.view(np.uint32))
    assert len(heard) == RATE // 2 and np.any(heard)
    info = soundfile.info(target)
    assert (info.samplerate, info.subtype) == (RATE, "FLOAT")
    told = json.loads((tmp_path / "out.json").read_text())
    assert (told["preset"], told["notes_total"], told["frames"]) == ("drop-d", 2, RATE // 2)
    assert [note["midi"] for note in told["notes"]] == [38, 62]


def test_a_part_of_a_take_is_that_of_the_whole(capsys, tmp_path, take):
    options = ("--from", 0.05, "--to", "0:00.3", "--report", tmp_path / "out.json")
    assert render(take, "-o", tmp_path / "out.wav", *options) == 0
    assert "bit for bit" in capsys.readouterr().out
    heard = sound(tmp_path / "take.wav")[round(0.05 * RATE) : round(0.3 * RATE)]
    np.testing.assert_array_equal(sound(tmp_path / "out.wav").view(np.uint32), heard.view(np.uint32))
    told = json.loads((tmp_path / "out.json").read_text())
    assert [note["midi"] for note in told["notes"]] == [62] and told["frames"] == len(heard)
    for options, words in ((("--from", "bar:2"), "is a take"), (("--from", "1"), "the take ends at 0.5 s")):
        assert render(take, "-o", tmp_path / "none.wav", *options) == 2
        assert words in capsys.readouterr().err and not (tmp_path / "none.wav").exists()


OTHERWISE = [
    (("--preset", "classical"), "--preset"),
    (("--set", "pluck.place=0.7"), "--set"),
    (("--capo", 2), "--capo"),
    (("--rate", 48000), "--rate"),
    (("--signal", "strings"), "--signal"),
    (("--gain", "-3"), "--gain"),
    (("--normalize",), "--normalize"),
    (("--tail-db", "-20"), "--tail-db"),
    (("--fingering", "look-ahead"), "--fingering"),
]


@pytest.mark.parametrize(("options", "name"), OTHERWISE)
def test_what_is_asked_for_otherwise_is_rendered_like_any_midi_file_with_a_note(capsys, tmp_path, take, options, name):
    target, report = tmp_path / "out.wav", tmp_path / "out.json"
    assert render(take, "-o", target, "--report", report, *options) == 0
    out, err = capsys.readouterr()
    assert f"with {name} the take" in err and err.count("\n") == 1 and "bit for bit" not in out
    told, info = json.loads(report.read_text()), soundfile.info(target)
    assert told["preset"] == ("classical" if name == "--preset" else "drop-d")
    assert info.samplerate == (48000 if name == "--rate" else RATE) and info.subtype == "PCM_24"
    assert info.channels == (6 if name == "--signal" else 2)
    assert told["notes_total"] == 2
    assert told["fingering"]["choice"] == ("look-ahead" if name == "--fingering" else "causal")


def test_the_recording_beside_the_take_is_not_written_over(capsys, tmp_path, take):
    heard = (tmp_path / "take.wav").read_bytes()
    assert render(take) == 2
    assert "--force" in capsys.readouterr().err and (tmp_path / "take.wav").read_bytes() == heard


def test_flac_holds_24_bits(capsys, tmp_path, take):
    assert render(take, "-o", tmp_path / "out.flac") == 0
    assert soundfile.info(tmp_path / "out.flac").subtype == "PCM_24" and "bit for bit" not in capsys.readouterr().out


def test_a_broken_take_is_rendered_as_far_as_it_goes_and_a_hopeless_one_refused(capsys, tmp_path, take):
    data = take.read_bytes()
    take.write_bytes(data[:-3])
    assert render(take, "-o", tmp_path / "out.wav") == 0
    out, err = capsys.readouterr()
    assert "breaks off" in err and err.count("\n") == 1 and "bit for bit" not in out
    (tmp_path / "out.wav").unlink()
    take.write_bytes(data[:3000])
    assert render(take, "-o", tmp_path / "out.wav") == 2
    err = capsys.readouterr().err
    assert "take.mid" in err and err.count("\n") == 1 and not (tmp_path / "out.wav").exists()
