"""The wheel: holds presets, impulse responses and the piece, and works outside the checkout."""

import os
import pathlib
import subprocess
import sys
import zipfile

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    pytest.importorskip("hatchling", reason="the wheel is built by hatchling, which `pip install '.[test]'` brings")
    folder = tmp_path_factory.mktemp("wheel")
    command = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    (built,) = folder.glob("*.whl")
    return built


def test_holds_all_code_and_data_and_nothing_else(wheel):
    names = {n for n in zipfile.ZipFile(wheel).namelist() if not n.split("/")[0].endswith(".dist-info")}
    code = {str(p.relative_to(ROOT)) for p in (ROOT / "ukrt").rglob("*.py")}
    data = {str(p.relative_to(ROOT)) for suffix in ("mid", "wav") for p in (ROOT / "ukrt").rglob(f"*.{suffix}")}
    presets = {f"ukrt/presets/{p.name}" for p in (ROOT / "presets").glob("*.toml")}
    assert presets and any(n.endswith(".mid") for n in data) and any(n.endswith(".wav") for n in data)
    assert code | data | presets <= names
    assert {pathlib.PurePosixPath(n).parts[0] for n in names} == {"ukrt"}


def test_works_outside_the_checkout(wheel, tmp_path):
    zipfile.ZipFile(wheel).extractall(tmp_path / "site")
    code = (
        "import ukrt\n"
        "assert 'site' in ukrt.__file__, ukrt.__file__\n"
        "from ukrt.drivers.files.bundled import ROMANCE\n"
        "from ukrt.drivers.files.midi import load_midi_file\n"
        "from ukrt.radiation.impulse_response import load_impulse_response\n"
        "for name in ukrt.preset_names():\n"
        "    guitar = ukrt.load_preset(name)\n"
        "    assert len(load_impulse_response(guitar.radiation.impulse_response, 48000).samples)\n"
        "assert load_midi_file(ROMANCE).duration_s >= 60\n"
        "print(*ukrt.preset_names())\n"
    )
    environment = {**os.environ, "PYTHONPATH": str(tmp_path / "site")}
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert set(done.stdout.split()) == {p.stem for p in (ROOT / "presets").glob("*.toml")}
