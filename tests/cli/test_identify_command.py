"""``ukrt identify`` from files to a preset that loads: every format, what is said, what is refused."""

import numpy as np
import pytest
import scipy.io
import soundfile
from identify.bridge_responses import RATE, THREE, admittance, measure, table_i

from ukrt.cli.main import main
from ukrt.identify.measurement import PATHS
from ukrt.model.body import body_modes, bridge_ends, end_weights
from ukrt.model.modes import receptance
from ukrt.model.presets import load_preset


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty working folder with the three responses of Table I as ``bb.wav``, ``bt.wav`` and ``tt.wav``."""
    monkeypatch.chdir(tmp_path)
    responses = measure(table_i()).responses
    for name, column in zip(("bb", "bt", "tt"), responses.T, strict=True):
        soundfile.write(f"{name}.wav", column, RATE, subtype="FLOAT")
    return tmp_path


def identify(*argv):
    return main(["identify", *map(str, argv)])


def test_a_preset_that_loads_and_moves_like_the_truth(folder, capsys):
    assert identify("bb.wav", "bt.wav", "tt.wav", "-o", "mine.toml", "--plot", "fit.png") == 0
    out, err = capsys.readouterr()
    assert "mine.toml: 10 modes" in out and "89.40" in out and "dB" in out and err == ""
    assert (folder / "fit.png").read_bytes().startswith(b"\x89PNG") and (folder / "fit.png").stat().st_size > 50_000
    text = (folder / "mine.toml").read_text()
    assert text.startswith("# ") and "bt.wav" in text and "Eigensystem" in text and "-5" in text
    guitar, classical = load_preset("mine.toml"), load_preset("classical")
    assert guitar.name == "mine" and guitar.strings == classical.strings and guitar.pluck == classical.pluck
    frequencies = np.arange(50.0, 1000.0, 0.5)
    for place in (0.0, 0.2, 0.4, 0.6, 0.8, 1.0):
        shapes = end_weights([place]) @ bridge_ends(guitar.body)
        s = 2j * np.pi * frequencies
        made = s * receptance(body_modes(guitar.body), shapes, s)[:, 0, 0]
        true = admittance(table_i(), frequencies, place, place)
        assert np.abs(20 * np.log10(np.abs(made / true))).max() < 0.15
    assert {path.name for path in folder.iterdir()} == {"bb.wav", "bt.wav", "tt.wav", "mine.toml", "fit.png"}


def test_the_same_measurement_gives_the_same_bytes(folder):
    for name in ("a", "b"):
        (folder / name).mkdir()
        assert identify("bb.wav", "-o", f"{name}/mine.toml", "--plot", f"{name}/fit.png") == 0
    for file in ("mine.toml", "fit.png"):
        assert (folder / "a" / file).read_bytes() == (folder / "b" / file).read_bytes()


def frequencies_of(name):
    return load_preset(name).body.frequencies_hz


def test_other_guitars_and_fewer_modes(folder):
    assert (
        identify(
            "bb.wav", "bt.wav", "tt.wav", "-o", "d.toml", "--preset", "drop-d", "--modes", 4, "--set", "pluck.place=0.8"
        )
        == 0
    )
    guitar = load_preset("d.toml")
    assert guitar.strings[0].note == 38 and guitar.pluck.place == 0.8 and len(guitar.body.frequencies_hz) == 4
    assert identify("bb.wav", "-o", "low.toml", "--max-hz", 400, "--min-hz", 150) == 0
    assert frequencies_of("low.toml") == pytest.approx([182.6, 229.9, 310.2], rel=1e-3)


def test_named_paths_channels_and_notes(folder, capsys):
    whole = measure(table_i(), paths=("treble-treble", "bass-treble")).responses
    soundfile.write("stereo.wav", whole, RATE, subtype="FLOAT")
    assert identify("stereo.wav@treble-treble,bass-treble", "-o", "a.toml") == 0
    assert load_preset("a.toml").body.shapes_bass[3] == pytest.approx(-0.702, abs=0.02)
    assert capsys.readouterr().err == ""
    assert identify("bb.wav@bass-bass", "tt.wav@treble-treble", "-o", "b.toml") == 0
    assert load_preset("b.toml").body.shapes_bass[3] == pytest.approx(0.702, abs=0.02)
    assert "sign" in capsys.readouterr().err and "sign" in (folder / "b.toml").read_text()


def close_to_table_i(name):
    body, modes = load_preset(name).body, table_i()
    assert body.frequencies_hz == pytest.approx(modes.hz, rel=5e-4)
    assert body.damping_ratios == pytest.approx(modes.zeta, rel=0.03)
    assert body.modal_masses == pytest.approx(modes.mass, rel=0.05)
    assert body.shapes_bass == pytest.approx(modes.shapes[:, 0], abs=0.02)


def test_csv_over_time_and_its_units(folder):
    columns = measure(table_i(), quantity="acceleration", rate=8000).responses / 9.81
    rows = np.column_stack([np.arange(len(columns)) / 8000, columns])
    np.savetxt(
        "t.csv",
        rows,
        delimiter=";",
        fmt="%.8g",
        header="measured with care\nt [s];bass-bass;bass-treble;treble-treble",
        comments="# ",
    )
    text = (folder / "t.csv").read_text().replace("# t [s]", "t [s]")
    (folder / "t.csv").write_text(text)
    assert identify("t.csv", "-o", "t.toml", "--quantity", "acceleration", "--scale", 9.81) == 0
    close_to_table_i("t.toml")


@pytest.mark.parametrize("step,first", [(0.5, 0), (0.25, 40)])
def test_csv_of_admittances(folder, step, first):
    hz = np.arange(first, round(2000 / step) + 1) * step
    rng, columns = np.random.default_rng(0), [hz]
    for path in reversed(THREE):
        exact = admittance(table_i(), hz, *PATHS[path])
        noise = 1e-4 * np.abs(exact).max() * (rng.standard_normal((2, len(hz))))
        columns += [exact.real + noise[0], exact.imag + noise[1]]
    names = [f"{path} {part}" for path in reversed(THREE) for part in ("re", "im")]
    np.savetxt("f.csv", np.column_stack(columns), delimiter=",", header=",".join(["f/Hz", *names]), comments="")
    assert identify("f.csv", "-o", "f.toml") == 0
    close_to_table_i("f.toml")


def test_mat_files(folder):
    measurement = measure(table_i())
    scipy.io.savemat("rate.mat", {"fs": float(RATE), "h": measurement.responses})
    scipy.io.savemat("time.mat", {"t": np.arange(len(measurement.responses)) / RATE, "h": measurement.responses.T})
    frequencies, spectra = measurement.spectra()
    scipy.io.savemat("frf.mat", {"f": frequencies[:4000], "H": spectra[:4000]})
    for name in ("rate", "time", "frf"):
        assert identify(f"{name}.mat", "-o", f"{name}.toml") == 0
        close_to_table_i(f"{name}.toml")


def test_taps_are_densities_over_the_rate(folder):
    soundfile.write("taps.wav", measure(table_i()).responses / RATE, RATE, subtype="FLOAT")
    assert identify("taps.wav", "-o", "taps.toml", "--taps") == 0
    close_to_table_i("taps.toml")


def test_without_scipy_the_extra_is_named(folder, capsys, monkeypatch):
    scipy.io.savemat("m.mat", {"fs": 48000.0, "h": np.ones((10, 1))})
    monkeypatch.setitem(__import__("sys").modules, "scipy.io", None)
    assert identify("m.mat", "-o", "m.toml") == 2
    assert "ukrt[measure]" in capsys.readouterr().err


def write_bad_files(folder):
    rng, good = np.random.default_rng(0), soundfile.read("bb.wav")[0]
    soundfile.write("silent.wav", np.zeros(48000), RATE)
    soundfile.write("noise.wav", rng.standard_normal(96000), RATE, subtype="FLOAT")
    soundfile.write("clipped.wav", np.clip(good, -5, 5), RATE, subtype="FLOAT")
    soundfile.write("full.wav", np.clip(good / 5, -1, 1), RATE, subtype="PCM_24")
    soundfile.write("slow.wav", good[::32], RATE // 32, subtype="FLOAT")
    soundfile.write("other.wav", good, 44100, subtype="FLOAT")
    soundfile.write("short.wav", good[:4800], RATE, subtype="FLOAT")
    soundfile.write("longer.wav", np.tile(good, 2), RATE, subtype="FLOAT")
    soundfile.write("five.wav", rng.standard_normal((96000, 5)), RATE, subtype="FLOAT")
    soundfile.write("nan.wav", np.where(np.arange(len(good)) == 99, np.nan, good), RATE, subtype="FLOAT")
    soundfile.write("empty.wav", np.zeros(0), RATE)
    (folder / "text.wav").write_text("no sound")
    (folder / "odd.csv").write_text("f,re,im,re\n1,2,3,4\n2,3,4,5\n")
    (folder / "nameless.csv").write_text("1,2\n3,4\n5,6\n")
    (folder / "ragged.csv").write_text("t,h\n0,1\n0.1\n")
    (folder / "uneven.csv").write_text("t,h\n0,1\n0.1,2\n0.3,2\n0.4,1\n")
    (folder / "words.csv").write_text("t,h\n0,one\n")
    (folder / "blank.csv").write_text("# nothing\n")
    (folder / "late.csv").write_text("t,h\n1,1\n2,1.5\n3,0\n")
    (folder / "junk.mat").write_bytes(b"MATLAB 5.0 MAT-file" + bytes(200))
    scipy.io.savemat("nothing.mat", {"x": np.ones(3)})
    scipy.io.savemat("timeless.mat", {"h": good[:, None]})


REFUSALS = {
    "silent.wav": "silent",
    "noise.wav": "no mode",
    "clipped.wav": "clipped",
    "full.wav": "clipped",
    "slow.wav": "sample rate of 1500 Hz",
    "bb.wav other.wav": "44100 Hz",
    "bb.wav longer.wav": "same length",
    "short.wav": "lasts 0.1 s",
    "five.wav": "5 responses",
    "nan.wav": "not finite",
    "empty.wav": "empty",
    "text.wav": "not an audio file",
    "none.wav": "no such file",
    ".": "suffix",
    "bb.ogg": "suffix",
    "odd.csv": "pairs",
    "nameless.csv": "name",
    "ragged.csv": "not a table of numbers",
    "uneven.csv": "equal steps",
    "words.csv": "not a table of numbers",
    "blank.csv": "empty",
    "late.csv": "0 s",
    "junk.mat": "not a MAT file",
    "nothing.mat": "variables x",
    "timeless.mat": "no t, time, fs, rate",
    "bb.wav@bass-bass bt.wav@bass-bass": "twice",
    "bb.wav@bass-bass bt.wav": "does not say",
    "bb.wav@bass-tenor": "no path",
    "bb.wav@bass-bass,bass-treble": "2 paths",
    "bt.wav@bass-treble": "driving point",
    "bb.wav --modes 60": "stand out",
    "bb.wav --max-hz 30": "highest frequency",
    "bb.wav --scale 0": "--scale 0",
    "bb.wav --scale 1e9": "is the unit right",
    "bb.wav --scale -1": "wrong sign",
    "bb.wav --preset none": "none",
    "bb.wav --plot no/fit.png": "--plot",
    "bb.wav --plot bb.wav": "measurement itself",
}


def test_bad_input_is_refused_in_one_sentence_and_leaves_nothing(folder, capsys):
    write_bad_files(folder)
    before = {path.name for path in folder.iterdir()}
    for arguments, words in REFUSALS.items():
        assert identify(*arguments.split(), "-o", "mine.toml") == 2, arguments
        out, err = capsys.readouterr()
        assert words in err and err.count("\n") == 1 and out == "", (arguments, err)
        assert {path.name for path in folder.iterdir()} == before
    assert identify("bb.wav", "-o", "mine.txt") == 2 and ".toml" in capsys.readouterr().err
    assert identify("bb.wav", "-o", "no/mine.toml") == 2 and "-o" in capsys.readouterr().err


def test_help_shows_the_order_and_examples(capsys):
    with pytest.raises(SystemExit):
        main(["identify", "--help"])
    out = capsys.readouterr().out
    assert "bass-bass, bass-treble, treble-treble" in out and "examples:" in out
