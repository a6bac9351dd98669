"""The guitarist without a guitar chooses what the engine's does."""

import random

from scores import make_score

from ukrt.engine import player_layout
from ukrt.engine.engine import Engine
from ukrt.model.presets import load_preset
from ukrt.notation import silent
from ukrt.notation.silent import play_silently

RATE = 48000.0


def piece(seed, count, quarters):
    """Chords and single notes, out of range and on percussion too, with pedal and bends."""
    rng = random.Random(seed)
    events = [(0.0, 0xC0, 3, 0)]
    for _ in range(count):
        at, channel = (
            rng.choice([rng.randrange(4 * quarters) / 4, rng.uniform(0, quarters)]),
            rng.choice([0, 0, 0, 1, 9]),
        )
        key = rng.choice([rng.randrange(40, 80), rng.randrange(20, 110)])
        events += [(at, 0x90 | channel, key, 80), (at + rng.uniform(0.1, 3), 0x80 | channel, key, 0)]
    events += [(rng.uniform(0, quarters), 0xB0, 64, rng.choice([0, 127])) for _ in range(6)]
    events += [(rng.uniform(0, quarters), 0xE0, 0, rng.randrange(128)) for _ in range(20)]
    return make_score(events, quarters + 3)


def test_strings_and_frets_are_the_engines():
    guitar, score = load_preset("classical", {"playing.idle_strings": "damped"}), piece(4, 60, 3)
    notes, open_keys, counters = play_silently(guitar, score, RATE)
    engine = Engine(guitar, RATE, signal="strings")
    for at, *message in zip(score.time_s, score.status, score.data1, score.data2, strict=True):
        engine.send(round(at * RATE), *map(int, message))
    while engine.frame < 3.5 * RATE:
        engine.process(8192)
    expected = [note | {"release_frame": note["release_frame"] - engine.lead_frames} for note in engine.note_log()]
    heard = {name: count for name, count in engine.counters().items() if name in counters}
    engine.close()
    assert notes == expected and len(notes) == 60
    assert counters == heard and counters["notes_percussion"] > 0 and counters["notes_folded"] > 0
    assert open_keys == [40, 45, 50, 55, 59, 64]


def test_a_long_piece_is_complete(monkeypatch):
    """As many notes as the log holds one and a half times: nothing is missing, whatever its size."""
    guitar, score = load_preset("classical"), piece(5, 300, 40)
    whole = play_silently(guitar, score)[0]
    read = silent.read_note_log
    monkeypatch.setattr(silent, "LOG_CAPACITY", 200)
    monkeypatch.setattr(silent, "read_note_log", lambda *args: read(*args)[-200:])
    renewed = play_silently(guitar, score)[0]
    assert player_layout.LOG_CAPACITY > 300 == len(renewed)
    kept = [{k: v for k, v in note.items() if k not in ("end_s", "fate")} for note in renewed]
    assert kept == [{k: v for k, v in note.items() if k not in ("end_s", "fate")} for note in whole]
