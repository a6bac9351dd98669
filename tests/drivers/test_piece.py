"""The bundled piece: what its script writes, long enough, in voices, and in a guitarist's reach at every moment."""

import io
import pathlib

import numpy as np
import pytest
from tool_scripts import load_tool

from ukrt.drivers.files.midi import load_midi_file

ROOT = pathlib.Path(__file__).resolve().parents[2]
PIECE = ROOT / "ukrt" / "data" / "romance.mid"


@pytest.fixture(scope="module")
def script():
    return load_tool("make_piece")


def test_the_script_reproduces_the_file(script):
    buffer = io.BytesIO()
    script.make_piece()[0].save(file=buffer)
    assert buffer.getvalue() == PIECE.read_bytes()


def test_the_file_is_a_whole_piece_in_three_voices():
    score = load_midi_file(PIECE)
    assert 60.0 <= score.duration_s <= 150.0
    assert score.warnings == () and score.title == "Romance"
    assert score.track_names[1:] == ("melody", "accompaniment", "bass")
    assert "public domain" in score.copyright and "MIT" in score.copyright
    on = (score.status == 0x90) & (score.data2 > 0)
    assert score.n_notes > 400
    assert np.min(score.data1[on]) >= 40 and np.max(score.data1[on]) <= 64 + 19
    velocities = score.data2[on]
    assert np.min(velocities) >= 50 and np.max(velocities) <= 100 and np.std(velocities) > 5


def test_every_note_on_has_its_note_off_before_the_key_sounds_again():
    score = load_midi_file(PIECE)
    sounding = set()
    for status, key, velocity in zip(score.status, score.data1, score.data2, strict=True):
        if status == 0x90 and velocity:
            assert key not in sounding
            sounding.add(key)
        elif status == 0x80:
            sounding.remove(key)
    assert not sounding


def test_six_strings_and_four_frets_suffice_at_every_moment(script):
    notes = script.make_piece()[1]
    for note in notes:
        assert note.end > note.start and 0 <= note.fret <= 12
        held = [other for other in notes if other.start <= note.start < other.end]
        assert len({other.string for other in held}) == len(held) <= 6
        frets = [other.fret for other in held if other.fret > 0]
        assert max(frets, default=0) - min(frets, default=0) <= 4, (note, held)
    assert max(sum(other.start <= note.start < other.end for other in notes) for note in notes) == 6


def test_the_melody_is_the_loudest_voice(script):
    notes = script.make_piece()[1]
    mean = {
        voice: np.mean([note.velocity for note in notes if note.voice == voice])
        for voice in ("melody", "bass", "accompaniment")
    }
    assert mean["melody"] > mean["bass"] + 5 > mean["accompaniment"] + 10
