"""Tunings in words, files of scales in presets, and what real strings would say."""

import math

import pytest

from ukrt import tuning_warnings
from ukrt.errors import ParameterError, PresetError
from ukrt.model.fingerboard import fingerboard
from ukrt.model.preset_text import dump_preset
from ukrt.model.presets import load_preset, parse_preset, preset_names
from ukrt.model.string_limits import describe_tuning
from ukrt.model.tunings import NAMED, note_name, parse_tuning

SIX = [40, 45, 50, 55, 59, 64]
UKULELE = [67, 60, 64, 69]
MEANTONE = "! a comment\nquarter comma\n12\n" + "".join(
    f"{1200 * math.log2(5) / 4 * fifths % 1200:.6f}\n" for fifths in (7, 2, -3, 4, -1, 6, 1, 8, 3, -2, 5)
)


def tuned(text, preset="classical", **more):
    return load_preset(preset, {"tuning.open_strings": text, **more})


@pytest.mark.parametrize(
    ("text", "present", "notes"),
    [
        ("D2 A2 D3 G3 B3 E4", SIX, [38, 45, 50, 55, 59, 64]),
        ("38, 45 50,55 59 64", SIX, [38, 45, 50, 55, 59, 64]),
        ("DADGBE", SIX, [38, 45, 50, 55, 59, 64]),
        ("DADGAD", SIX, [38, 45, 50, 55, 57, 62]),
        ("EbAbDbGbBbEb", SIX, [39, 44, 49, 54, 58, 63]),
        ("D A D F# A D", SIX, [38, 45, 50, 54, 57, 62]),
        ("Bb2 A2 D3 G3 B3 E4", SIX, [46, 45, 50, 55, 59, 64]),  # octaves that are given are kept
        ("BbADGBE", SIX, [34, 45, 50, 55, 59, 64]),  # six semitones either way: down
        ("ADF#B", UKULELE, [69, 62, 66, 71]),
        ("C-1 C4 E4 A4", UKULELE, [0, 60, 64, 69]),
        ("low-g", UKULELE, [55, 60, 64, 69]),
    ],
)
def test_notes_of_open_strings(text, present, notes):
    assert parse_tuning(text, present) == notes


@pytest.mark.parametrize("name", NAMED)
def test_named_tunings_are_within_a_fifth_of_the_usual_one(name):
    present = SIX if len(NAMED[name].split()) == 6 else UKULELE
    moved = [abs(new - old) for new, old in zip(parse_tuning(name, present), present, strict=True)]
    assert max(moved) <= (12 if name == "low-g" else 5)


@pytest.mark.parametrize(
    "text",
    ["DADGB", "dadgbe", "open-h", "", "D2 A2 D3 G3 B3 H4", "D2 A2 D3 G3 B3 128", "D2 A2 D3 G3 B3 C-2", "40 " * 6],
)
def test_what_is_no_tuning_of_six_strings(text):
    if text.startswith("40"):
        assert parse_tuning(text, SIX) == [40] * 6  # unisons are nobody's business but the player's
        return
    with pytest.raises(ParameterError, match=r"tuning\.open_strings"):
        parse_tuning(text, SIX)


def test_notes_have_names():
    assert [note_name(note) for note in (0, 21, 60, 70, 127)] == ["C-1", "A0", "C4", "A#4", "G9"]


def test_tension_follows_the_note():
    plain, changed = load_preset("paper"), tuned("DADGAD", "paper")
    for before, after in zip(plain.strings, changed.strings, strict=True):
        assert after.name == note_name(after.note)
        assert after.tension == pytest.approx(before.tension * 2 ** ((after.note - before.note) / 6))


def test_settings_that_follow_change_what_a_tuning_has_made():
    changed = tuned("DADGBE", **{"strings.0.tension": "60", "strings.0.name": "low"})
    assert (changed.strings[0].note, changed.strings[0].tension, changed.strings[0].name) == (38, 60.0, "low")


@pytest.mark.parametrize(
    ("text", "words"),
    [("E6 A2 D3 G3 B3 E4", ("E6 on E2", "1 to 500 N")), ("DADG", ("6 strings", "dadgad")), (3, ("text in quotes",))],
)
def test_tunings_that_are_refused_name_what_asked_for_them(tmp_path, text, words):
    with pytest.raises(PresetError, match=r"^the settings: tuning\.open_strings") as caught:
        tuned(text)
    for word in words:
        assert word in str(caught.value)
    path = tmp_path / "mine.toml"
    path.write_text(f'base = "classical"\n[tuning]\nopen_strings = {text!r}\n')
    with pytest.raises(PresetError, match=r"mine\.toml: tuning\.open_strings"):
        load_preset(path)


