"""What tests do with ``ukrt play`` on a JACK server."""

import json
import signal
import time

import mido
from take_check import assert_take_is_what_was_heard


def ended(playing, folder, code=0):
    """Wait for the end, check that the take gives the same bits; the report and standard error."""
    _, err = playing.communicate(timeout=40)
    assert playing.returncode == code and "Traceback" not in err, err
    report = json.loads((folder / "report.json").read_text())
    assert_take_is_what_was_heard(folder)
    return report, err


def outlived(server, playing, folder, rate):
    """End the server while ``ukrt play`` plays, start it again at ``rate``; the report of a session that went on."""
    time.sleep(1.0)
    server.end()
    time.sleep(0.5)
    server.start(rate, 256)
    while ") is back" not in (line := playing.stderr.readline()):
        assert line, "ukrt play ended early"
    time.sleep(1.0)
    playing.send_signal(signal.SIGTERM)
    report, _ = ended(playing, folder)
    assert report["reconnections"] == 1 and report["sample_rate"] == rate and report["block_size"] == 256
    assert report["ended"] == "interrupted"
    times = [news["seconds"] for news in report["news"] if "plays on unheard" in news["text"]]
    assert len(times) == 1 and 0.5 < times[0] < report["seconds"] - 1
    return report


def played_keys(take):
    """The keys of all note-ons of a MIDI file, in order."""
    return [message.note for message in mido.MidiFile(take) if message.type == "note_on" and message.velocity]
