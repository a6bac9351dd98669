"""What is played on, against what scales, maps and capos mean in closed form."""

import dataclasses
import math

import numpy as np
import pytest

from ukrt.errors import ParameterError, PresetError
from ukrt.model.fingerboard import fingerboard, first_fret, key_cents, repeat_keys
from ukrt.model.parameters import Keyboard, Scale, Tuning
from ukrt.model.presets import load_preset
from ukrt.units import midi_to_hz

CLASSICAL = load_preset("classical")
NINETEEN = Scale("19 steps", tuple(1200.0 * n / 19 for n in range(1, 20)))
TRITAVE = Scale("Bohlen-Pierce", tuple(1200.0 * math.log2(3) * n / 13 for n in range(1, 14)))
DENSE = Scale("41 steps", tuple(1200.0 * n / 41 for n in range(1, 42)))
JUST = Scale(
    "just",
    tuple(
        1200 * math.log2(r)
        for r in (16 / 15, 9 / 8, 6 / 5, 5 / 4, 4 / 3, 45 / 32, 3 / 2, 8 / 5, 5 / 3, 9 / 5, 15 / 8, 2)
    ),
)


def tuned(guitar=CLASSICAL, frets=19, capo=0, **tuning):
    playing = dataclasses.replace(guitar.playing, frets=frets, capo=capo)
    return dataclasses.replace(guitar, playing=playing, tuning=dataclasses.replace(guitar.tuning, **tuning))


def test_without_anything_it_is_equal_temperament():
    board = fingerboard(CLASSICAL)
    notes = np.array([40, 45, 50, 55, 59, 64])
    assert board.guitar == CLASSICAL and board.frets == 19 and board.open_keys == tuple(notes)
    np.testing.assert_allclose(board.hz, midi_to_hz(notes[:, None] + np.arange(20)), rtol=1e-14)
    np.testing.assert_allclose(board.ideal, np.tile(0.65 * (1 - 2.0 ** (-np.arange(20) / 12)), (6, 1)), atol=1e-15)
    assert repeat_keys(CLASSICAL.tuning) == 12


def test_strings_take_the_scales_nearest_note_and_frets_its_steps():
    """In 19 steps E2 is 46 of them below A4 (82.41 Hz is 45.92); every fret divides the string by 2^(1/19)."""
    board = fingerboard(tuned(scale=NINETEEN))
    expected = [69 - round(19 * math.log2(440.0 / midi_to_hz(s.note))) for s in CLASSICAL.strings]
    assert list(board.open_keys) == expected and expected[0] == 23
    steps = np.array(expected)[:, None] + np.arange(20) - 69
    np.testing.assert_allclose(board.hz, 440.0 * 2.0 ** (steps / 19), rtol=1e-13)
    np.testing.assert_allclose(0.65 - board.ideal, 0.65 * 2.0 ** (-np.tile(np.arange(20), (6, 1)) / 19), rtol=1e-12)


def test_a_scale_may_repeat_at_another_interval():
    board = fingerboard(tuned(scale=TRITAVE, frets=16))
    assert repeat_keys(tuned(scale=TRITAVE, frets=16).tuning) == 13
    np.testing.assert_allclose(board.hz[:, 13] / board.hz[:, 0], 3.0, rtol=1e-12)
    np.testing.assert_allclose(board.ideal[:, 13], 0.65 * 2 / 3, rtol=1e-12)


def test_degrees_count_from_the_middle_key_and_hertz_from_the_reference_key():
    """Just intonation on D (62), E4 = 330 Hz: a scale of ratios, so all pitches are known."""
    board = Keyboard(middle_key=62, reference_key=64, reference_hz=330.0)
    hz = fingerboard(tuned(scale=JUST, keyboard=board)).hz
    assert hz[5, 0] == pytest.approx(330.0)  # the open string E4, the scale's 9/8
    assert hz[5, 5] == pytest.approx(330.0 / (9 / 8) * 3 / 2)  # A4
    assert hz[2, 0] == pytest.approx(330.0 / (9 / 8) / 2)  # D3
    assert hz[2, 4] == pytest.approx(330.0 / (9 / 8) / 2 * 5 / 4)  # F#3
    high = fingerboard(tuned(scale=JUST, keyboard=board, a4_hz=442.0)).hz
    np.testing.assert_allclose(high, hz * 442 / 440, rtol=1e-12)


def test_keys_without_a_degree_do_not_play_and_lie_between():
    white = ("0", "x", "2", "x", "4", "5", "x", "7", "x", "9", "x", "11")
    cents, plays = key_cents(Tuning(keyboard=Keyboard(degrees=white, first_key=24, last_key=96)))
    assert [key for key in range(60, 73) if plays[key]] == [60, 62, 64, 65, 67, 69, 71, 72]
    assert not plays[:24].any() and not plays[97:].any()
    np.testing.assert_allclose(cents, 100.0 * (np.arange(len(cents)) - 69), atol=1e-9)  # half way is where they were


