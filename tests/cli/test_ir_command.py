"""``ukrt ir`` from records of a hammer to an impulse response that the engine's side loads, with its scale."""

import numpy as np
import pytest
import soundfile
from identify.hammer_records import RATE, error_db, known_response, record

from ukrt.cli.main import main
from ukrt.radiation.impulse_response import load_impulse_response


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def write(name, signal, unit=1.0, rate=RATE, subtype="FLOAT"):
    soundfile.write(name, signal / unit, rate, subtype=subtype)


def ir(*argv):
    return main(["ir", *map(str, argv)])


def test_one_microphone_calibrated(folder, capsys):
    taps = known_response()
    force, pressure = record(taps, noise=2e-5, force_noise=1e-3)
    write("f.wav", force, 50.0)
    write("p.wav", pressure, 2.0, subtype="PCM_24")
    arguments = (
        "f.wav",
        "p.wav",
        "-o",
        "ir.wav",
        "--newtons",
        50,
        "--pascals",
        2,
        "--seconds",
        0.3,
        "--plot",
        "ir.png",
    )
    assert ir(*arguments) == 0
    out, err = capsys.readouterr()
    assert "8 hits" in out and "coherence" in out and "1 channel" in out and err == ""
    assert (folder / "ir.png").read_bytes().startswith(b"\x89PNG")
    info = soundfile.info("ir.wav")
    assert (info.samplerate, info.channels, info.subtype, info.frames) == (RATE, 1, "FLOAT", round(0.3 * RATE))
    loaded = load_impulse_response("ir.wav", RATE)
    for end in range(2):
        for output in range(2):
            assert error_db(loaded.samples[:, end, output], taps, 50, 2500) < -50.0
    assert {path.name for path in folder.iterdir()} == {"f.wav", "p.wav", "ir.wav", "ir.png"}


def test_both_ends_and_two_microphones_in_their_channels(folder):
    responses = [[known_response(2 * end + side) for side in range(2)] for end in range(2)]
    for end, name in enumerate(("bass", "treble")):
        signals = [record(taps, 4, seed=end) for taps in responses[end]]
        write(f"{name}_f.wav", signals[0][0])
        write(f"{name}_l.wav", signals[0][1])
        write(f"{name}_r.wav", signals[1][1])
    bass, treble = (tuple(f"{end}_{what}.wav" for what in "flr") for end in ("bass", "treble"))
    assert ir(*bass, "--treble", *treble, "-o", "ir.wav", "--seconds", 0.3) == 0
    loaded = load_impulse_response("ir.wav", RATE)
    for end in range(2):
        for side in range(2):
            assert error_db(loaded.samples[:, end, side], responses[end][side], 50, 2500) < -50.0
    assert load_impulse_response("ir.wav", 44100).samples.shape[1:] == (2, 2)


def test_further_records_and_one_hit(folder, capsys):
    taps = known_response()
    for n in range(3):
        force, pressure = record(taps, 1, seed=n)
        write(f"f{n}.wav", force)
        write(f"p{n}.wav", pressure)
    assert (
        ir(
            "f0.wav",
            "p0.wav",
            "--more",
            "f1.wav",
            "p1.wav",
            "--more",
            "f2.wav",
            "p2.wav",
            "-o",
            "a.wav",
            "--seconds",
            0.3,
        )
        == 0
    )
    assert "3 hits" in capsys.readouterr().out
    assert ir("f0.wav", "p0.wav", "-o", "b.wav", "--seconds", 0.3) == 0
    out, err = capsys.readouterr()
    assert "1 hit;" in out and "one hit shows no coherence" in err


