"""Scores with string and position written into them, and what the compiled player makes of that."""

import random
from collections import Counter
from dataclasses import dataclass, replace

import numpy as np
import pytest
from engine import sysex
from player_bench import RATE, Bench

from ukrt.drivers.files.midi import load_midi_file
from ukrt.model.presets import load_preset
from ukrt.playing.grips import neck_of
from ukrt.playing.matching import playable_notes
from ukrt.playing.written_fingering import choose_fingering, write_fingering
from ukrt.playing.written_notes import written_notes

GUITAR = load_preset("classical")
PIECES = {  # file: notes cut short or let go, hands that no guitarist has
    "carcassi-op60-01": (0, 0),
    "carcassi-op60-03": (0, 0),
    "sanz-1": (0, 0),
    "sor-op35-14": (0, 0),
    "dowland-come-again": (4, 5),  # for four voices
    "albeniz-rumores": (14, 5),  # for piano
}


@dataclass(frozen=True)
class Messages:
    """As much of a Score as is asked for."""

    time_s: np.ndarray
    status: np.ndarray
    data1: np.ndarray
    data2: np.ndarray
    duration_s: float


def score_of(rows):
    """A score of (seconds, status, data1, data2)."""
    rows = sorted(rows, key=lambda row: row[0])
    time_s, *data = (np.array(column) for column in zip(*rows, strict=True))
    return Messages(time_s, *(column.astype(np.uint8) for column in data), float(time_s[-1]))


def notes_of(*notes, channel=0):
    """Rows of notes given as (key, start, end)."""
    for key, start, end in notes:
        yield start, 0x90 | channel, key, 80
        yield end, 0x80 | channel, key, 0


def played(score):
    """The bench after the compiled player has played a score."""
    bench = Bench()
    columns = (np.rint(score.time_s * RATE).astype(int), score.status, score.data1, score.data2)
    for frame, *message in zip(*(column.tolist() for column in columns), strict=True):
        bench.send(frame, *message)
    bench.finish()
    return bench


