"""``ukrt play`` on a real audio server through PortAudio: JACK with its dummy driver."""

import re
import signal
import time

from jack_play import ended, outlived
from jack_servers import NEEDS_JACK

pytestmark = NEEDS_JACK


def test_devices_lists_the_server(server, ukrt_process):
    code, out, _ = ukrt_process("devices", environment=server.environment)
    assert code == 0
    assert re.search(r"\*.*system.*JACK", out)
    assert f"JACK server {server.name}: 48000 Hz, 128 frames, not real time" in out
    assert "system:playback_1" in out
    assert "fails name = PortAudio" not in server.log.read_text(), "clients that just vanish hold their server up"


def test_a_piece_is_played_and_kept(begin, piece, server, tmp_path):
    options = ("--seconds", 2, "--no-shedding", "--driver", "portaudio", "--channels", 1)
    report, err = ended(begin(piece, *options), tmp_path)
    assert "JACK" in report["output"] and err == "" and not report["session"]["away"]
    assert (report["sample_rate"], report["block_size"]) == (48000.0, 128)
    assert report["counters"]["notes_on"] == 2 and report["counters"]["midi_dropped"] == 0
    assert report["counters"]["blocks"] > 0.5 * 2 * 48000 / 128  # machines are noisy
    assert "fails name = PortAudio" not in server.log.read_text()


def test_a_rate_that_the_server_does_not_run_at_is_refused(server, ukrt_process, piece):
    code, out, err = ukrt_process("play", piece, "--rate", "44100", environment=server.environment)
    assert (code, out) == (2, "")
    assert err.splitlines()[-1].startswith("ukrt: ") and "--rate 48000" in err


def test_another_client_plays_the_guitar(begin, sequencer, ukrt_process, server, tmp_path):
    assert "sequencer" in ukrt_process("devices", environment=server.environment)[1]
    playing = begin("--midi-in", "sequencer")
    while "listening to sequencer" not in (line := playing.stderr.readline()):
        assert line, "ukrt play ended early"
    time.sleep(2.0)
    playing.send_signal(signal.SIGINT)
    report, _ = ended(playing, tmp_path)
    assert 2 <= report["counters"]["notes_on"] <= 12  # 2 a second
    assert report["midi"][0]["received"] >= 2


def test_a_server_that_dies_and_comes_back(begin, server, piece, tmp_path):
    playing = begin(piece, "--driver", "portaudio", "--loop")
    report = outlived(server, playing, tmp_path, 48000)
    assert report["session"]["changes"] == 0
