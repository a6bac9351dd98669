"""What the tests of the command line share."""

import mido
import pytest


@pytest.fixture
def piece(tmp_path):
    """A MIDI file with two notes in half a second."""
    file = mido.MidiFile(ticks_per_beat=480)
    track = mido.MidiTrack()
    file.tracks.append(track)
    track.append(mido.Message("note_on", note=52, velocity=90))
    track.append(mido.Message("note_on", note=64, velocity=90, time=240))
    track.append(mido.Message("note_off", note=52, time=120))
    track.append(mido.Message("note_off", note=64, time=120))
    file.save(tmp_path / "piece.mid")
    return tmp_path / "piece.mid"
