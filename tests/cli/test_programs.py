"""Program changes and banks: which guitar they choose."""

import numpy as np
import pytest

from ukrt.cli.main import main
from ukrt.cli.preset_shelf import PresetShelf
from ukrt.cli.programs import Programs
from ukrt.engine import stage_layout as at
from ukrt.model.presets import preset_names


class World:
    def __init__(self, *names, overrides=None, of_piece=False):
        self.shelf = PresetShelf(names or ["classical"], overrides)
        self.programs = Programs(self.shelf, of_piece)

    def send(self, *messages, kind=at.KIND_MIDI):
        """Messages in the journal; what is said about them, in one piece."""
        words = [kind << at.KIND_SHIFT | int.from_bytes(bytes(message).ljust(3, b"\0")) for message in messages]
        self.programs.follow(np.array([(k, word) for k, word in enumerate(words)], np.int64))
        return " | ".join(self.programs.look())

    @property
    def guitar(self):
        return self.shelf.guitar.name


def bank(upper, lower, channel=0):
    return (0xB0 | channel, 0, upper), (0xB0 | channel, 32, lower)


def test_bank_0_holds_what_was_named():
    world = World("drop-d", "classical")
    assert world.send((0xC3, 1)) == "program 1: classical" and world.guitar == "classical"
    assert world.send((0xC3, 1)) == "", "it is chosen already"
    assert world.send((0xC3, 1), (0xC0, 0), (0xC0, 0)) == "program 0: drop-d"
    assert world.programs.counts() == {"chosen": 5, "unknown": 0}


@pytest.mark.parametrize(("upper", "lower"), [(1, 0), (0, 1), (1, 1)])
def test_bank_1_holds_all_that_come_with_the_program(upper, lower):
    world = World("classical", "drop-d", overrides={"pluck.place": "0.8"})
    for program, name in enumerate(preset_names()):
        world.send(*bank(upper, lower), (0xC0, program))
        assert world.guitar == name and world.shelf.guitar.pluck.place == 0.8
    assert len(world.shelf.names) == len(set(world.shelf.names)) == len(preset_names())
    assert "no guitar" in world.send((0xC0, len(preset_names())))
    assert world.send(*bank(0, 0), (0xC0, 2)) == "" and world.programs.unknown == 2, "bank 0 has not grown"


def test_banks_belong_to_channels_until_a_system_reset():
    world = World()
    world.send(*bank(0, 1, 5))
    ukulele = preset_names().index("ukulele")
    assert "no guitar" in world.send((0xC4, ukulele)) and world.guitar == "classical"
    assert world.send((0xC5, ukulele)) == f"program {ukulele} of bank 1: ukulele"
    world.send((0xFF,))
    assert world.send((0xC5, 0)) == "program 0: classical"


def test_programs_of_general_midi_change_nothing_and_are_told_once():
    world = World("classical", "drop-d")
    said = world.send((0xC0, 25), *bank(121, 1), (0xC0, 0), *bank(0, 8), (0xC0, 24), (0xC9, 1))
    assert said.startswith("no guitar answers to program change 25 of bank 0; the guitar stays") and "|" not in said
    assert world.send((0xC2, 30)) == "" and world.guitar == "classical"
    assert world.programs.counts() == {"chosen": 0, "unknown": 4}


def test_a_piece_cannot_ask_for_what_was_not_named():
    world = World("classical", "drop-d", of_piece=True)
    assert "of bank 1" in world.send(*bank(0, 1), (0xC0, 1)) and world.guitar == "classical"
    assert world.send(*bank(0, 0), (0xC0, 1)) == "program 1: drop-d"


def test_a_nylon_guitar_is_what_there_is():
    world = World("classical", "drop-d")
    assert world.send((0xC0, 1), (0xC0, 24)) == "program 1: drop-d" and world.programs.unknown == 0
    assert World(*["drop-d"] * 24, "classical").send((0xC0, 24)) == "program 24: classical", "unless so many are named"


def test_a_piece_on_one_guitar_is_silent_about_its_pianos():
    world = World(of_piece=True)
    assert world.send((0xC0, 3), (0xC1, 48)) == "" and world.programs.unknown == 2


def test_settings_that_do_not_fit_another_guitar_leave_it():
    world = World("classical", overrides={"strings.5.fine_tune": "3"})
    said = world.send(*bank(1, 0), (0xC0, preset_names().index("ukulele")))
    assert "strings.5" in said and "the guitar stays" in said and world.guitar == "classical"
    assert world.shelf.names == ["classical"]


def test_what_the_stage_does_of_itself_is_no_program():
    assert World().send((0xC0, 24), kind=at.KIND_SHED) == ""


def test_the_list_of_banks(capsys):
    assert main(["presets", "--banks"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[-1] for line in lines[1:]] == preset_names() and lines[0].startswith("bank 0")
    assert main(["presets", "classical", "--banks"]) == 2
