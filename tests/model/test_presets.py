"""Presets: all that ship load, text made from a guitar loads back to the same guitar, settings reach every key, and
what is wrong is refused in one sentence that names file, key, value and what is legal."""

import dataclasses
import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ukrt.errors import PresetError
from ukrt.model.preset_text import dump_preset
from ukrt.model.presets import load_preset, parse_preset, preset_names

NAMES = ("classical", "drop-d", "paper")


def refusal(*arguments):
    with pytest.raises(PresetError) as caught:
        load_preset(*arguments)
    message = str(caught.value)
    assert "\n" not in message
    return message


def test_shipped_presets():
    assert set(NAMES) <= set(preset_names())
    for name in preset_names():
        guitar = load_preset(name)
        assert guitar.name == name
        assert all(string.axial_stiffness > 0 for string in guitar.strings)


def test_paper_is_what_the_paper_says():
    guitar = load_preset("paper")
    assert guitar.tuning.mode == "published"
    assert (guitar.pluck.place, guitar.pluck.angle, guitar.pluck.duration) == (0.9, 0.0, 0.010)
    (contact,) = guitar.finger.contacts
    assert (contact.mass, contact.damping, contact.stiffness) == (5e-3, 1.0, 1e6)
    assert {string.length for string in guitar.strings} == {0.65}
    assert guitar.strings[0].axial_stiffness == 3200.0


def test_classical_and_drop_d_differ_in_one_string_only():
    classical, dropped = load_preset("classical"), load_preset("drop-d")
    assert classical.tuning == dropped.tuning and classical.tuning.mode == "equal" and classical.tuning.a4_hz == 440.0
    assert [s.note for s in classical.strings] == [40, 45, 50, 55, 59, 64]
    assert [s.note for s in dropped.strings] == [38, 45, 50, 55, 59, 64]
    same = dataclasses.replace(dropped, name="classical", description=classical.description, strings=classical.strings)
    assert same == classical and dropped.strings[1:] == classical.strings[1:]


@pytest.mark.parametrize("name", NAMES)
def test_text_loads_back_to_the_same_guitar(name, tmp_path):
    guitar = load_preset(name)
    path = tmp_path / "copy.toml"
    path.write_text(dump_preset(guitar), encoding="utf-8")
    assert load_preset(path) == guitar
    assert dump_preset(load_preset(path)) == dump_preset(guitar)
    assert parse_preset(dump_preset(guitar), "a take") == guitar


@pytest.mark.parametrize(
    ("text", "words"),
    [("a = " + "[" * 5000, "nested"), (f"a = {'1' * 5000}", "TOML"), ("name = ", "TOML"), ('base = "paper"', "base")],
)
def test_text_that_is_no_preset_is_refused_under_its_sources_name(text, words):
    with pytest.raises(PresetError, match=f"^a take.*{words}") as caught:
        parse_preset(text, "a take")
    assert "\n" not in str(caught.value)


def test_settings_are_laid_over_text():
    changed = parse_preset(dump_preset(load_preset("paper")), "a take", {"pluck.place": "0.7"})
    assert changed == load_preset("paper", {"pluck.place": 0.7})


@settings(max_examples=40, deadline=None)
@given(
    tension=st.floats(1, 500),
    loss=st.floats(0, 1),
    angle=st.floats(-3.14, 3.14),
    name=st.text(st.characters(exclude_categories=["Cs"]), max_size=20),
)
def test_any_guitar_survives_its_text(tmp_path_factory, tension, loss, angle, name):
    guitar = load_preset("paper")
    string = dataclasses.replace(guitar.strings[2], tension=tension, loss_bending=loss, name=name)
    guitar = dataclasses.replace(
        guitar,
        description=name,
        strings=(*guitar.strings[:2], string),
        pluck=dataclasses.replace(guitar.pluck, angle=angle),
        finger=dataclasses.replace(guitar.finger, contacts=load_preset("classical").finger.contacts),
    )
    path = tmp_path_factory.mktemp("presets") / "any.toml"
    path.write_text(dump_preset(guitar), encoding="utf-8")
    assert load_preset(path) == guitar


def test_every_key_of_the_text_can_be_set():
    """Each dotted key that the text shows takes its own value back, as text."""
    guitar = load_preset("classical")
    table, counts, seen = "", {}, 0
    for line in dump_preset(guitar).splitlines():
        if line.startswith("[["):
            name = line.strip("[]")
            counts[name] = counts.get(name, -1) + 1
            table = f"{name}.{counts[name]}."
        elif line.startswith("["):
            table = line.strip("[]") + "."
        elif line:
            key, value = re.match(r"(\w+) = (\[.*?\]|\".*?\"|[^#\s]+)", line).groups()
            assert load_preset("classical", {table + key: value}) == guitar
            seen += 1
    assert seen > 100


