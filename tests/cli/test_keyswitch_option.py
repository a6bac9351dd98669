"""``--keyswitches`` on the command line."""

import argparse

import mido
import pytest

from ukrt.cli.common import given_settings
from ukrt.cli.main import main
from ukrt.cli.play_options import add_options


@pytest.fixture
def song(tmp_path):
    """Two overlapping notes after key 22, which stands for legato."""
    file = mido.MidiFile(ticks_per_beat=96)
    track = file.add_track("Slur")
    messages = (("note_on", 22, 0), ("note_off", 22, 0), ("note_on", 60, 0), ("note_on", 62, 96))
    for kind, key, time in (*messages, ("note_off", 60, 10), ("note_off", 62, 96)):
        track.append(mido.Message(kind, note=key, time=time))
    file.save(tmp_path / "song.mid")
    return tmp_path / "song.mid"


@pytest.mark.parametrize("choice", ["look-ahead", "causal"])
def test_a_switch_slurs_and_is_no_note(capsys, song, choice):
    assert main(["tab", str(song), "--keyswitches", "--fingering", choice]) == 0
    switched, _ = capsys.readouterr()
    assert "h3" in switched and "not played" not in switched
    assert main(["tab", str(song), "--fingering", choice]) == 0
    plain, _ = capsys.readouterr()
    assert "h3" not in plain


def test_keys_within_the_range_are_refused_before_anything_is_written(capsys, song, tmp_path):
    path = tmp_path / "tab.txt"
    wrong = ["tab", str(song), "--keyswitches", "--set", "playing.keyswitch_key=35", "-o", str(path)]
    assert main(wrong) == 2 and not path.exists()
    _, err = capsys.readouterr()
    assert "playing.keyswitch_key is 35" in err and "must lie outside the guitar's keys, 40 to 83" in err
    assert err.count("\n") == 1


def test_play_has_it_too_and_it_is_named_as_written():
    parser = argparse.ArgumentParser()
    add_options(parser)
    overrides = parser.parse_args(["--keyswitches"]).overrides
    assert overrides == [("playing.keyswitches", "on")] and given_settings(overrides) == ["--keyswitches"]
