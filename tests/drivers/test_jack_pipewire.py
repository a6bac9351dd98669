"""The same client over PipeWire's JACK library, where PipeWire is installed: a daemon of our own, without a session."""

import json
import os
import pathlib
import shutil
import subprocess
import sys

import pytest
from drivers.jack_world import wait_until

from ukrt.engine.kernels.jack import process

TESTS = pathlib.Path(__file__).resolve().parents[1]

pytestmark = [
    pytest.mark.jack,
    pytest.mark.skipif(not (shutil.which("pipewire") and shutil.which("pw-jack")), reason="needs pipewire and pw-jack"),
]


@pytest.fixture
def pipewire(tmp_path):
    """A daemon and the environment that leads its clients to it."""
    folder = tmp_path / "run"
    folder.mkdir(mode=0o700)
    environment = {**os.environ, "XDG_RUNTIME_DIR": str(folder), "PIPEWIRE_RUNTIME_DIR": str(folder)}
    environment["XDG_CONFIG_HOME"] = environment["XDG_STATE_HOME"] = str(tmp_path)
    with (tmp_path / "pipewire.log").open("w") as log:
        daemon = subprocess.Popen(["pipewire"], env=environment, stdout=log, stderr=log)
    try:
        wait_until(
            lambda: (folder / "pipewire-0").exists(), lambda: pytest.skip("PipeWire does not start here"), seconds=5.0
        )
        yield daemon, environment
    finally:
        daemon.terminate()
        daemon.wait(10)


def test_every_event_is_heard_at_its_own_frame_and_the_daemons_end_is_noticed(pipewire):
    assert process.address  # compiled before the clock runs
    daemon, environment = pipewire
    environment["PYTHONPATH"] = os.pathsep.join([str(TESTS), str(TESTS.parent), environment.get("PYTHONPATH", "")])
    command = ["pw-jack", sys.executable, str(TESTS / "drivers" / "jack_onsets.py")]
    playing = subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        line = playing.stdout.readline()
        assert line, playing.communicate()[1][-2000:]
        found = json.loads(line)
        assert found["name"] == "ukrt (JACK)" and found["running"]
        assert len(found["delays"]) >= 45 and set(found["delays"]) == {0}
        daemon.terminate()
        out, err = playing.communicate(timeout=30)
        assert playing.returncode == 0, err[-2000:]
        end = json.loads(out)
        assert end["reason"].startswith("the JACK server has let go of ukrt (JACK)") and end["closed"]
    finally:
        playing.kill()
        playing.wait()