def test_a_map_may_pick_degrees_and_repeat_where_it_says():
    """Seven white keys in a row play the diatonic degrees of twelve, an octave every seven keys."""
    seven = Keyboard(
        degrees=("0", "2", "4", "5", "7", "9", "11"), reference_key=60, reference_hz=261.6, octave_degree=12
    )
    cents, plays = key_cents(Tuning(keyboard=seven))
    assert plays.all()
    np.testing.assert_allclose(cents[60:68], [0, 200, 400, 500, 700, 900, 1100, 1200], atol=1e-9)
    assert repeat_keys(Tuning(keyboard=seven)) == 7


def test_fine_tuning_moves_a_string_with_its_frets():
    plain = fingerboard(CLASSICAL).hz
    moved = fingerboard(load_preset("classical", {"strings.2.fine_tune": -14})).hz
    np.testing.assert_allclose(1200 * np.log2(moved / plain)[2], -14.0, atol=1e-9)
    np.testing.assert_array_equal(np.delete(moved, 2, axis=0), np.delete(plain, 2, axis=0))


@pytest.mark.parametrize("capo", [1, 5, 12])
def test_a_capo_leaves_pitches_and_places_from_the_bridge_alone(capo):
    """The frets stay where they are on the neck and sound what they did; the right hand stays where it was."""
    board, plain = fingerboard(tuned(capo=capo)), fingerboard(CLASSICAL)
    assert board.frets == 19 - capo and board.open_keys == tuple(key + capo for key in plain.open_keys)
    np.testing.assert_allclose(board.hz, plain.hz[:, capo:], rtol=1e-13)
    length = board.guitar.strings[0].length
    assert length == pytest.approx(0.65 * 2 ** (-capo / 12))
    np.testing.assert_allclose(length - board.ideal, 0.65 - plain.ideal[:, capo:], rtol=1e-12)
    for now, before in zip(
        (board.guitar.pluck.place, *board.guitar.damper.places),
        (CLASSICAL.pluck.place, *CLASSICAL.damper.places),
        strict=True,
    ):
        assert (1 - now) * length == pytest.approx((1 - before) * 0.65)


def test_a_capo_in_an_unequal_scale_ends_each_string_at_its_own_fret():
    board = fingerboard(tuned(scale=JUST, capo=1))
    plain = fingerboard(tuned(scale=JUST))
    np.testing.assert_allclose(board.hz, plain.hz[:, 1:], rtol=1e-12)
    left = [one.length for one in board.guitar.strings]
    np.testing.assert_allclose(left, 0.65 - plain.ideal[:, 1], rtol=1e-12)
    assert np.ptp(left) > 0.005  # m: a step is 16/15 on one string, 27/25 on another


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda: tuned(frets=3, capo=4), ("capo", "4", "3 frets")),
        (lambda: tuned(scale=TRITAVE), ("playing.frets", "19", "at most 16")),
        (lambda: tuned(scale=Scale("down", (700.0, 500.0, 1200.0))), ("scale", "-200 cents", "at least 10")),
        (lambda: tuned(scale=Scale("fine", tuple(1200 * n / 171 for n in range(1, 172)))), ("scale", "7.018")),
        (lambda: tuned(scale=Scale("still", (1200.0, 1200.0))), ("scale", "0 cents")),
        (lambda: tuned(keyboard=Keyboard(first_key=60, last_key=72)), ("strings.0.note", "40", "150 cents")),
        (lambda: tuned(keyboard=Keyboard(degrees=("x", "0", "1"), reference_key=60)), ("reference_key", "60")),
        (lambda: tuned(keyboard=Keyboard(degrees=("x",))), ("reference_key",)),
        (lambda: tuned(scale=DENSE), ("strings.0.note", "keyboard map")),  # 128 keys are three octaves of it
        (lambda: tuned(scale=DENSE, keyboard=Keyboard(reference_key=110)), ("finger.contacts.2", "capo")),
        (lambda: Keyboard(degrees=("0", "1.5")), ("degrees.1", "1.5")),
        (
            lambda: load_preset("classical", {"playing.capo": 12, "pluck.place": "0.4"}),
            ("playing.capo", "12", "right hand"),
        ),
    ],
)
def test_what_no_fingerboard_can_be(change, words):
    with pytest.raises((ParameterError, PresetError)) as caught:
        change()
    for word in words:
        assert word in str(caught.value)


def test_the_first_fret_is_the_shortest_strings():
    assert first_fret(CLASSICAL) == pytest.approx(0.65 * (1 - 2 ** (-1 / 12)))
    assert first_fret(tuned(frets=0)) == math.inf
    fan = load_preset("eight-string")
    assert first_fret(fan) == pytest.approx(0.615 * (1 - 2 ** (-1 / 12)))