def test_a_preset_keeps_its_scale_without_the_file(tmp_path):
    """Names of files are relative to the preset; its text holds what they said, so that a take replays alone."""
    folder = tmp_path / "scales"
    folder.mkdir()
    (folder / "mean.scl").write_text(MEANTONE + "2/1\n")
    (folder / "d.kbm").write_text("0\n0\n127\n62\n69\n441\n0\n")
    (tmp_path / "mine.toml").write_text(
        'base = "classical"\n[tuning]\nscale = "scales/mean.scl"\nkeyboard = "scales/d.kbm"\nopen_strings = "DADGBE"\n'
    )
    guitar = load_preset(tmp_path / "mine.toml")
    text = dump_preset(guitar)
    for path in folder.iterdir():
        path.unlink()
    assert parse_preset(text, "a take") == guitar
    assert (guitar.tuning.scale.name, guitar.tuning.keyboard.reference_hz) == ("quarter comma", 441.0)
    hz = fingerboard(guitar).hz
    assert hz[1, 0] == pytest.approx(441.0 / 4)  # A2
    assert hz[2, 4] / hz[2, 0] == pytest.approx(5 / 4, rel=1e-8)  # D3 to F#3, the pure third of the temperament
    with pytest.raises(PresetError, match=r"mine\.toml: tuning\.scale .*mean\.scl cannot be read"):
        load_preset(tmp_path / "mine.toml")


def test_a_file_of_another_kind_is_refused(tmp_path):
    with pytest.raises(PresetError, match=r"tuning\.scale is 'a\.txt'.*\.scl"):
        load_preset("classical", {"tuning.scale": "a.txt"})
    with pytest.raises(PresetError, match=r"tuning\.keyboard .*no\.kbm cannot be read"):
        load_preset("classical", {"tuning.keyboard": str(tmp_path / "no.kbm")})


# What real strings would say ------------------------------------------------------------------------------------------
@pytest.mark.parametrize("name", preset_names())
def test_shipped_guitars_bear_their_tunings(name):
    assert tuning_warnings(load_preset(name)) == []


def test_bare_nylon_breaks_by_pitch_and_length_alone():
    """Stress is rho (2 L f)^2: 350 MPa on 1140 kg/m^3 and 0.65 m are 426 Hz, whatever the string's thickness."""
    limit = math.sqrt(350e6 / 1140) / 1.3
    a4 = 440.0 * limit / 415.3047  # G#4 is 415.30 Hz in A = 440 Hz
    for mass in ("0.38e-3", "0.30e-3"):
        fate = [
            tuning_warnings(tuned("E2 A2 D3 G3 B3 G#4", **{"tuning.a4_hz": a4 * by, "strings.5.linear_density": mass}))
            for by in (0.999, 1.001)
        ]
        assert fate[0] == [] and len(fate[1]) == 1
        assert "strings.5 (G#4) would break" in fate[1][0] and "nylon" in fate[1][0]


def test_a_wound_string_breaks_in_its_core():
    (warning,) = tuning_warnings(tuned("A2 A2 D3 G3 B3 E4"))
    assert "strings.0 (A2) would break" in warning and "core" in warning and "estimated" in warning
    assert tuning_warnings(tuned("A2 A2 D3 G3 B3 E4", **{"strings.0.axial_stiffness": 0})) == []  # nothing is known


def test_a_slack_string_rattles():
    """F L b / 2 T beside 0.006 L: with 2 N upwards at 0.2 from the bridge less than 33.3 N is too little."""
    pluck = {"pluck.force_soft": 1.0, "pluck.force_strong": 4.0, "pluck.place": 0.8, "pluck.angle": 0.0}
    for tension, count in ((33.2, 1), (33.5, 0)):
        found = tuning_warnings(load_preset("paper", {**pluck, "strings.3.tension": tension}))
        assert len(found) == count and all("strings.3 (G3) would rattle" in one for one in found)


def test_a_capo_breaks_nothing():
    """The strings are as tight as before, though what is left of them sounds higher."""
    assert tuning_warnings(load_preset("classical", {"playing.capo": 12})) == []


def test_a_tuning_in_words_for_the_report():
    found = describe_tuning(tuned("DADGBE", **{"playing.capo": 2}))
    assert found["open_notes"] == ["D2", "A2", "D3", "G3", "B3", "E4"] and found["capo"] == 2
    assert found["open_keys"] == [40, 47, 52, 57, 61, 66] and found["scale"] == "12 equal steps"
    assert found["open_hz"][1] == pytest.approx(110 * 2 ** (2 / 12))
