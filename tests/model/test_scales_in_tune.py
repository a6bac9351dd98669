"""Every note of scales, capos and other instruments on its pitch: poles of the coupled instrument against pitches that
are computed here, from the scales' definitions."""

import math

import numpy as np
import pytest

from ukrt.model.fingerboard import fingerboard
from ukrt.model.intonation import make_intonation
from ukrt.model.poles import string_poles
from ukrt.model.presets import load_preset
from ukrt.model.string_limits import wolf_warnings
from ukrt.units import midi_to_hz

FIFTH = 1200 * math.log2(1.5)
MEAN = 300 * math.log2(5)  # cents: a fifth of quarter-comma meantone
FEW = {"playing.frets": 7}  # so that the solver has less to do; enough for the scales' uneven steps


def chromatic(fifth, first=-3):
    """Cents of twelve notes of a chain of fifths that begins ``first`` fifths from degree 0, and the octave."""
    return [*sorted((first + k) * fifth % 1200 for k in range(12) if first + k), 1200.0]


def equal(steps, cents=1200.0):
    return [cents * n / steps for n in range(1, steps + 1)]


def cents_off(guitar, string, fret, hz):
    """Cents between the pole of a note, from `string_poles`, and ``hz``."""
    intonation, board = make_intonation(guitar), fingerboard(guitar)
    place = intonation.places[string, fret] if fret else None
    pole = string_poles(board.guitar, intonation.tensions, string, place, 1)[0]
    return 1200 * math.log2(pole.imag / (2 * math.pi * hz))


SCALES = {
    "meantone": chromatic(MEAN),
    "pythagorean": chromatic(FIFTH),
    "19 steps": equal(19),
    "bohlen-pierce": equal(13, 1200 * math.log2(3)),
}


@pytest.mark.parametrize("name", SCALES)
def test_notes_of_a_scale_are_in_tune_on_the_coupled_guitar(name):
    """Pitches from 440 Hz on key 69 by the scale's steps; within 0.5 cents but for wolves, which are counted."""
    cents = SCALES[name]
    guitar = load_preset("classical", {"tuning.scale": {"name": name, "cents": cents}, **FEW})
    board, left = fingerboard(guitar), np.abs(make_intonation(guitar).cents_left)
    wolves = left > 0.5
    assert np.count_nonzero(wolves) <= {"meantone": 2, "19 steps": 3, "bohlen-pierce": 3}.get(name, 0)
    assert len(wolf_warnings(guitar)) == wolves.any()
    period, degrees = len(cents), [0.0, *cents]
    for string, fret in ((0, 0), (1, 1), (2, 3), (3, 0), (4, 5), (5, 7)):
        turns, degree = divmod(board.open_keys[string] + fret - 60, period)
        above_c = turns * cents[-1] + degrees[degree]
        turns, degree = divmod(9, period)
        hz = 440.0 * 2 ** ((above_c - turns * cents[-1] - degrees[degree]) / 1200)
        if not wolves[string, fret]:
            assert abs(cents_off(guitar, string, fret, hz)) < 0.01


def test_a_fine_tuned_string_and_another_a4():
    guitar = load_preset("classical", {"strings.3.fine_tune": "7.5", "tuning.a4_hz": "442", **FEW})
    assert abs(cents_off(guitar, 3, 0, midi_to_hz(55 + 0.075, 442.0))) < 0.01
    assert abs(cents_off(guitar, 3, 5, midi_to_hz(60 + 0.075, 442.0))) < 0.01
    assert abs(cents_off(guitar, 2, 2, midi_to_hz(52, 442.0))) < 0.01


def test_published_tensions_follow_fine_tuning():
    guitar = load_preset("paper", {"strings.3.fine_tune": "50", "playing.frets": 0})
    tensions = make_intonation(guitar).tensions
    assert tensions[3] == pytest.approx(guitar.strings[3].tension * 2 ** (100 / 1200))
    assert tensions[2] == guitar.strings[2].tension


@pytest.mark.parametrize("capo", [2, 7])
def test_notes_above_a_capo_are_in_tune(capo):
    guitar = load_preset("classical", {"playing.capo": capo, "playing.frets": capo + 5})
    assert np.max(np.abs(make_intonation(guitar).cents_left)) < 0.5
    for string, fret in ((0, 0), (3, 2), (5, 5)):
        note = guitar.strings[string].note + capo + fret
        assert abs(cents_off(guitar, string, fret, midi_to_hz(note))) < 0.01
    plain = make_intonation(load_preset("classical", {"playing.frets": 0})).tensions
    np.testing.assert_allclose(make_intonation(guitar).tensions, plain, rtol=0.06)  # the player tunes with it on


@pytest.mark.parametrize("name", ["seven-string", "eight-string", "ukulele"])
def test_other_instruments_are_in_tune(name):
    guitar = load_preset(name)
    assert np.max(np.abs(make_intonation(guitar).cents_left)) < 0.01
    for string, fret in ((0, 0), (0, 5), (len(guitar.strings) - 1, 12)):
        assert abs(cents_off(guitar, string, fret, midi_to_hz(guitar.strings[string].note + fret))) < 0.01


def test_a_shorter_string_stands_for_one_under_a_stiff_bar():
    """The capo's model beside two rigid points 2 mm apart on the whole string: pitch differs by what stiffness takes
    off the length and is tuned away; between partials 0.9 cents are left, and decay is as with the bar."""
    from dataclasses import replace

    from ukrt.model.parameters import Contact, Finger

    guitar = load_preset("classical")
    capo = fingerboard(load_preset("classical", {"playing.capo": 5})).guitar
    tensions = make_intonation(load_preset("classical", {"playing.frets": 0})).tensions
    bar = replace(guitar, finger=Finger((Contact(0.0, rigid=True), Contact(-0.002, rigid=True))))
    for string in (0, 3, 5):
        short = string_poles(capo, tensions, string, None, 8, others="absent")
        whole = string_poles(bar, tensions, string, 0.65 * (1 - 2 ** (-5 / 12)), 8, others="absent")
        cents = 1200 * np.log2(whole.imag / short.imag)
        assert 0.5 < cents[0] < 9.0 and np.max(np.abs(cents - cents[0])) < 0.9
        np.testing.assert_allclose(whole.real / short.real, 1.0, atol=0.2)
