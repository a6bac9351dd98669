"""Scala's files after the rules of its own pages: what they say is read, what breaks them is refused."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ukrt.errors import PresetError
from ukrt.model.scala import read_keyboard, read_scale

HEAD = "12\n0\n127\n60\n69\n440.0\n12\n"


def scale(folder, text):
    path = folder / "a.scl"
    path.write_text(text, encoding="latin-1")
    return read_scale(path, f"the scale {path}")


def keyboard(folder, text):
    path = folder / "a.kbm"
    path.write_text(text, encoding="latin-1")
    return read_keyboard(path, f"the map {path}")


def test_a_scale_is_ratios_and_cents_between_comments(tmp_path):
    """Everything that Scala's page allows: comments anywhere, blanks, words after a pitch, whole numbers as ratios."""
    text = "! a.scl\n!\nG\xe4nsemarsch \n 5 notes\n!\n 81/80 comma\n\t100.\n! inside\n-5.0 cents\n 3/2\n2\n\n"
    found = scale(tmp_path, text)
    assert found["name"] == "G\xe4nsemarsch"
    expected = [1200 * math.log2(81 / 80), 100.0, -5.0, 1200 * math.log2(1.5), 1200.0]
    assert found["cents"] == pytest.approx(expected, abs=1e-12)


def test_a_scale_without_a_name_has_its_files(tmp_path):
    assert scale(tmp_path, "\n1\n2/1\n") == {"name": "a", "cents": [1200.0]}


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "before the number"),
        ("name\n", "before the number"),
        ("name\ntwelve\n2/1\n", "line 2 is 'twelve'"),
        ("name\n0\n", "from 1 to 1024"),
        ("name\n-3\n", "from 1 to 1024"),
        ("name\n3\n9/8\n2/1\n", "3 notes, but 2 follow"),
        ("name\n1\n9/8\n2/1\n", "1 notes, but 2 follow"),
        ("name\n2\n! comment\n9/8/7\n2/1\n", "line 4 is '9/8/7'"),
        ("name\n1\n-3/2\n", "line 3"),
        ("name\n1\n3/0\n", "line 3"),
        ("name\n1\n0/3\n", "line 3"),
        ("name\n1\n4294967296/3\n", "line 3"),
        ("name\n1\n1e3\n", "line 3"),
        ("name\n1\nnan\n", "line 3"),
        ("name\n1\n3 /2.\n", None),
        ("name\n2\n\n2/1\n", "line 3"),
    ],
)
def test_broken_scales(tmp_path, text, words):
    if words is None:  # what follows a pitch is not looked at: 3 is 3/1
        assert scale(tmp_path, text)["cents"] == [pytest.approx(1200 * math.log2(3))]
        return
    with pytest.raises(PresetError, match=r"^the scale .*a\.scl") as caught:
        scale(tmp_path, text)
    assert words in str(caught.value) and "\n" not in str(caught.value)


def test_a_map_is_seven_numbers_and_degrees(tmp_path):
    found = keyboard(tmp_path, "! white keys\n" + HEAD + "0\nx\n2\nX\n! comment\n4\n5\n")
    assert found == {
        "degrees": ["0", "x", "2", "x", "4", "5", *["x"] * 6],  # what is left out at the end is unmapped
        "first_key": 0,
        "last_key": 127,
        "middle_key": 60,
        "reference_key": 69,
        "reference_hz": 440.0,
        "octave_degree": 12,
    }


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("12\n0\n", "has 2 lines"),
        (HEAD.replace("127", "128"), "last key"),
        (HEAD.replace("440.0", "loud"), "reference frequency"),
        (HEAD.replace("440.0", "inf"), "reference frequency"),
        (HEAD[:-3] + "o\n", "degree of the octave"),
        (HEAD + "0\ny\n", "line 9 is 'y'"),
        (HEAD + "0\n" * 13, "12 entries, but 13 follow"),
    ],
)
def test_broken_maps(tmp_path, text, words):
    with pytest.raises(PresetError, match=r"^the map .*a\.kbm") as caught:
        keyboard(tmp_path, text)
    assert words in str(caught.value) and "\n" not in str(caught.value)


def test_files_that_are_not_there(tmp_path):
    with pytest.raises(PresetError, match="cannot be read"):
        read_scale(tmp_path / "absent.scl", "the scale")
    with pytest.raises(PresetError, match="cannot be read"):
        read_keyboard(tmp_path, "the map")


@settings(max_examples=300, deadline=None)
@given(
    st.text(st.sampled_from("0123456789./-x! \n\tab"), max_size=80)
    | st.binary(max_size=60).map(lambda b: b.decode("latin-1"))
)
def test_no_text_is_worse_than_refused(tmp_path_factory, text):
    folder = tmp_path_factory.mktemp("any")
    for read in (scale, keyboard):
        try:
            found = read(folder, text)
        except PresetError as error:
            assert len(str(error).splitlines()) == 1
        else:
            assert all(math.isfinite(cents) for cents in found.get("cents", ()))
