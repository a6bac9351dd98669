"""Machine code that is kept: the same functions without the compiler, or nothing where it cannot be relied on."""

import hashlib
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest

from ukrt.engine import compiled, machine_code
from ukrt.engine.callback_type import CALLBACK
from ukrt.engine.engine import Engine
from ukrt.engine.instance import Instance
from ukrt.engine.kernels import callback, card, convolve, doors, energy, modes, player, ports
from ukrt.model.presets import load_preset

FUNCTIONS = {name: getattr(doors, name) for name in ("flow", "total_energy", "ticks_now")}

_ANOTHER_PROCESS = """
import hashlib, sys
from ukrt.engine.engine import Engine
from ukrt.model.presets import load_preset
engine = Engine(load_preset("paper"), 48000.0)
engine.send(0, 0x90, 52, 100)
print(hashlib.sha256(engine.process(4000).tobytes()).hexdigest(), engine.counters()["notes_on"], "numba" in sys.modules)
"""


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    """A file with some functions, where compiled code can be kept at all."""
    path = tmp_path_factory.mktemp("code") / "some"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(machine_code, "_plays", lambda _path: True)
        machine_code.write(path, FUNCTIONS)
    if not path.exists():
        pytest.skip("compiled code is not kept here")
    return path


def test_another_process_gives_the_same_bits_without_the_compiler():
    compiled.address("callback")  # whoever comes first compiles and keeps
    if not machine_code.kept_file().exists():
        pytest.skip("compiled code is not kept here, or another process is about to")
    engine = Engine(load_preset("paper"), 48000.0)
    engine._function = CALLBACK(callback.callback.address)  # the compiler's own
    engine.send(0, 0x90, 52, 100)
    expected = hashlib.sha256(engine.process(4000).tobytes()).hexdigest()
    got = subprocess.run([sys.executable, "-c", _ANOTHER_PROCESS], capture_output=True, text=True, check=True)
    assert got.stdout.split() == [expected, "1", "False"]


def test_doors_do_what_kernels_do():
    rng = np.random.default_rng(6)
    instance = Instance(load_preset("drop-d"), 44100.0, "bridge-force")
    instance.d[:] += 1e-6 * rng.standard_normal(len(instance.d))
    one, other = ((instance.d.copy(), instance.i.copy()) for _ in range(2))
    for s in range(6):
        for module, name in ((modes, "tune_string"), (ports, "refit_string")):
            getattr(compiled, name)(*one, s)
            getattr(module, name)(*other, s)
    assert compiled.total_energy(*one) == energy.total_energy(*other) != 0.0
    assert one[0].tobytes() == other[0].tobytes()
    compiled.player_reset(*one)
    player.player_reset(*other)
    assert one[0].tobytes() == other[0].tobytes() and one[1].tobytes() == other[1].tobytes()
    assert compiled.flow(3000.0, 0.01, 1e-5) == modes.flow(3000.0, 0.01, 1e-5)
    assert compiled.limiter_gain(2.5) == card.limiter_gain(2.5) < 1.0


def test_the_convolvers_door_empties_what_the_kernel_empties():
    instance = Instance(load_preset("classical"), 48000.0)
    noise = np.random.default_rng(1).standard_normal(len(instance.v))
    expected, got = noise.copy(), noise.copy()
    convolve.convolver_reset(expected, instance.vi.copy())
    compiled.convolver_reset(got, instance.vi.copy())
    assert got.tobytes() == expected.tobytes() != noise.tobytes()


def test_functions_come_back_from_a_file(kept):
    found = machine_code.read(kept)
    assert found.keys() == FUNCTIONS.keys() and all(found.values())
    assert all(found[name] != function.address for name, function in FUNCTIONS.items())


def test_what_another_process_has_kept_is_found_by_its_own_symbols(kept, tmp_path, monkeypatch):
    monkeypatch.setattr(machine_code, "_plays", lambda _path: True)
    names = {"_cache", "_library", "_sig"}
    ours = {
        name: SimpleNamespace(native_name="ours", **{one: getattr(function, one) for one in names})
        for name, function in FUNCTIONS.items()
    }
    machine_code.write(tmp_path / "code", ours)
    assert all(machine_code.read(tmp_path / "code").values())


def test_a_symbol_that_is_not_there_makes_a_file_worthless(kept, tmp_path):
    rest = kept.read_bytes()[32:].replace(b'"ticks_now", "', b'"ticks_now", "no', 1)
    wrong = tmp_path / "wrong"
    wrong.write_bytes(hashlib.sha256(rest).digest() + rest)
    assert rest != kept.read_bytes()[32:] and machine_code.read(wrong) is None


@pytest.mark.parametrize("size", [0, 10, 200, -1])
def test_what_is_torn_counts_for_nothing(kept, tmp_path, size):
    torn = tmp_path / "torn"
    torn.write_bytes(kept.read_bytes()[:size])
    assert machine_code.read(torn) is None


def test_what_cannot_be_played_is_not_kept(tmp_path, kept):
    machine_code.write(tmp_path / "code", FUNCTIONS)  # loads, but lacks what an engine needs
    assert not list(tmp_path.iterdir())


def test_a_folder_that_cannot_be_written_is_no_hindrance(tmp_path):
    machine_code.write(tmp_path / "missing" / "code", FUNCTIONS)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["NUMBA_OPT", "NUMBA_CPU_NAME"])
def test_other_settings_of_the_compiler_are_other_code(monkeypatch, name):
    before = machine_code.kept_file()
    monkeypatch.setenv(name, "1")
    assert machine_code.kept_file() != before