def test_trim_leaves_out_the_time_of_flight(folder, capsys):
    taps = known_response(flight=0.003)
    for name, signal in zip("fp", record(taps), strict=True):
        write(f"{name}.wav", signal)
    assert ir("f.wav", "p.wav", "-o", "ir.wav", "--seconds", 0.3, "--trim") == 0
    left_out = round(0.3 * RATE) - soundfile.info("ir.wav").frames
    assert 0.002 < left_out / RATE < 0.003 and f"{1e3 * left_out / RATE:.2f} ms" in capsys.readouterr().out
    found = soundfile.read("ir.wav")[0]
    assert error_db(np.concatenate([np.zeros(left_out), found]), taps, 50, 2500) < -30.0


def test_what_ir_writes_of_an_accelerometer_identify_reads(folder):
    """The accelerometer beside the hammer: Table I's driving point, from records to modes."""
    from identify.bridge_responses import impulse_responses, table_i

    from ukrt.model.presets import load_preset

    modes = table_i().below(700.0)
    velocity = impulse_responses(modes, seconds=1.0)[:, 0, 0] / RATE
    velocity[0] /= 2.0  # the sampled integral's half of the step at t = 0
    force, motion = record(velocity, 5, width=4e-4, apart=1.2)
    write("f.wav", force)
    write("v.wav", motion)
    assert ir("f.wav", "v.wav", "-o", "bridge.wav", "--seconds", 1.0) == 0
    assert main(["identify", "bridge.wav", "-o", "mine.toml", "--taps", "--max-hz", "700"]) == 0
    body = load_preset("mine.toml").body
    assert body.frequencies_hz == pytest.approx(modes.hz, rel=5e-4)
    assert body.modal_masses == pytest.approx(modes.mass / modes.shapes[:, 0] ** 2, rel=0.05)


def test_bad_input_is_refused_in_one_sentence_and_leaves_nothing(folder, capsys):
    force, pressure = record(known_response(), 3)
    write("f.wav", force)
    write("p.wav", pressure)
    write("two.wav", np.stack([pressure, pressure], 1))
    write("short.wav", pressure[:-5])
    write("slow.wav", pressure, rate=44100)
    write("silent.wav", 0 * pressure)
    write("clipped.wav", np.clip(force, -5, 5))
    write("nan.wav", np.where(np.arange(len(force)) == 9, np.nan, pressure))
    write("noise.wav", np.random.default_rng(0).standard_normal(len(force)))
    write("tiny_f.wav", force[4000:8800])
    write("tiny_p.wav", pressure[4000:8800])
    (folder / "text.wav").write_text("no sound")
    before = {path.name for path in folder.iterdir()}
    refusals = {
        "f.wav short.wav": "samples",
        "f.wav slow.wav": "sample rate",
        "f.wav silent.wav": "silent",
        "silent.wav p.wav": "silent",
        "clipped.wav p.wav": "clipped",
        "f.wav nan.wav": "not finite",
        "f.wav text.wav": "not an audio file",
        "f.wav none.wav": "no such file",
        "two.wav p.wav": "2 channels",
        "f.wav two.wav p.wav": "3 microphones",
        "f.wav p.csv": "must be one of",
        "tiny_f.wav tiny_p.wav": "4800 samples",
        "f.wav p.wav --seconds 0.8": "cannot be used",
        "noise.wav p.wav": "stands out of its noise",
        "f.wav p.wav --seconds 3": "--seconds",
        "f.wav p.wav --more f.wav": "stands alone",
        "f.wav p.wav --more f.wav two.wav": "microphones",
        "f.wav p.wav --newtons 0": "may not be 0",
        "f.wav p.wav --plot no/x.png": "--plot",
    }
    for arguments, words in refusals.items():
        assert (
            ir(*arguments.split(), "-o", "ir.wav", *([] if "--seconds" in arguments else ["--seconds", 0.25])) == 2
        ), arguments
        out, err = capsys.readouterr()
        assert words in err and err.count("\n") == 1 and out == "", (arguments, err)
        assert {path.name for path in folder.iterdir()} == before
    for target in ("ir.flac", "p.wav", "no/ir.wav"):
        assert ir("f.wav", "p.wav", "-o", target) == 2
