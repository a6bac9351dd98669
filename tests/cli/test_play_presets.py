"""Preset files that change while they are played."""

import pytest

from ukrt.cli.preset_shelf import PresetShelf
from ukrt.errors import PresetError


@pytest.fixture
def mine(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text('base = "classical"\n[pluck]\nplace = 0.8\n', encoding="utf-8")
    return path


def test_a_file_that_changes_is_taken_over(mine):
    shelf = PresetShelf(["classical", str(mine)])
    assert shelf.look() == []
    mine.write_text('base = "classical"\n[pluck]\nplace = 0.85\n', encoding="utf-8")
    (news,) = shelf.look()
    assert "mine.toml has changed" in news
    assert shelf.choose(1) and shelf.guitar.pluck.place == 0.85
    assert shelf.look() == []


def test_a_base_that_changes_counts_as_well(tmp_path, mine):
    top = tmp_path / "top.toml"
    top.write_text('base = "mine.toml"\n', encoding="utf-8")
    shelf = PresetShelf([str(top)])
    mine.write_text('base = "classical"\n[pluck]\nplace = 0.75\n', encoding="utf-8")
    assert len(shelf.look()) == 1 and shelf.guitar.pluck.place == 0.75


def test_a_broken_file_is_refused_once_in_a_sentence_and_the_old_one_stays(mine):
    shelf = PresetShelf([str(mine)])
    mine.write_text('base = "classical"\n[pluck]\nplace = 8\n', encoding="utf-8")
    assert shelf.look() == [], "it may be an editor that is just writing"
    (news,) = shelf.look()
    assert "mine.toml" in news and "pluck.place" in news and news.endswith("plays on") and "\n" not in news
    assert shelf.look() == [] and shelf.guitar.pluck.place == 0.8
    mine.unlink()
    assert [shelf.look(), len(shelf.look()), shelf.look()] == [[], 1, []]
    mine.write_text('base = "classical"\n[pluck]\nplace = 0.9\n', encoding="utf-8")
    assert len(shelf.look()) == 1 and shelf.guitar.pluck.place == 0.9


def test_settings_hold_for_all_and_survive_a_change(mine):
    shelf = PresetShelf(["drop-d", str(mine)], {"pluck.place": "0.7"})
    assert shelf.guitar.pluck.place == 0.7
    mine.write_text('base = "classical"\ndescription = "another"\n', encoding="utf-8")
    assert len(shelf.look()) == 1
    assert shelf.choose(1) and shelf.guitar.pluck.place == 0.7


def test_only_what_is_there_can_be_chosen(mine):
    shelf = PresetShelf(["classical", "drop-d", str(mine)])
    assert [shelf.choose(k) for k in (0, 2, 2, 3, -1, 1, 0)] == [False, True, False, False, False, True, True]


def test_what_is_not_there_at_the_start_is_refused(tmp_path):
    with pytest.raises(PresetError, match=r"absent\.toml"):
        PresetShelf(["classical", str(tmp_path / "absent.toml")])
