"""What ``ukrt play`` refuses before it opens anything, and what its options mean to the parts."""

import argparse

import pytest

from ukrt.cli.main import main
from ukrt.cli.play_options import add_options, check_options
from ukrt.cli.play_parts import wanted_inputs


def parsed(*arguments):
    parser = argparse.ArgumentParser()
    add_options(parser)
    return parser.parse_args(arguments)


@pytest.mark.parametrize(
    ("words", "argv"),
    [
        ("--driver null plays into no sound card; leave --audio-out away", "--driver null --audio-out x"),
        ("leave --host-api and --latency away", "--driver null --host-api alsa --latency high"),
        ("leave --channels away", "--driver jack --channels 2"),
        ("'0' is not a whole number from 1 to 256", "--channels 0"),
        ("are the server's; leave --block and --rate away", "--driver jack --rate 48000 --block 64"),
        ("leave --midi-virtual and --midi-delay away", "--driver jack --midi-virtual x --midi-delay 0"),
        ("--midi-in all and other inputs", "--midi-in all --midi-in keys"),
        ("--midi-in none and other inputs", "--midi-in none --midi-in keys"),
        ("waits for ever", "a.mid --wait-for-midi --midi-in none"),
        ("--loop: a piece is needed", "--loop"),
        ("--transport: a piece is needed", "--transport --driver jack"),
        ("add --driver jack", "a.mid --transport"),
        ("says when the piece is played; leave --loop away", "a.mid --transport --driver jack --loop"),
        ("leave --wait-for-midi away", "a.mid --transport --driver jack --wait-for-midi"),
        ("--record and --report name the same file", "--record x.mid --report ./x.mid"),
        ("exists already, and takes are never replaced", "--record old.mid"),
        ("--record-audio old.mid: exists already", "--record-audio old.mid"),
        ("is the piece itself", "old.mid --report old.mid"),
        ("--report no/where.json: is a folder or in none", "--report no/where.json"),
        ("not allowed with argument --no-shedding", "--no-shedding --shed-budget 0.8"),
        ("'5' is not a number from 0.1 to 1", "--shed-budget 5"),
        ("'fast' is neither low nor high nor a number from 0 to 10000 ms", "--latency fast"),
        ("'nan' is neither", "--latency nan"),
        ("'-1' is not a number from 0 to 1000 ms", "--midi-delay -1"),
        ("'0' is not a number from 0.1", "--seconds 0"),
        ("'pulse'", "--driver pulse"),
        ("--loop: silent.mid holds no note", "silent.mid --loop --driver null"),
        ("suffix is '.wav'", "--driver null --midi-in none --record take.wav"),
        ("suffix is '.mp3'", "--driver null --midi-in none --record-audio take.mp3"),
        ("absent.toml cannot be read", "--preset classical --preset absent.toml"),
        ("there is no audio output 'banjo'", "--audio-out banjo"),
        ("no audio output has the host API 'banjo'", "--host-api banjo"),
    ],
)
def test_contradictions_are_refused_in_a_sentence(capsys, tmp_path, monkeypatch, words, argv):
    monkeypatch.chdir(tmp_path)
    head = b"MThd\0\0\0\6\0\0\0\1\1\xe0MTrk\0\0\0\4\0\xff\x2f\0"
    for name in ("old.mid", "silent.mid"):
        (tmp_path / name).write_bytes(head)
    assert main(["play", *argv.split()]) == 2
    out, err = capsys.readouterr()
    assert out == "" and err.startswith("ukrt: ") and err.count("\n") == 1 and words in err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["old.mid", "silent.mid"]


@pytest.mark.parametrize(
    "argv",
    [
        "a.mid --driver jack --transport --audio-out none",
        "a.mid --loop --wait-for-midi --seconds 3 --latency 12.5",
        "--midi-in keys --midi-in pads --midi-virtual ukrt --midi-delay 0 --latency low --host-api jack --channels 6",
        "--driver null --rate 44100 --block 64 --shed-budget 0.5 --no-limiter",
        "--wait-for-midi --midi-in none --midi-virtual here",
    ],
)
def test_sense_is_accepted(argv):
    check_options(parsed(*argv.split()))


def test_latency_is_words_or_seconds():
    assert [parsed("--latency", text).latency for text in ("low", "high", "12.5")] == ["low", "high", 0.0125]


@pytest.mark.parametrize(
    ("argv", "wanted"),
    [
        ("", None),
        ("a.mid", []),
        ("a.mid --wait-for-midi", None),
        ("a.mid --midi-in all", "all"),
        ("--midi-in none", []),
        ("--midi-in b --midi-in a --midi-in b", ["b", "a"]),
    ],
)
def test_which_inputs_are_meant(argv, wanted):
    assert wanted_inputs(parsed(*argv.split())) == wanted


def test_help_has_every_promised_option(capsys):
    with pytest.raises(SystemExit):
        main(["play", "--help"])
    text = capsys.readouterr().out
    options = (
        "--driver --audio-out --host-api --channels --rate --block --latency --no-limiter --no-shedding --shed-budget "
        "--midi-in --midi-virtual --midi-delay --preset --set --loop --wait-for-midi --transport --seconds "
        "--record --record-audio --report --quiet --no-status --list"
    )
    assert [o for o in options.split() if f" {o}" not in text] == [] and "examples:" in text
