"""Which string and fret a note gets, against an exhaustive search written without a look at the player's."""

import itertools
import random

import pytest
from player_bench import Bench

from ukrt.engine import player_layout as at

OPEN = (40, 45, 50, 55, 59, 64)
FRETS, SPAN, FINGERS = 19, 4, 4


def strain(frets):
    """Frets beyond the span plus fingers beyond four of stopped ``frets`` (one finger may lie across the lowest)."""
    if not frets:
        return 0
    fingers = 1 + sum(fret > min(frets) for fret in frets)
    return max(0, max(frets) - min(frets) - SPAN + 1) + max(0, fingers - FINGERS)


def playable_ways(chord):
    """Every way to put all notes of ``chord`` on different strings, as tuples of frets."""
    for strings in itertools.permutations(range(len(OPEN)), len(chord)):
        frets = tuple(note - OPEN[s] for note, s in zip(chord, strings, strict=True))
        if all(0 <= fret <= FRETS for fret in frets):
            yield frets


def most_playable(chord):
    """The largest number of notes of ``chord`` that six strings can play at once."""
    for size in range(min(len(chord), len(OPEN)), 0, -1):
        if any(next(playable_ways(part), None) is not None for part in itertools.combinations(chord, size)):
            return size
    return 0


def random_chord(rng, most=8):
    return [rng.randint(40, 83) for _ in range(rng.randint(1, most))]


def play(chord, bench=None, frame=1000):
    bench = bench or Bench()
    for channel, key in enumerate(chord):
        bench.on(frame, key, channel=channel if channel < at.PERCUSSION_CHANNEL else channel + 1)
    return bench


@pytest.fixture(scope="module")
def chords():
    rng = random.Random(20)
    low = [[rng.randint(40, 52) for _ in range(rng.randint(2, 7))] for _ in range(60)]
    high = [[rng.randint(70, 83) for _ in range(rng.randint(2, 7))] for _ in range(60)]
    return [random_chord(rng) for _ in range(150)] + low + high


def test_no_note_of_a_chord_is_dropped_that_six_strings_could_play(chords):
    dropped = 0
    for chord in chords:
        counters = play(chord).counters
        assert counters["notes_played"] == most_playable(chord), chord
        assert counters["notes_played"] + counters["notes_dropped"] == len(chord)
        dropped += counters["notes_dropped"]
    assert dropped > 100  # the sample does hold chords that cannot be played whole


def test_the_hand_is_stretched_only_where_every_way_to_play_the_chord_stretches_it(chords):
    stretched = 0
    for chord in chords:
        least = min((strain([f for f in way if f > 0]) for way in playable_ways(chord)), default=None)
        if least is None:
            continue
        bench = play(chord)
        frets = [fret for _, _, fret in bench.held().values() if fret > 0]
        assert strain(frets) == least, chord
        assert bench.counters["stretches"] == (least > 0)
        stretched += least > 0
    assert 10 < stretched < len(chords) - 50


def test_the_order_of_a_chords_messages_does_not_matter(chords):
    rng = random.Random(21)
    for chord in chords[::5]:
        chord = sorted(set(chord))
        wanted = play(chord)
        for _ in range(4):
            rng.shuffle(chord)
            bench = play(chord)
            same = ("notes_played", "notes_dropped", "stretches", "hand_shift_frets")
            assert [bench.counters[name] for name in same] == [wanted.counters[name] for name in same]
            keys = [sorted(note["midi"] for note in b.log if note["fate"] == "dropped") for b in (bench, wanted)]
            assert keys[0] == keys[1]


def test_note_offs_and_note_ons_of_one_frame_may_come_in_any_order():
    rng, kept = random.Random(22), []
    for _ in range(40):
        first, second = ([rng.randint(45, 75) for _ in range(6)] for _ in range(2))
        results = []
        first, second = sorted(set(first)), sorted(set(second))[:3]
        messages = [(0x80, key, 0) for key in first[::2]] + [(0x91, key, 90) for key in second]
        for _ in range(5):
            bench = Bench()
            for key in first:
                bench.on(0, key)
            for message in messages:
                bench.send(9000, *message)
            bench.run(9001)
            plucks = sorted((s, p[0], p[1]) for frame, s, p in bench.plucks() if frame == 9000)
            fates = sorted((note["midi"], note["channel"], note["fate"], note["end_s"] or -1) for note in bench.log)
            results.append((sorted(bench.held().items()), plucks, bench.counters["notes_stolen"], bench.hand, fates))
            rng.shuffle(messages)
        assert all(result == results[0] for result in results)
        kept.append(sum(fate[2:] == ("played", -1) and fate[1] == 0 for fate in results[0][4]))
    assert sum(kept) > 40  # notes of before that go on


def test_bass_and_melody_outlive_the_inner_notes_of_too_big_a_chord():
    bench = play([60, 62, 64, 65, 67, 41, 79, 69])
    fates = {note["midi"]: note["fate"] for note in bench.log}
    assert fates[41] == fates[79] == "played"
    assert bench.counters["notes_dropped"] == 8 - most_playable([60, 62, 64, 65, 67, 41, 79, 69])


def test_the_lowest_note_is_kept_though_the_others_would_fill_every_string():
    chord = [79, 76, 69, 64, 60, 52, 41]
    assert most_playable(chord[:-1]) == most_playable(chord) == 6
    bench = play(chord)
    fates = {note["midi"]: note["fate"] for note in bench.log}
    assert fates[41] == fates[79] == "played" and bench.counters["notes_dropped"] == 1


