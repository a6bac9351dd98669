"""Real guitar pieces through the player: nothing dropped, every note in its time, the hand within reason."""

import mido
import pytest
from player_bench import RATE, Bench

PIECES = {  # file: stretched notes and stolen notes allowed, as shares of all notes
    "carcassi-op60-01": (0.01, 0.0),
    "carcassi-op60-03": (0.02, 0.0),
    "dowland-come-again": (0.15, 0.0),
    "sanz-1": (0.04, 0.03),
    "sor-op35-14": (0.0, 0.0),
    "albeniz-rumores": (0.07, 0.01),
}


def messages(path):
    time = 0.0
    for message in mido.MidiFile(path):
        time += message.time
        if not message.is_meta and message.type != "sysex":
            yield round(time * RATE), message.bytes()


@pytest.mark.parametrize("name", PIECES)
def test_pieces_are_played_whole(shared_data, name):
    bench, wanted = Bench(tick=False), 0
    for frame, message in messages(shared_data / "midi" / f"{name}.mid"):
        wanted += message[0] & 0xF0 == 0x90 and message[2] > 0
        bench.send(frame, *message, *[0] * (3 - len(message)))
    bench.finish()
    counters = bench.counters
    assert counters["notes_on"] == counters["notes_played"] == len(bench.plucks()) == wanted > 150
    assert counters["notes_dropped"] == counters["gestures_refused"] == counters["searches_cut_short"] == 0
    stretched, stolen = PIECES[name]
    assert counters["stretches"] <= stretched * wanted and counters["notes_stolen"] <= stolen * wanted
    assert counters["hand_shifts"] < 0.25 * wanted
    assert bench.held() == {} and all(string.sounding == -1 for string in bench.strings)
    for note in bench.log:
        assert note["end_s"] > note["time_s"] and note["string"] is not None