@pytest.mark.parametrize(
    "key, value, expected",
    [
        ("strings.0.tension", "70", lambda g: g.strings[0].tension == 70.0),
        ("strings.5.tension", 71, lambda g: g.strings[5].tension == 71.0),
        ("playing.idle_strings", "damped", lambda g: g.playing.idle_strings == "damped"),
        ("playing.idle_strings", '"damped"', lambda g: g.playing.idle_strings == "damped"),
        ("finger.contacts.1.stiffness", "2e4", lambda g: g.finger.contacts[1].stiffness == 2e4),
        ("body.frequencies_hz.2", "230", lambda g: g.body.frequencies_hz[2] == 230.0),
        ("pluck.place", ".5", lambda g: g.pluck.place == 0.5),
        ("damper.places", "[0.8]", lambda g: g.damper.places == (0.8,)),
        ("damper.places", (0.8, 0.9), lambda g: g.damper.places == (0.8, 0.9)),
        ("finger.contacts.0.rigid", "true", lambda g: g.finger.contacts[0].kind == "rigid"),
        ("radiation.impulse_response", "my room.wav", lambda g: g.radiation.impulse_response == "my room.wav"),
        ("playing.frets", "12", lambda g: g.playing.frets == 12),
    ],
)
def test_settings(key, value, expected):
    assert expected(load_preset("classical", {key: value}))


@pytest.mark.parametrize(
    "key, value, parts",
    [
        ("strings.0.tension", "900", ("strings.0.tension", "900.0", "1 to 500 N")),
        ("strings.0.tension", "70 N", ("strings.0.tension", "'70 N'", "1 to 500 N")),
        ("strings.0.tension_kg", "7", ("strings.0.tension_kg", 'did you mean "tension"')),
        ("strings.6.tension", "70", ("strings.6", "0 to 5")),
        ("strings.-1.tension", "70", ("strings.-1", "0 to 5")),
        ("body.frequencies", "[90]", ("body.frequencies", 'did you mean "frequencies_hz"')),
        ("body.frequencies_hz.10", "90", ("body.frequencies_hz.10", "0 to 9")),
        ("body.damping_ratios.3", "0.7", ("body.damping_ratios.3", "0.7", "0 to 0.5")),
        ("playing.idle_strings", "muted", ("playing.idle_strings", "'muted'", '"open" or "damped"')),
        ("playing.frets", "12.5", ("playing.frets", "12.5", "whole number from 0 to 24")),
        ("pluck.place.x", "1", ("pluck.place", "single value")),
        ("finger.contacts.0.mass", "0", ("finger.contacts.0.mass", "0.0", "stiffness")),
        ("nonsense", "1", ("nonsense", "no such key")),
        ("", "1", ("no such key",)),
    ],
)
def test_wrong_settings(key, value, parts):
    message = refusal("classical", {key: value})
    for part in ("the settings", *parts):
        assert part in message


@pytest.mark.parametrize(
    "line, parts",
    [
        ("[pluck]\nplaces = 0.8", ("pluck.places", 'did you mean "place"')),
        ("[pluck]\nduration_ms = 10", ("pluck.duration_ms", 'did you mean "duration"')),
        ('[pluck]\nangle = "flat"', ("pluck.angle", "'flat'", "rad")),
        ("[strings.2]\ntension = 0.5", ("strings.2.tension", "0.5", "1 to 500 N")),
        ("[strings.7]\ntension = 50", ("strings.7", "0 to 5")),
        ("strings = 5", ("strings", "5", "1 to 12 tables")),
        ("[[strings]]\nname = 'x'", ("strings.0.note", "missing")),
        ("pluck = 3", ("pluck", "3", "table")),
        ("[pluck\n", ("not valid TOML",)),
        ("base = 3", ("base", "3")),
    ],
)
def test_wrong_files(tmp_path, line, parts):
    path = tmp_path / "mine.toml"
    path.write_text(line if "base" in line else f'base = "classical"\n{line}\n')
    message = refusal(path)
    for part in (str(path), *parts):
        assert part in message


def test_a_missing_table_is_named(tmp_path):
    path = tmp_path / "mine.toml"
    text = dump_preset(load_preset("paper"))
    path.write_text(re.sub(r"\[pluck\].*?\n\n", "", text, flags=re.S))
    assert "pluck is missing" in refusal(path)


def test_files_that_cannot_be_read(tmp_path):
    assert "absent.toml" in refusal(tmp_path / "absent.toml")
    (tmp_path / "folder.toml").mkdir()
    assert "folder.toml" in refusal(tmp_path / "folder.toml")
    (tmp_path / "bytes.toml").write_bytes(b"\xff\xfe\x00")
    assert "UTF-8" in refusal(tmp_path / "bytes.toml")


def test_unknown_names_are_answered_with_the_known_ones():
    message = refusal("clasical")
    assert all(name in message for name in NAMES)
    assert 'did you mean "classical"' in message


def test_bases_may_be_files_but_not_circles(tmp_path):
    (tmp_path / "a.toml").write_text('base = "classical"\nname = "a"\n')
    (tmp_path / "b.toml").write_text('base = "a.toml"\n[tuning]\na4_hz = 415.0\n')
    guitar = load_preset(tmp_path / "b.toml")
    assert (guitar.name, guitar.tuning.a4_hz, guitar.tuning.mode) == ("a", 415.0, "equal")
    (tmp_path / "a.toml").write_text('base = "b.toml"\n')
    assert "leads back" in refusal(tmp_path / "b.toml")
