"""The command's manners: help that teaches, every refusal one sentence with exit code 2, lists, printed presets."""

import pathlib
import subprocess
import sys
import tomllib

import pytest

import ukrt
from ukrt.cli.main import main

ROOT = pathlib.Path(__file__).resolve().parents[2]
COMMANDS = ("render", "play", "devices", "presets", "simulate", "bench", "figures")


def refused(capsys, *argv):
    """The one sentence with which ``argv`` is refused."""
    assert main([str(a) for a in argv]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("ukrt: ") and err.count("\n") == 1 and err.endswith("\n")
    assert "Traceback" not in err
    return err


def shown(capsys, *argv):
    """What ``argv`` prints to standard output before it exits with 0."""
    try:
        code = main([str(a) for a in argv])
    except SystemExit as leaving:  # argparse leaves this way after --help and --version
        code = leaving.code
    assert code in (0, None)
    return capsys.readouterr().out


def test_version(capsys):
    assert shown(capsys, "--version").strip() == f"ukrt {ukrt.__version__}"


def test_help_names_every_command_and_gives_examples(capsys):
    text = shown(capsys, "--help")
    assert "examples:" in text
    assert all(f"\n    {command} " in text for command in COMMANDS)


@pytest.mark.parametrize("command", COMMANDS)
def test_help_of_each_command(capsys, command):
    text = shown(capsys, command, "--help")
    assert text.startswith(f"usage: ukrt {command}")
    assert "examples:" in text or "Choose with" in text


def test_render_has_every_promised_option(capsys):
    text = shown(capsys, "render", "--help")
    options = (
        "-o --preset --set --rate --block --bits --signal --gain --normalize --tail-db --max-minutes --force --report"
    )
    assert [o for o in options.split() if f" {o}" not in text] == []


@pytest.mark.parametrize(
    ("argv", "words"),
    [
        ((), "COMMAND"),
        (("rendr",), "rendr"),
        (("render",), "IN.mid"),
        (("render", "a.mid", "--rate", "fast"), "'fast' is not a whole number from 44100 to 192000 Hz"),
        (("render", "a.mid", "--rate", "nan"), "'nan' is not a whole number"),
        (("render", "a.mid", "--block", "8193"), "'8193' is not a whole number from 1 to 8192 frames"),
        (("render", "a.mid", "--bits", "8"), "--bits"),
        (("render", "a.mid", "--signal", "smell"), "--signal"),
        (("render", "a.mid", "--gain", "nan"), "'nan' is not a number from -200 to 200 dB"),
        (("render", "a.mid", "--tail-db", "3"), "'3' is not a number from -200 to -1 dB"),
        (("render", "a.mid", "--set", "pluck.place"), "'pluck.place' is not KEY=VALUE"),
        (("render", "a.mid", "--preset", "banjo"), "banjo"),
        (("render", "a.mid", "--set", "pluck.plaice=0.9"), "plaice"),
        (("render", "a.mid", "--set", "pluck.place=2"), "from 0.01 to 0.99"),
        (("render", "absent.mid"), "absent.mid: no such file"),
        (("render", "absent.mid", "-o", "a.mp3"), "'.mp3'"),
        (("render", "absent.mid", "--report", "no/such/folder.json"), "--report"),
        (("play", "absent.mid", "--driver", "null"), "absent.mid: no such file"),
        (("presets", "--set", "pluck.place=0.9"), "name it"),
        (("bench", "--seconds", "0"), "'0' is not a number from 1 to 600 s"),
    ],
)
def test_refusals_are_one_sentence(capsys, tmp_path, monkeypatch, argv, words):
    monkeypatch.chdir(tmp_path)
    assert words in refused(capsys, *argv)
    assert list(tmp_path.iterdir()) == []


def test_an_existing_file_is_kept_unless_named_or_forced(capsys, tmp_path):
    (tmp_path / "song.mid").write_bytes(b"MThd")
    (tmp_path / "song.wav").write_bytes(b"precious")
    text = refused(capsys, "render", tmp_path / "song.mid")
    assert "song.wav exists already" in text and "--force" in text
    assert (tmp_path / "song.wav").read_bytes() == b"precious"


def test_the_input_is_never_the_output(capsys, tmp_path):
    song = tmp_path / "song.wav"
    song.write_bytes(b"MThd, with a wrong suffix")
    for argv in ((song,), (song, "--force"), (song, "-o", song)):
        assert "is the input itself" in refused(capsys, "render", *argv)
    assert song.read_bytes() == b"MThd, with a wrong suffix"


def test_presets_are_listed_with_a_line_each(capsys):
    lines = shown(capsys, "presets").splitlines()
    assert [line.split()[0] for line in lines] == ukrt.preset_names()
    assert {"classical", "drop-d", "paper"} <= set(ukrt.preset_names())
    assert all(len(line.split(maxsplit=1)[1]) > 10 for line in lines)


@pytest.mark.parametrize("name", ukrt.preset_names())
def test_a_printed_preset_loads_to_the_same_guitar(capsys, tmp_path, name):
    text = shown(capsys, "presets", name)
    copy = tmp_path / "copy.toml"
    copy.write_text(text, encoding="utf-8")
    assert ukrt.load_preset(copy) == ukrt.load_preset(name)
    assert shown(capsys, "presets", copy) == text


def test_set_takes_the_keys_that_presets_prints(capsys, tmp_path):
    printed = tomllib.loads(shown(capsys, "presets", "classical", "--set", "pluck.place=0.8125"))
    assert printed["pluck"]["place"] == 0.8125
    printed = tomllib.loads(shown(capsys, "presets", "classical", "--set", "strings.0.tension=70.5"))
    assert printed["strings"][0]["tension"] == 70.5


def test_devices_without_a_sound_card_is_no_failure(capsys):
    text = shown(capsys, "devices")
    assert "audio outputs" in text and "MIDI inputs" in text
    assert shown(capsys, "play", "--list") == text


def test_missing_live_extra_is_named(capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "rtmidi", None)
    assert "pip install 'ukrt[live]'" in refused(capsys, "play", "--driver", "null")


def test_importing_ukrt_loads_neither_compiler_nor_numpy():
    heavy = ("numpy", "numba", "rich", "soundfile")
    code = f"import sys, ukrt, ukrt.cli.main; print([m for m in {heavy} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, check=True)
    assert done.stdout.strip() == "[]"


def test_public_names_survive_the_import_of_their_modules():
    code = (
        "import ukrt.render, ukrt.synth, ukrt; print(callable(ukrt.render), callable(ukrt.Synth), sorted(ukrt.__all__))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, check=True)
    assert done.stdout.strip() == f"True True {sorted(ukrt.__all__)}"
    with pytest.raises(AttributeError, match="public names are"):
        ukrt.banjo  # noqa: B018


def test_python_dash_m_is_the_same_command(ukrt_process):
    code, out, err = ukrt_process("presets", "banjo")
    assert (code, out) == (2, "") and err.startswith("ukrt: ") and err.count("\n") == 1


def test_a_closed_pipe_is_no_failure():
    command = f"{sys.executable} -m ukrt presets classical | true"  # true is gone before the first line is written
    done = subprocess.run(["bash", "-c", f"set -o pipefail; {command}"], capture_output=True, text=True, cwd=ROOT)
    assert (done.returncode, done.stderr) == (0, "")


def test_words_alone_need_no_compiler_and_no_arrays():
    """``--help`` and refusals come at once: what computes is imported by the command that is run."""
    program = "import sys; from ukrt.cli.main import make_parser; make_parser(); print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout.split()
    assert "ukrt.cli.doctor" in loaded
    assert not {"numba", "numpy", "llvmlite", "mido", "soundfile", "matplotlib"} & set(loaded)
