"""``ukrt play --learn``: what is typed and moved becomes a file, and what that says is heard; on JACK and RtMidi."""

import json
import signal
import threading
import time

import mido
import numpy as np
import pytest
from drivers.midi_rig import Sender
from jack_play import ended
from jack_servers import NEEDS_JACK

from ukrt.cli import learning
from ukrt.cli.learning import Controllers, Learning, wanted_functions
from ukrt.cli.main import main
from ukrt.cli.play_options import check_options
from ukrt.cli.play_parts import find_controllers
from ukrt.drivers.midi.listen import SETTLE_SECONDS
from ukrt.drivers.midi.mapping import Mapped, Mapping, load_mapping, mapping_text
from ukrt.engine import stage_layout as at
from ukrt.engine.map_layout import mapped
from ukrt.engine.stage import Stage
from ukrt.errors import PresetError
from ukrt.model.presets import preset_names


class World:
    """A dialogue with everything it touches; time passes as the test says."""

    def __init__(self, folder, monkeypatch, names=(), *mapped_ones):
        self.now, self.said, self.sent, self.stage = 100.0, [], [], Stage(2)
        self._typed, self._read = [], threading.Semaphore(0)
        monkeypatch.setattr(learning.time, "monotonic", lambda: self.now)
        self.controllers = Controllers(Mapping(mapped_ones), folder / "new" / "controllers.toml")
        self.learning = Learning(self, self.controllers, list(names), self.said.append, self._line)

    def send(self, _frame, *message):
        self.sent.append(message)

    def _line(self):
        self._read.acquire()
        return self._typed.pop(0)

    def type(self, *lines):
        for line in lines:
            self._typed.append(line.encode())
            self._read.release()
            while self.learning._lines.empty():
                pass
            self.learning.turn()

    def move(self, status, number, values):
        """Move a knob, then let it rest."""
        words = [at.KIND_MIDI << at.KIND_SHIFT | status << 16 | number << 8 | value for value in values]
        self.learning.hear(np.array([(0, word) for word in words], np.int64))
        for _ in range(2):
            self.learning.turn()
            self.now += SETTLE_SECONDS + 0.1

    def meaning(self, status, number, value):
        word = mapped(self.stage.si, status << 16 | number << 8 | value)
        return word >> 16, word >> 8 & 0xFF, word & 0xFF


def test_functions_that_were_named_are_learned_one_after_another_and_kept(tmp_path, monkeypatch):
    world = World(tmp_path, monkeypatch, ["vibrato", "mute"])
    world.move(0xB0, 30, range(0, 120, 5))
    assert "heard CC 30 of channel 1, 0 to 115: CC 30 of channel 1 plays vibrato; kept in" in world.said[-2]
    assert world.meaning(0xB0, 30, 9) == (0xB0, 30, 9), "while it listens, all mean what their numbers say"
    world.move(0xB0, 31, (127,))
    assert world.learning.over and world.meaning(0xB0, 30, 9) == (0xB0, 1, 9)
    assert world.meaning(0xB0, 31, 127) == (0xB0, 19, 127)
    assert load_mapping(world.controllers.path) == world.controllers.mapping
    assert {message[:2] for message in world.sent} == {(0xB0 | channel, 121) for channel in range(16)}


def test_a_box_of_knobs_on_another_channel_plays_the_keyboards_notes(tmp_path, monkeypatch):
    world = World(tmp_path, monkeypatch, ["place"])
    world.move(0x94, 60, (90,))
    world.move(0xBF, 12, range(128))
    assert world.meaning(0xBF, 12, 3) == (0xB4, 74, 3)


def test_what_is_typed(tmp_path, monkeypatch):
    world = World(tmp_path, monkeypatch, (), Mapped("mute", "CC 2", 1), Mapped("legato", "CC 3", 1))
    world.type("place\n")
    world.move(0xE0, 0, range(64, 128))
    assert [str(one) for one in world.controllers.mapping.controllers][-1] == "bend of channel 1 plays place"
    world.type("forget mute\n", "banjo\n", "list\n")
    assert "'banjo' is not understood" in world.said[-2] and "CC 3 of channel 1 plays legato" in world.said[-1]
    assert load_mapping(world.controllers.path).without("place").without("legato") == Mapping()
    world.type("vibrato\n", "")
    assert world.learning.over and world.meaning(0xB0, 3, 1) == (0xB0, 68, 1), "given up, what was known counts again"
    assert [one.function for one in load_mapping(world.controllers.path).controllers] == ["legato", "place"]


def test_clear(tmp_path, monkeypatch):
    world = World(tmp_path, monkeypatch, (), Mapped("mute", "CC 2"))
    world.type("clear\n")
    assert load_mapping(world.controllers.path) == Mapping() and world.meaning(0xB0, 2, 1) == (0xB0, 2, 1)


def test_a_file_that_cannot_be_written_is_told(tmp_path, monkeypatch):
    (tmp_path / "new").write_text("in the way")
    world = World(tmp_path, monkeypatch, ["mute"])
    world.move(0xB0, 2, range(99))
    assert any("but it cannot be kept" in words for words in world.said) and world.learning.over


