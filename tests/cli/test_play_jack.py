"""``ukrt play --driver jack``: a client of its own on a real server, JACK with its dummy driver."""

import signal
import time

import pytest
from jack_play import ended, outlived, played_keys
from jack_servers import NEEDS_JACK

from ukrt.cli.main import main

pytestmark = NEEDS_JACK


def test_a_piece_is_played_and_kept(begin, piece, tmp_path):
    report, err = ended(begin(piece, "--seconds", 2, "--no-shedding", "--driver", "jack"), tmp_path)
    assert "JACK" in report["output"] and err == "" and not report["session"]["away"]
    assert (report["sample_rate"], report["block_size"]) == (48000.0, 128)
    assert report["counters"]["notes_on"] == 2 and report["counters"]["midi_dropped"] == 0
    assert report["counters"]["blocks"] > 0.5 * 2 * 48000 / 128  # machines are noisy


def test_without_a_server_its_driver_is_refused(capsys, monkeypatch, piece, tmp_path):
    monkeypatch.setenv("JACK_DEFAULT_SERVER", "ukrt-test-absent")
    monkeypatch.setenv("JACK_NO_START_SERVER", "1")
    assert main(["play", str(piece), "--driver", "jack", "--record", str(tmp_path / "take.mid")]) == 2
    assert "no JACK server 'ukrt-test-absent'" in capsys.readouterr().err
    assert not (tmp_path / "take.mid").exists()


def test_a_piece_waits_for_the_first_note(begin, sequencer, piece, tmp_path):
    sequencer.send_signal(signal.SIGSTOP)
    playing = begin(piece, "--driver", "jack", "--wait-for-midi", "--midi-in", "sequencer", "--seconds", 3)
    time.sleep(0.7)
    sequencer.send_signal(signal.SIGCONT)
    report, _ = ended(playing, tmp_path)
    keys = played_keys(tmp_path / "take.mid")
    assert report["output_counts"]["messages"] > 0 == report["output_counts"]["lost_events"]
    assert 60 in keys and {52, 64} <= set(keys) and keys.index(60) < min(keys.index(52), keys.index(64))


def test_a_server_that_comes_back_at_another_rate(begin, server, piece, tmp_path):
    playing = begin(piece, "--driver", "jack", "--loop")
    report = outlived(server, playing, tmp_path, 44100)
    assert report["session"]["changes"] == 1 and (tmp_path / "heard-2.wav").exists()


def test_a_piece_follows_the_transport(begin, server, piece, tmp_path, monkeypatch):
    jack = pytest.importorskip("jack")
    monkeypatch.setenv("JACK_DEFAULT_SERVER", server.name)
    playing = begin(piece, "--driver", "jack", "--transport", "--seconds", 3)
    master = jack.Client("master", no_start_server=True)
    try:
        time.sleep(0.5)
        for _ in range(2):
            master.transport_frame = 0
            master.transport_start()
            time.sleep(0.7)
            master.transport_stop()
            time.sleep(0.2)
    finally:
        master.close()
    report, _ = ended(playing, tmp_path)
    assert played_keys(tmp_path / "take.mid").count(64) == 2, (
        "the piece's second note, half a second into it, both times"
    )
    assert report["ended"] == "3 s are over"