def random_score(seed, notes=120):
    """Notes and chords on two channels that overlap, pedal included."""
    rng, rows = random.Random(seed), []
    for k in range(notes):
        start = 0.25 * (k // 2)
        rows += notes_of((rng.randint(36, 86), start, start + rng.uniform(0.05, 0.9)), channel=rng.randrange(2))
        if rng.random() < 0.1:
            rows.append((start, 0xB0, 64, rng.choice((0, 127))))
    return score_of(rows)


@pytest.mark.parametrize("seed", range(4))
def test_the_player_does_what_is_written_and_drops_what_it_would_drop_anyway(seed):
    score = random_score(seed)
    written, summary = write_fingering(score, GUITAR)
    bench, free = played(written), played(score)
    assert summary.choice == "look-ahead" and bench.counters["forces_refused"] == 0
    same = ("notes_on", "notes_played", "notes_dropped", "notes_folded", "notes_off_unmatched")
    assert [bench.counters[name] for name in same] == [free.counters[name] for name in same]
    keys = [
        Counter((note["midi"], note["time_s"]) for note in b.log if note["fate"] == "dropped") for b in (bench, free)
    ]
    assert keys[0] == keys[1]
    forced = written.status & 0xF0 == 0xB0
    assert np.count_nonzero(forced & (written.data1 == 20) & (written.data2 > 0)) == bench.counters["notes_played"]


def test_chords_beyond_six_strings_keep_the_same_notes_as_the_player_does():
    rng, neck = random.Random(6), neck_of(GUITAR)
    for _ in range(100):
        chord = rng.sample(range(40, 84), rng.randint(2, 9))
        bench = Bench()
        for key in chord:
            bench.on(100, key)
        kept = {chord[k] for k in playable_notes(chord, neck)}
        assert {note["midi"] for note in bench.log if note["fate"] == "played"} == kept


def test_a_finger_that_is_let_go_ends_its_note_at_that_time():
    score = score_of([*notes_of((43, 0.0, 2.0), (81, 1.0, 2.0))])
    written, summary = write_fingering(score, GUITAR)
    assert (summary.let_go, summary.cut_short) == (1, 0)
    bench = played(written)
    assert [(note["midi"], note["end_s"], note["fate"]) for note in bench.log] == [
        (43, 1.0, "played"),
        (81, 2.0, "played"),
    ]
    assert bench.counters["notes_off_unmatched"] == bench.counters["stretches"] == 0


def test_after_each_moment_the_channel_is_free_again():
    written, _ = write_fingering(
        score_of([*notes_of((64, 0.0, 1.0), (60, 0.0, 1.0)), *notes_of((55, 0.5, 1.0))]), GUITAR
    )
    force = {}
    for time_s, status, data1, data2 in zip(written.time_s, written.status, written.data1, written.data2, strict=True):
        if status == 0xB0:
            force[int(data1)] = int(data2)
        elif status & 0xF0 == 0x90:
            assert force[20] > 0 and force[21] > 0
        last = time_s
    assert force == {20: 0, 21: 0} and last == 1.0


def test_all_that_is_not_the_choice_stays_as_it_was():
    rng = random.Random(9)
    melody = [(rng.randint(40, 83), 0.2 * k, 0.2 * (k + 1)) for k in range(60)]
    score = score_of([*notes_of(*melody), *((0.07 * k, 0xE0, k, 64) for k in range(60)), (1.0, 0xB0, 7, 90)])
    written, summary = write_fingering(score, GUITAR)
    ours = (written.status & 0xF0 == 0xB0) & ((written.data1 == 20) | (written.data1 == 21))
    assert summary.let_go == 0
    for name in ("time_s", "status", "data1", "data2"):
        assert np.array_equal(getattr(written, name)[~ours], getattr(score, name))
    assert choose_fingering(score, GUITAR, "causal")[0] is score


def test_a_score_that_names_its_strings_is_left_alone():
    rows = [*notes_of((64, 0.0, 1.0)), (0.0, 0xB0, 20, 3)]
    score = score_of(rows)
    same, summary = write_fingering(score, GUITAR)
    assert same is score and summary.choice == "causal" and "CC 20" in summary.why
    hexaphonic = score_of(
        [
            row
            for k, note in enumerate((64, 59, 55, 50, 45, 40))
            for row in notes_of((note + 5, 0.1 * k, 1.0), channel=k)
        ]
    )
    same, summary = write_fingering(hexaphonic, GUITAR)
    assert same is hexaphonic and "channel for each string" in summary.why
    on_two = replace(hexaphonic, status=(hexaphonic.status & 0xF1).astype(np.uint8))
    assert write_fingering(on_two, GUITAR)[1].choice == "look-ahead"


def test_a_score_that_moves_keys_is_left_to_the_player():
    notes = list(notes_of((60, 1, 2), (64, 1.5, 2)))
    still = [sysex.general_midi(1), sysex.master_fine(8000), sysex.scale_tuning([5] * 12), sysex.master_volume(1028)]
    moving = [sysex.master_coarse(70), sysex.note_tuning({60: 62.0}), sysex.note_tuning({60: 62.0}, bank=0)]
    for message in still + moving:
        rows = [(0.5, *piece) for piece in sysex.messages(message)]
        rows.insert(1, (0.5, 0xB0, 1, 0))  # of another track, between the pieces
        score = score_of([*rows, *notes])
        written, summary = write_fingering(score, GUITAR)
        assert (summary.choice == "causal") == (message in moving) == (written is score)
    for value, choice in ((64, "look-ahead"), (65, "causal")):
        rows = [(0.1, 0xB0, 101, 0), (0.1, 0xB0, 100, 2), (0.1, 0xB1, 100, 0), (0.2, 0xB0, 6, value)]
        assert write_fingering(score_of([*rows, *notes]), GUITAR)[1].choice == choice


def test_channels_are_names_and_nothing_more():
    score = random_score(11)
    swapped = replace(score, status=score.status ^ np.uint8(0x0D))  # 0 and 1 become 13 and 12
    plucks = [
        sorted((note["time_s"], note["midi"], note["string"] is None or note["string"]) for note in played(one).log)
        for one in (write_fingering(score, GUITAR)[0], write_fingering(swapped, GUITAR)[0])
    ]
    assert plucks[0] == plucks[1]


def test_the_sostenuto_pedal_keeps_what_is_down():
    rows = [*notes_of((60, 0, 2), (64, 1.5, 3), (67, 1, 2)), (1.2, 0xB0, 66, 127), (4, 0xB0, 66, 0), (5, 0xB0, 64, 0)]
    assert {note.key: note.end_s for note in written_notes(score_of(rows))} == {60: 4, 64: 3, 67: 4}
    rows += [(1.9, 0xB0, 64, 127)]
    assert {note.key: note.end_s for note in written_notes(score_of(rows))} == {60: 5, 64: 5, 67: 5}
    rows = [*notes_of((60, 0, 2), (64, 1.5, 3)), (1.2, 0xB0, 66, 127), (2.5, 0xB0, 121, 0)]
    assert {note.key: note.end_s for note in written_notes(score_of(rows))} == {60: 2.5, 64: 3}


def test_keys_and_pedals_mean_what_they_mean_to_the_player():
    rows = [*notes_of((60, 0.0, 1.0), (60, 0.5, 2.0), (64, 0.0, 0.6)), (0.4, 0xB0, 64, 127), (1.5, 0xB0, 64, 0)]
    rows += [(0.0, 0x91, 50, 80), (0.7, 0xB1, 123, 0), (0.0, 0x99, 50, 80)]
    found = {(note.key, note.start_s): (note.key_up_s, note.end_s) for note in written_notes(score_of(rows))}
    assert found == {(60, 0.0): (0.5, 0.5), (60, 0.5): (2.0, 2.0), (64, 0.0): (0.6, 1.5), (50, 0.0): (0.7, 0.7)}


@pytest.mark.parametrize("name", PIECES)
def test_pieces_lie_under_the_hand(shared_data, name):
    score = load_midi_file(shared_data / "midi" / f"{name}.mid")
    written, summary = write_fingering(score, GUITAR)
    bench, free = played(written), played(score)
    cut, beyond = PIECES[name]
    assert summary.cut_short + summary.let_go <= cut and summary.given_up == 0
    assert bench.counters["notes_played"] == score.n_notes and bench.counters["forces_refused"] == 0
    assert bench.counters["hand_shifts"] <= free.counters["hand_shifts"]
    neck, hands = neck_of(GUITAR), 0
    for time_s in sorted({note["time_s"] for note in bench.log}):
        frets = [-1] * 6
        for note in bench.log:
            if note["time_s"] <= time_s < note["end_s"] - 0.05:
                frets[note["string"]] = note["fret"]
        hands += not neck.grip(tuple(frets)).possible
    assert hands <= beyond