# Options --------------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("words", "argv"),
    [
        ("--learn banjo: no function is called so", "--learn vibrato,banjo"),
        ("leave --no-mapping away", "--learn --no-mapping"),
        ("leave --no-mapping away", "--learn --mapping none"),
        ("plays no piece; leave a.mid away", "a.mid --learn"),
        ("listens for ever", "--learn --midi-in none"),
        ("absent.toml cannot be read", "--driver null --mapping absent.toml"),
        ("not allowed with", "--mapping x --no-mapping"),
    ],
)
def test_contradictions_are_refused_in_a_sentence(capsys, tmp_path, monkeypatch, words, argv):
    monkeypatch.chdir(tmp_path)
    assert main(["play", *argv.split()]) == 2
    out, err = capsys.readouterr()
    assert out == "" and err.startswith("ukrt: ") and err.count("\n") == 1 and words in err


def test_which_file_counts(tmp_path, monkeypatch):
    from test_play_options import parsed

    mine, usual = Mapping((Mapped("mute", "CC 2"),)), Mapping((Mapped("place", "CC 3"),))
    monkeypatch.setenv("UKRT_CONFIG_DIR", str(tmp_path))
    assert find_controllers(parsed()).mapping == Mapping(), "none has been learned yet"
    (tmp_path / "mine.toml").write_text(mapping_text(mine))
    (tmp_path / "controllers.toml").write_text(mapping_text(usual))
    assert find_controllers(parsed()).mapping == usual
    assert find_controllers(parsed("--mapping", str(tmp_path / "mine.toml"))).mapping == mine
    for away in (["--no-mapping"], ["--mapping", "none"]):
        assert find_controllers(parsed(*away)).describe() == {"file": None, "controllers": []}
    new = parsed("--learn", "--mapping", str(tmp_path / "new.toml"))
    check_options(new)
    assert find_controllers(new).path == tmp_path / "new.toml"
    (tmp_path / "controllers.toml").write_text("controllers = 1")
    with pytest.raises(PresetError, match=r"controllers\.toml: controllers"):
        find_controllers(parsed())


def test_names_are_taken_once():
    assert wanted_functions(" mute, place,mute ") == ["mute", "place"] and wanted_functions("") == []


# With everything ------------------------------------------------------------------------------------------------------
@NEEDS_JACK[0]
@NEEDS_JACK[1]
def test_what_is_learned_on_jack_is_played_through_rtmidi(begin, server, tmp_path, monkeypatch):
    """And neither take needs the mapping to be repeated bit for bit (`ended` renders it)."""
    pytest.importorskip("rtmidi")
    server.environment["UKRT_CONFIG_DIR"] = str(tmp_path / "settings")
    server.lead(monkeypatch)
    sweep = [(0xB2, 30, value) for value in range(0, 128, 4)]
    with Sender("knobs") as sender:
        playing = begin("--driver", "jack", "--midi-in", "knobs", "--learn", "vibrato", "--seconds", 30)
        read_until(playing, "move its knob")
        sender.send((0x92, 52, 100), *sweep, step=0.01)
        read_until(playing, "learn: over")
        sender.send((0x92, 57, 100), (0xB2, 30, 99), step=0.01)
        time.sleep(0.5)
        take = finished(playing, tmp_path)
        assert (30, 124) in take and (1, 99) in take and (30, 99) not in take
        (mapped_one,) = load_mapping(tmp_path / "settings" / "controllers.toml").controllers
        assert mapped_one == Mapped("vibrato", "CC 30", 3)

        playing = begin("--driver", "null", "--midi-in", "knobs", "--seconds", 4)
        assert "CC 30 of channel 3 plays vibrato" in playing.stderr.readline()
        read_until(playing, "listening to knobs")
        sender.send((0x92, 52, 100), (0xB2, 30, 77), (0xB2, 31, 78), step=0.01)
        sender.send((0xB2, 32, 1), (0xC2, preset_names().index("drop-d")))
        read_until(playing, "the guitar is now drop-d")
        assert {(1, 77), (31, 78), (32, 1)} <= (take := finished(playing, tmp_path, None)) and (30, 77) not in take
        report = json.loads((tmp_path / "report.json").read_text())
        assert report["guitar"] == "drop-d" and report["programs"] == {"chosen": 1, "unknown": 0}
        assert report["counters"]["controllers_ignored"] == 1, "CC 31 alone"
        assert report["mapping"]["controllers"] == ["CC 30 of channel 3 plays vibrato"]


def read_until(playing, words):
    while words not in (line := playing.stderr.readline()):
        assert line, f"ukrt play ended before it said {words!r}"


def finished(playing, folder, with_signal=signal.SIGINT):
    """Wait for the end; the take's controllers (set of (number, value)), and nothing is left of it."""
    if with_signal is not None:
        playing.send_signal(with_signal)
    ended(playing, folder)
    messages = [message for message in mido.MidiFile(folder / "take.mid") if message.type == "control_change"]
    for name in ("take.mid", "heard.wav", "again.wav"):
        (folder / name).unlink()
    return {(message.control, message.value) for message in messages}
