"""Cases as files: what is legal comes back the same, what is not is one sentence with file and key."""

import itertools
import pathlib
import textwrap
import tomllib

import pytest
from reference.small_cases import case

from ukrt.cli import simulate
from ukrt.errors import PresetError
from ukrt.experiment.case import HeldString
from ukrt.experiment.case_file import example_text, load_case, parse_case
from ukrt.model.fields import describe
from ukrt.model.preset_text import dump_preset

PAGE = pathlib.Path(simulate.__file__).parents[1] / "simulate" / "README.md"
SHORT = """
name = "short"
duration = 0.1
strings = ["E2", "A2"]
plucks = [{ string = "E2", force_y = 5.0 }]
"""


def _written(tmp_path, text):
    path = tmp_path / "case.toml"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("finger", ["rigid", "three", "damper"])
def test_a_dumped_case_is_the_same_case(tmp_path, finger):
    one = case(
        finger, held=(HeldString("E2", 0.25, 0.1, 0.2), HeldString("E2", 0.3, 0.2)), bridge="rigid", losses=False
    )
    assert load_case(_written(tmp_path, dump_preset(one))) == one
    assert parse_case(dump_preset(one), "a text") == one


def test_the_example_is_complete_and_loads(tmp_path):
    one = load_case(_written(tmp_path, example_text()))
    assert one.guitar.name == "paper" and one.held and one.plucks and one.record.displacement
    tree = tomllib.loads(example_text())
    for key, _, _ in describe(type(one)):
        if not key.startswith("guitar."):
            node = tree
            for name in key.split("."):
                node = node[0] if name == "N" else node[name]


@pytest.mark.parametrize("where", ["page", "help"])
def test_the_examples_that_are_shown_load(tmp_path, where):
    text = PAGE.read_text(encoding="utf-8") if where == "page" else simulate._EPILOG
    lines = iter(text.splitlines())
    first = next(line for line in lines if line.strip().startswith("name = "))
    shown = [first, *itertools.takewhile(lambda line: line.strip(), lines)]
    one = load_case(_written(tmp_path, textwrap.dedent("\n".join(shown))))
    assert one.plucks and one.record.displacement and one.record.energies


def test_the_guitar_is_a_name_or_a_table_or_a_file_beside_the_case(tmp_path):
    (tmp_path / "mine.toml").write_text('base = "classical"\n[basis]\nbandwidth_hz = 3000.0\n', encoding="utf-8")
    default = load_case(_written(tmp_path, SHORT)).guitar
    named = load_case(_written(tmp_path, 'guitar = "classical"' + SHORT)).guitar
    table = load_case(
        _written(tmp_path, SHORT + '[guitar]\nbase = "classical"\nbasis = { bandwidth_hz = 3000.0 }')
    ).guitar
    file = load_case(_written(tmp_path, 'guitar = "mine.toml"' + SHORT)).guitar
    assert (default.name, named.name) == ("paper", "classical")
    assert table == file != named
    assert file.basis.bandwidth_hz == 3000.0


def test_settings_change_single_values(tmp_path):
    path = _written(tmp_path, SHORT)
    one = load_case(path, {"plucks.0.force_z": "-2", "record.energies": "true", "guitar.strings.1.tension": 70.0})
    assert one.plucks[0].force_z == -2.0 and one.record.energies and one.guitar.strings[1].tension == 70.0
    other = load_case(path, {"guitar": "classical", "guitar.basis.bandwidth_hz": "5000"})
    assert other.guitar.name == "classical" and other.guitar.basis.bandwidth_hz == 5000.0


HELD = '[[held]]\nstring = "E2"\nplace = 0.25\nend = 0.5\n'


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("loses = true" + SHORT, ["loses", "losses"]),
        ("losses = 1" + SHORT, ["losses is 1", "true or false"]),
        ('step = "short"' + SHORT, ["step is 'short'", "1e-08 to 0.0001 s"]),
        ("step = 1.0" + SHORT, ["step is 1.0"]),
        ('bridge = "wood"' + SHORT, ["bridge is 'wood'", '"body" or "rigid"']),
        ('name = "without duration"', ["duration is missing"]),
        (SHORT.replace('"A2"', '"H2"'), ["strings is 'H2'", "E2, A2, D3"]),
        (SHORT.replace('string = "E2"', 'string = "E4"'), ["plucks.0.string is 'E4'", "E2, A2"]),
        (SHORT.replace("force_y", "force_x"), ["plucks.0.force_x"]),
        (SHORT + HELD + HELD.replace("end = 0.5", "start = 0.4"), ["held.1.start is 0.4", "already from 0 to 0.5 s"]),
        (SHORT + HELD.replace("end = 0.5", "start = 1.0\nend = 0.5"), ["held.0.end is 0.5"]),
        (SHORT + '[[record.displacement]]\nstring = "B3"\nplace = 0.5', ["record.displacement.0.string is 'B3'"]),
        (SHORT + '[guitar]\nbase = "banjo"', ["banjo"]),
        (SHORT + '[guitar]\nbase = "paper"\nbody = { frequencies_hz = [1.0] }', ["frequencies_hz"]),
        ("guitar = 7" + SHORT, ["guitar is 7"]),
        ('guitar = "nowhere.toml"' + SHORT, ["nowhere.toml"]),
        ("record = 3" + SHORT, ["record"]),
        ("this is no TOML", ["is not valid TOML"]),
        (SHORT + '[guitar]\nbase = "classical"\n' + HELD.replace("0.25", "0.002"), ["held.0.place is 0.002", "nut"]),
    ],
)
def test_what_is_wrong_is_one_sentence_with_file_and_key(tmp_path, text, words):
    with pytest.raises(PresetError) as caught:
        load_case(_written(tmp_path, text))
    sentence = str(caught.value)
    assert sentence.count("\n") == 0
    assert all(word in sentence for word in words), sentence
    assert "case.toml" in sentence or "banjo" in sentence or "nowhere.toml" in sentence


def test_a_missing_file_and_one_that_is_no_text(tmp_path):
    with pytest.raises(PresetError, match=r"absent\.toml cannot be read"):
        load_case(tmp_path / "absent.toml")
    (tmp_path / "case.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(PresetError, match="not a text file in UTF-8"):
        load_case(tmp_path / "case.toml")


@pytest.mark.parametrize(
    "key", ["plucks.0.force", "plucks.1.force_y", "guitar.stringz", "duration.0", "record.displacement"]
)
def test_settings_that_name_nothing(tmp_path, key):
    with pytest.raises(PresetError, match=f"the settings: {key.rpartition('.')[0]}"):
        load_case(_written(tmp_path, SHORT), {key: "7"})


def test_a_capo_shortens_the_strings_of_an_experiment(tmp_path):
    """And places count on what is left of them: half of it is below the finger's reach sooner."""
    one = load_case(_written(tmp_path, SHORT), {"guitar.playing.capo": "12"})
    assert [string.length for string in one.instrument.strings] == [pytest.approx(0.325)] * 2
    held = {"guitar.playing.capo": "12", "guitar.finger.contacts.0.offset": "-0.01"}
    place = 'held = [{ string = "E2", place = 0.025 }]'
    with pytest.raises(PresetError, match=r"held\.0\.place"):
        load_case(_written(tmp_path, SHORT + place), held)