def test_more_notes_at_once_than_the_player_weighs_are_all_accounted_for():
    bench = Bench()
    for key in range(40, 84):
        bench.on(100, key)
    assert bench.counters["notes_played"] == 6 and bench.counters["notes_dropped"] == 38
    for key in range(40, 84):
        bench.off(5000, key)
    assert bench.held() == {} and bench.counters["notes_off_unmatched"] == 0


def test_known_chords_lie_as_guitarists_play_them():
    shapes = {
        "E": ((40, 47, 52, 56, 59, 64), {0: 0, 1: 2, 2: 2, 3: 1, 4: 0, 5: 0}),
        "F": ((41, 48, 53, 57, 60, 65), {0: 1, 1: 3, 2: 3, 3: 2, 4: 1, 5: 1}),
        "C": ((48, 52, 55, 60, 64), {1: 3, 2: 2, 3: 0, 4: 1, 5: 0}),
        "D": ((50, 57, 62, 66), {2: 0, 3: 2, 4: 3, 5: 2}),
    }
    for name, (chord, frets) in shapes.items():
        bench = play(chord)
        assert {s: fret for s, (_, _, fret) in bench.held().items()} == frets, name
        assert bench.counters["stretches"] == 0


def stream(seed, notes=300, pedal=True):
    """Random playing, one note to a frame: (frame, bytes)."""
    rng = random.Random(seed)
    frame, held = 0, []
    for _ in range(notes):
        frame += rng.choice((40, 700, 4000))
        while held and rng.random() < 0.5:
            key = held.pop(rng.randrange(len(held)))
            yield frame, (0x80, key, 0)
        if pedal and rng.random() < 0.1:
            yield frame, (0xB0, 64, rng.choice((0, 127)))
        frame += 1
        held.append(rng.randint(36, 88))
        yield frame, (0x90, held[-1], rng.randint(1, 127))


@pytest.mark.parametrize("seed", range(6))
def test_a_sounding_note_is_taken_only_when_no_free_string_can_play_the_new_one(seed):
    bench, steals = Bench(), 0
    for frame, message in stream(seed):
        before, stolen = bench.held(), bench.counters["notes_stolen"]
        pedalled = {s for s in before if bench.i[at.S_STATE + s] == at.PEDALLED}
        bench.send(frame, *message)
        assert len(bench.held()) <= 6
        if bench.counters["notes_stolen"] == stolen:
            continue
        steals += 1
        taken = next(s for s, (key, _, _) in bench.held().items() if bench.i[at.S_ORDER + s] == bench.i[at.I_PLUCKS])
        pitch = OPEN[taken] + bench.held()[taken][2]
        able = [s for s in range(6) if 0 <= pitch - OPEN[s] <= FRETS]
        assert all(s in before for s in able)
        assert taken in pedalled or not any(s in pedalled for s in able)
    assert steals > 3


@pytest.mark.parametrize("seed", range(6))
def test_the_span_is_kept_or_the_stretch_counted_and_no_string_plays_two_notes(seed):
    bench = Bench()
    for frame, message in stream(seed, pedal=False):
        stretches = bench.counters["stretches"]
        bench.send(frame, *message)
        frets = {s: fret for s, (_, _, fret) in bench.held().items() if fret > 0}
        newest = max(range(6), key=lambda s: bench.i[at.S_ORDER + s])
        if message[0] == 0x90 and frets.get(newest):
            assert (bench.counters["stretches"] > stretches) == (strain(list(frets.values())) > 0)
    bench.finish()
    for s in range(6):
        notes = [note for note in bench.log if note["string"] == s]
        for one, following in itertools.pairwise(notes):
            assert one["end_s"] is not None and one["end_s"] <= following["time_s"]


def test_the_hand_covers_what_it_stops_after_every_unstretched_note():
    bench, checked = Bench(), 0
    for frame, message in stream(7, pedal=False):
        shifts = bench.counters["hand_shift_frets"]
        hand = bench.hand
        bench.send(frame, *message)
        assert bench.counters["hand_shift_frets"] - shifts == abs(bench.hand - hand)
        frets = [fret for _, _, fret in bench.held().values() if fret > 0]
        if frets and strain(frets) == 0 and message[0] == 0x90 and bench.held():
            newest = max(range(6), key=lambda s: bench.i[at.S_ORDER + s])
            if bench.held()[newest][2] > 0:
                assert bench.hand <= min(frets) and max(frets) <= bench.hand + SPAN - 1
                checked += 1
    assert checked > 50


def test_a_repeated_note_stays_on_its_string():
    bench = Bench()
    for first in (60, 67, 72):
        bench.on(0 if first == 60 else bench.frame + 10, first)
        home = next(s for s, note in bench.held().items() if note[0] == first)
        bench.on(bench.frame + 5000, first)
        bench.off(bench.frame + 100, first)
        assert bench.held()[home][0] == first
        bench.off(bench.frame + 4000, first)
        assert home not in bench.held()
    assert bench.counters["notes_repeated"] == 3 and bench.counters["notes_stolen"] == 0


def test_twelve_strings_and_one_are_played_by_the_same_rules():
    text = {f"strings.{s}.note": str(40 + 4 * s) for s in range(6)}
    bench = play([40, 44, 48, 52, 56, 60], Bench(text))
    assert bench.counters["notes_played"] == 6
    assert all(fret == 0 for _, _, fret in bench.held().values())
