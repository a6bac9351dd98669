"""Tablature read back from its text."""

import re

import pytest
from scores import OPEN, make_score, random_sheet, row

from ukrt.notation.names import note_name
from ukrt.notation.sheet import make_sheet
from ukrt.notation.tablature import draw

STRING = re.compile(r"^[A-G][#b]?\d\|(.*)$")


def read_back(text):
    """(column of the whole piece, string, fret with its sign) of every note, bars' numbers and columns of bar lines."""
    found, numbers, lines, at = [], [], [], 0
    rows = text.split("\n")
    for k, line in enumerate(rows):
        if STRING.match(line) and not STRING.match(rows[k - 1]):
            strings = [STRING.match(rows[k + s])[1] for s in range(6)]
            assert len({len(string) for string in strings}) == 1, "all strings are equally long"
            for s, string in enumerate(strings):
                found += [(at + hit.start(), 5 - s, hit[0]) for hit in re.finditer(r"[hp/]?\d+", string)]
            bars = [hit.start() for hit in re.finditer(r"\|", strings[0])]
            assert all(string[bar] == "|" for string in strings for bar in bars)
            lines += [at + bar for bar in bars]
            numbers += re.findall(r"(?:^| )(\d+)(?= |$)", re.sub(r"\[.*?\]", "", rows[k - 2]))
            at += len(strings[0])
    return sorted(found), [int(number) for number in numbers], lines


@pytest.mark.parametrize("width", [40, 61, 80, 200])
@pytest.mark.parametrize("seed", range(4))
def test_every_note_stands_on_its_string_in_its_bar_in_order(seed, width):
    _, _, sheet = random_sheet(seed)
    text = draw(sheet, width)
    assert max(map(len, text.splitlines()[2:])) <= width
    found, numbers, lines = read_back(text)
    assert numbers == [measure.bar.number for measure in sheet.measures] and len(lines) == len(numbers)
    expected = [
        (measure.bar.number, at, tone.string, str(tone.fret))
        for measure in sheet.measures
        for at, tones in measure.moments.items()
        for tone in tones
    ]
    bars = [(1 + sum(line < column for line in lines), column, string, fret) for column, string, fret in found]
    moments = {(bar, column): None for bar, column, *_ in bars}
    expected_moments = {(bar, at): None for bar, at, *_ in expected}
    assert len(moments) == len(expected_moments)
    renamed = dict(zip(sorted(moments), sorted(expected_moments), strict=True))
    assert sorted((*renamed[bar, column], string, fret) for bar, column, string, fret in bars) == sorted(expected)


def test_time_tempo_key_and_markers_are_told_where_they_change():
    _, _, sheet = random_sheet(1)
    text = draw(sheet, 120)
    assert text.startswith("Étude\nclassical, strings from the lowest: E2 A2 D3 G3 B3 E4\n")
    assert text.count("6/8") == text.count("2/2") == text.count("[Chorus]") == 1
    assert text.count("q=100") == text.count("q=60") == 1


def test_articulations_and_what_was_not_played():
    score = make_score([], 4, keys=[(0, -1)])
    ways = ["pluck", "hammer-on", "pull-off", "slide"]
    rows = [row(score, k, 4, 10 + k, way) for k, way in enumerate(ways)]
    rows += [row(score, 2.5, 0, 30) | {"string": None, "fate": "dropped"}]
    rows += [row(score, 3, 0, 30) | {"string": None, "fate": "percussion"}]
    text = draw(make_sheet(score, "g", rows, OPEN))
    assert [fret for *_, fret in read_back(text)[0]] == ["10", "h11", "p12", "/13"]
    assert "dropped: bar 1, beat 3.5: Bb4 (MIDI note 70)" in text and "1 note of percussion" in text


@pytest.mark.parametrize(("key", "fifths", "name"), [(60, 0, "C4"), (61, 0, "C#4"), (61, -1, "Db4"), (40, 3, "E2")])
def test_names(key, fifths, name):
    assert note_name(key, fifths) == name
