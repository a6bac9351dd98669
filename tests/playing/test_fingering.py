"""The search for string, fret and position, against every fingering there is, and against what hands can do."""

import itertools
import random

import pytest

from ukrt.model.presets import load_preset
from ukrt.playing import fingering_costs as cost
from ukrt.playing.fingering import Note, find_fingering
from ukrt.playing.grips import FINGERS, Neck, neck_of
from ukrt.playing.matching import playable_notes


@pytest.fixture(scope="module")
def neck():
    return neck_of(load_preset("classical"))


@pytest.fixture(scope="module")
def small_neck(neck):
    """Three strings, four frets under a small hand: few enough ways to try them all."""
    return Neck((55, 59, 64), 4, neck.places[:5], neck.places[2] - neck.places[1])


def random_music(rng, neck, moments, step=0.2, longest=0.5):
    """Notes and small chords that overlap (list of Note)."""
    notes, high = [], max(neck.open) + neck.frets
    for k in range(moments):
        for pitch in rng.sample(range(min(neck.open), high + 1), rng.choice((1, 1, 2))):
            length = rng.uniform(0.1, longest)
            notes.append(Note(k * step, k * step + length, k * step + length, pitch))
    return notes


def points_of(path, notes, neck, starts):
    """What a whole fingering costs, written down from the table of costs; None where it breaks a rule.

    ``path``: for each moment (string of each new note, position, strings whose finger is lifted).
    """
    points, occupied, hand, last_s, last_strings = 0.0, {}, None, None, {}
    for time_s, (strings, position, lifted) in zip(starts, path, strict=True):
        rings = {s: n for s, n in occupied.items() if notes[n].end_s > time_s + cost.LEGATO_SECONDS}
        new = starts[time_s]
        if len(set(strings)) < len(strings) or not set(lifted) <= set(rings) - set(strings):
            return None
        for s in (*lifted, *strings):
            if s in rings:
                note = notes[rings.pop(s)]
                points += cost.CUT_HELD + cost.CUT_HELD_ALL * (note.end_s - time_s) / (note.end_s - note.start_s)
        for n, s in zip(new, strings, strict=True):
            fret = notes[n].pitch - neck.open[s]
            if not 0 <= fret <= neck.frets:
                return None
            points += cost.FRET * fret
            points += cost.OTHER_STRING * (last_strings.get(notes[n].pitch, s) != s)
        rings |= dict(zip(strings, new, strict=True))
        frets = [notes[rings[s]].pitch - neck.open[s] if s in rings else -1 for s in range(len(neck.open))]
        points += neck.grip(tuple(frets)).points[position]
        if hand is not None and hand != position:
            way = abs(neck.places[hand] - neck.places[position])
            points += cost.SHIFT + cost.SHIFT_M * way * (1 + cost.HURRY_SECONDS / (time_s - last_s))
        occupied, hand, last_s = rings, position, time_s
        last_strings = {notes[n].pitch: s for s, n in rings.items()}
    return points


def cheapest_of_all(notes, neck):
    """The least cost of every fingering, by trying each."""
    starts = {}
    for n in sorted(range(len(notes)), key=lambda n: notes[n].start_s):
        starts.setdefault(notes[n].start_s, []).append(n)
    for new in starts.values():
        new[:] = [new[k] for k in playable_notes([notes[n].pitch for n in new], neck)]
    board, least = range(len(neck.open)), float("inf")
    liftings = [some for size in range(3) for some in itertools.combinations(board, size)]
    ways = [
        [
            (strings, position, lifted)
            for strings in itertools.permutations(board, len(new))
            if all(0 <= notes[n].pitch - neck.open[s] <= neck.frets for n, s in zip(new, strings, strict=True))
            for position in range(1, neck.frets + 1)
            for lifted in liftings
        ]
        for new in starts.values()
    ]
    for path in itertools.product(*ways):
        points = points_of(path, notes, neck, starts)
        least = least if points is None else min(least, points)
    return least


def test_no_fingering_is_cheaper_than_the_one_that_is_found(small_neck):
    rng, cut, let_go = random.Random(1), 0, 0
    for _ in range(40):
        notes = random_music(rng, small_neck, 3)
        found = find_fingering(notes, small_neck)
        assert found.given_up == 0
        assert found.points == pytest.approx(cheapest_of_all(notes, small_neck), rel=1e-12)
        cut += sum(place.cut_s is not None for place in found.places)
        let_go += sum(place.let_go for place in found.places)
    assert let_go > 3 and cut - let_go > 3


