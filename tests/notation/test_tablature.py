"""Tablature read back from its text."""

import re

import pytest
from scores import OPEN, make_score, random_sheet, row

from ukrt.drivers.files.midi import load_midi_file
from ukrt.model.presets import load_preset
from ukrt.notation.names import note_name
from ukrt.notation.sheet import make_sheet
from ukrt.notation.silent import play_silently
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


def check(sheet, width):
    """Draw a sheet, read it back, compare every note; returns the text."""
    text = draw(sheet, width)
    assert max(map(len, text.split(sheet.guitar + ",", 1)[1].splitlines()[1:])) <= width
    found, numbers, lines = read_back(text)
    assert numbers == [measure.bar.number for measure in sheet.measures] and len(lines) == len(numbers)
    expected = [
        (k, at, tone.string, str(tone.fret))
        for k, measure in enumerate(sheet.measures)
        for at, tones in measure.moments.items()
        for tone in tones
    ]
    bars = [(sum(line < column for line in lines), column, string, fret) for column, string, fret in found]
    moments, expected_moments = ({place[:2] for place in places} for places in (bars, expected))
    renamed = dict(zip(sorted(moments), sorted(expected_moments), strict=True))
    assert sorted((*renamed[bar, column], string, fret) for bar, column, string, fret in bars) == sorted(expected)
    return text


@pytest.mark.parametrize("width", [40, 61, 80, 200])
@pytest.mark.parametrize("seed", range(4))
def test_every_note_stands_on_its_string_in_its_bar_in_order(seed, width):
    check(random_sheet(seed)[-1], width)


def test_every_note_of_published_pieces_is_there(shared_data):
    """People's playing, tempo maps and all: no string has two notes at once, the grid has room for (nearly) all."""
    guitar = load_preset("classical")
    paths = sorted((shared_data / "midi").glob("*.mid"))
    assert paths
    for path in paths:
        score = load_midi_file(path)
        notes, open_keys, _ = play_silently(guitar, score)
        sheet = make_sheet(score, "classical", notes, open_keys)
        check(sheet, 100)
        shown = sum(len(tones) for measure in sheet.measures for tones in measure.moments.values())
        assert shown + sheet.unshown == len(sheet.tones) and len(sheet.tones) + len(sheet.lost) == score.n_notes
        assert sheet.unshown <= 0.01 * score.n_notes, path


def test_time_tempo_key_and_markers_are_told_where_they_change():
    _, _, sheet = random_sheet(1)
    text = draw(sheet, 120)
    assert text.startswith("Étude\nclassical, strings from the bass side: E2 A2 D3 G3 B3 E4\n")
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
