"""Bars, markers and places in a piece against closed forms."""

import random
from fractions import Fraction

import pytest
import smf

from ukrt.drivers.files.bars import Bars, Sequence
from ukrt.drivers.files.midi import load_midi_file
from ukrt.drivers.files.position import find, find_part, parse_position
from ukrt.drivers.files.tempo_map import TempoMap
from ukrt.errors import MidiFileError, ParameterError

END = smf.end_of_track()


@pytest.fixture
def load(tmp_path):
    def load_bytes(data):
        path = tmp_path / "song.mid"
        path.write_bytes(data)
        return load_midi_file(path)

    return load_bytes


def seconds(score, words, **options):
    return find(parse_position(words), score, "song.mid", **options)


def signature(delta, numerator, power):
    return smf.event(delta, 0xFF, 0x58, 4, numerator, power, 24, 8)


def text(delta, kind, words):
    return smf.event(delta, 0xFF, kind, len(words), *words.encode())


def test_bars_through_signatures_and_tempi_by_hand(load):
    """Two bars of 3/4 at 120, two of 6/8 of which the second is cut after one beat, then 2/2 at 60 from its start."""
    conductor = (
        signature(0, 3, 2)
        + signature(6 * 96, 6, 3)
        + signature(96 * 3 + 48, 2, 1)
        + smf.tempo(0, 1_000_000)
        + smf.end_of_track(96 * 5)
    )
    bars = load(smf.file(conductor, smf.note() + END, midi_format=1)).bars
    assert bars.count == 6
    assert [bars.seconds(k) for k in range(1, 8)] == [0.0, 1.5, 3.0, 4.5, 4.75, 8.75, 12.75]
    assert bars.seconds(3, 6) == 3.0 + 5 * 0.25 and bars.seconds(5, 2) == 6.75
    assert bars.seconds(4, 2) is None, "the bar that is cut short has one beat"
    assert bars.seconds(8) is bars.seconds(0) is bars.seconds(1, 4) is bars.seconds(7, 2) is None
    listed = [bars.bar(k) for k in range(1, 7)]
    assert [bar.quarters for bar in listed] == [3, 3, 3, Fraction(1, 2), 4, 4]
    assert [(bar.numerator, bar.denominator) for bar in listed[1::2]] == [(3, 4), (6, 8), (2, 2)]
    assert [bar.quarter_us for bar in listed] == [500_000] * 4 + [1_000_000] * 2
    assert all(bar.end_s == bars.seconds(bar.number + 1) for bar in listed)


def test_a_file_without_a_signature_has_four_quarters_to_a_bar(load):
    bars = load(smf.file(smf.note() + smf.end_of_track(96 * 8))).bars
    assert bars.count == 3 and [bars.seconds(k) for k in (1, 2, 4)] == [0.0, 2.0, 6.0]
    assert load(smf.file(END)).bars.count == 1


def test_smpte_files_have_bars_of_120_quarters_a_minute(load):
    body = signature(0, 3, 2) + smf.tempo(0, 1) + smf.note(ticks=29970)
    bars = load(smf.file(body + END, division=(256 - 29) << 8 | 100)).bars
    assert [bars.seconds(k) for k in (1, 2, 3)] == pytest.approx([0.0, 1.5, 3.0], abs=1e-12)
    assert bars.count == -(-29970 * 1001 // (1500 * 3000))


def test_sequences_of_format_2_begin_new_bars_and_their_names_are_markers(load):
    first = text(0, 3, "Verse") + smf.tempo(0, 1_000_000) + smf.note(ticks=96 * 5) + END
    second = text(0, 3, "Chorus") + signature(0, 2, 2) + text(96, 6, "Turn") + smf.end_of_track(96 * 2)
    score = load(smf.file(first, second, midi_format=2))
    assert [score.bars.seconds(k) for k in (1, 2, 3, 4, 5)] == [0.0, 4.0, 5.0, 6.0, 7.0]
    assert score.markers == ((0.0, "Verse"), (5.0, "Chorus"), (5.5, "Turn"))


def test_place_is_the_inverse_of_seconds():
    rng = random.Random(5)
    for _ in range(50):
        ticks = rng.choice([96, 480, 1000])
        tempos = [(rng.randrange(20_000), rng.randrange(100_000, 2_000_000)) for _ in range(rng.randrange(4))]
        signatures = [(rng.randrange(20_000), rng.randrange(1, 13), 1 << rng.randrange(5)) for _ in range(4)]
        bars = Bars([Sequence(rng.uniform(0, 9), TempoMap(tempos, ticks, None), 25_000, tuple(signatures))])
        for number in rng.sample(range(1, bars.count + 1), min(bars.count, 20)):
            bar = bars.bar(number)
            share = rng.uniform(0.01, 0.99)
            clock = bars._spans[0].sequence
            tick = clock.clock.tick(bar.start_s - clock.start_s) + share * float(bar.quarters) * ticks
            found, quarters = bars.place(clock.start_s + clock.clock.seconds(Fraction(tick)))
            assert found == number and quarters == pytest.approx(share * float(bar.quarters), abs=1e-6)


def test_markers_and_cue_points_are_found_by_name(load):
    body = text(0, 6, "Intro") + text(96, 7, "Solo") + text(96, 6, "intro") + smf.end_of_track(96)
    score = load(smf.file(body))
    assert seconds(score, "marker:SOLO") == 0.5 and seconds(score, 'marker:"Intro"') == 0.0
    assert find_part("marker:intro", "marker:intro", score, "song.mid") == (0.0, 1.0), "the next one of that name"
    with pytest.raises(MidiFileError, match=r"no marker 'Coda'.*Intro, Solo"):
        seconds(score, "marker:Coda")


@pytest.mark.parametrize(
    ("words", "expected"),
    [("12.5", 12.5), (3, 3.0), ("1:30", 90.0), ("1:02:03.5", 3723.5), ("bar:2", 2.0), ("bar:2.3", 3.0)],
)
def test_places_in_words(load, words, expected):
    assert seconds(load(smf.file(smf.note() + smf.end_of_track(96 * 9))), words) == expected


@pytest.mark.parametrize("words", ["", "x", "-1", "nan", "inf", "bar:0", "bar:2.0", "bar:", "1:75", "marker:", "bar 5"])
def test_what_is_no_place_is_refused(words):
    with pytest.raises(ParameterError, match="are legal"):
        parse_position(words)


def test_places_beyond_the_piece_are_refused(load):
    score = load(smf.file(smf.note() + smf.end_of_track(96 * 9)))
    for words in ("bar:5", "bar:4.2"):
        with pytest.raises(MidiFileError, match="has 3 bars"):
            seconds(score, words)
    with pytest.raises(MidiFileError, match="1 to 4 are its beats"):
        seconds(score, "bar:1.5")
    assert find_part(None, "bar:4", score, "song.mid") == (0.0, 6.0)
    for start, end in (("2", "2"), ("bar:2", "1")):
        with pytest.raises(ParameterError, match="after the start at 2 s"):
            find_part(start, end, score, "song.mid")


def test_signatures_that_mean_nothing_are_told_and_ignored(load):
    score = load(smf.file(signature(0, 0, 2) + signature(0, 4, 99) + smf.event(0, 0xFF, 0x58, 1, 3) + smf.note() + END))
    assert len(score.warnings) == 3 and all("time signature" in text for text in score.warnings)
    assert score.bars.bar(1).quarters == 4