def sounding(notes, places, time_s):
    """Number of each note that sounds at a time, as far as it is not cut short."""
    for n, (note, place) in enumerate(zip(notes, places, strict=True)):
        end = note.end_s if place.cut_s is None else place.cut_s
        if place.string >= 0 and note.start_s <= time_s and end > time_s + cost.LEGATO_SECONDS:
            yield n


@pytest.mark.parametrize("seed", range(8))
def test_no_string_has_two_notes_and_what_sounds_lies_under_the_hand(neck, seed):
    rng = random.Random(seed)
    notes = random_music(rng, neck, 60)
    places = find_fingering(notes, neck).places
    for time_s in sorted({note.start_s for note in notes}):
        there = list(sounding(notes, places, time_s))
        assert len({places[n].string for n in there}) == len(there)
        new = [n for n in there if notes[n].start_s == time_s]
        stopped = [places[n].fret for n in there if places[n].fret > 0]
        if stopped and len(new) == 1:  # a chord may ask for a hand that there is not, one note never does
            hand = places[new[0]].hand
            assert hand <= min(stopped) and len(stopped) <= FINGERS
            assert neck.places[max(stopped)] - neck.places[hand] <= cost.WIDEST * neck.reach
    for note, place in zip(notes, places, strict=True):
        assert place.string < 0 or place.fret == note.pitch - neck.open[place.string]


def test_the_order_of_the_notes_does_not_matter_and_nothing_is_left_to_chance(neck):
    rng = random.Random(5)
    notes = random_music(rng, neck, 80)
    wanted = dict(zip(notes, find_fingering(notes, neck).places, strict=True))
    for _ in range(3):
        rng.shuffle(notes)
        found = find_fingering(notes, neck)
        assert dict(zip(notes, found.places, strict=True)) == wanted


def test_a_note_that_rings_keeps_its_string_if_the_new_one_has_another(neck):
    for low, high in ((40, 64), (45, 60), (52, 57), (57, 60)):
        notes = [Note(0.0, 2.0, 2.0, low), Note(1.0, 2.0, 2.0, high)]
        assert all(place.cut_s is None for place in find_fingering(notes, neck).places)
    notes = [Note(0.0, 2.0, 2.0, 41), Note(1.0, 2.0, 2.0, 43)]  # both on string 6 alone
    first, second = find_fingering(notes, neck).places
    assert first.cut_s == 1.0 and not first.let_go and second.string == first.string == 0


def test_a_finger_that_is_needed_elsewhere_lets_its_note_go(neck):
    held, far = Note(0.0, 2.0, 2.0, 43), Note(1.0, 2.0, 2.0, 81)  # fret 3 of string 6; fret 17 of string 1
    first, second = find_fingering([held, far], neck).places
    assert (first.cut_s, first.let_go) == (1.0, True) and second.cut_s is None
    pedalled = Note(0.0, 0.5, 2.0, 43)  # which nobody's finger has to hold
    assert find_fingering([pedalled, far], neck).places[0].cut_s is None


def test_a_chord_beyond_every_hand_is_played_whole_and_one_beyond_six_strings_by_its_outer_notes(neck):
    wide = [Note(0.0, 1.0, 1.0, pitch) for pitch in (43, 59, 71, 74)]
    found = find_fingering(wide, neck)
    assert all(place.string >= 0 for place in found.places) and found.points > cost.BEYOND_HAND
    many = [Note(0.0, 1.0, 1.0, pitch) for pitch in (41, 60, 62, 64, 65, 67, 69, 79)]
    places = find_fingering(many, neck).places
    assert places[0].string == 0 and places[-1].string >= 0
    assert sorted(place.string for place in places)[:2] == [-1, -1]


def test_five_frets_are_a_stretch_at_the_nut_and_none_at_the_seventh(neck):
    low, high = neck.grip((1, -1, 5, -1, -1, -1)), neck.grip((7, -1, 11, -1, -1, -1))
    assert low.possible and low.stretch_m > 0.02 and high.stretch_m == 0.0
    assert not neck.grip((1, -1, -1, -1, -1, 7)).possible
    assert neck.grip((1, 3, 3, 2, 1, 1)).barre and not neck.grip((1, 3, 3, 2, 0, 1)).possible
    assert not neck.grip((3, 2, 0, 0, 0, 3)).barre


def test_less_time_makes_a_shift_dearer(neck):
    def points(step):
        return find_fingering([Note(0.0, step, step, 41), Note(step, 2 * step, 2 * step, 83)], neck).points

    assert points(0.05) > points(0.2) > points(1.0)
