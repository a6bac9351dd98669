"""Results as files: what was written comes back, with units, columns, facts and the case; or nothing is written."""

import numpy as np
import pytest
from reference.small_cases import case

from ukrt.errors import MissingExtraError, UkrtError
from ukrt.experiment import result as module
from ukrt.experiment.result import Quantity, Result, check_result_path, load_result, save_result


@pytest.fixture
def result():
    random = np.random.default_rng(1)
    quantities = {
        "drift": Quantity(random.normal(size=5), "m", ()),
        "bridge_force": Quantity(random.normal(size=(5, 2)), "N", ("E2", "A2")),
    }
    facts = {"steps": 4, "step_s": 1e-5, "residual": True, "seconds_taken": 0.25}
    return Result(case("three"), "engine", 1e-5 * np.arange(5), quantities, facts)


@pytest.mark.parametrize("name", ["out.npz", "out.h5", "out.HDF5"])
def test_a_result_comes_back(tmp_path, result, name):
    if not name.endswith("npz"):
        pytest.importorskip("h5py")
    save_result(result, tmp_path / name)
    back = load_result(tmp_path / name)
    assert back.case == result.case and back.solver == "engine" and back.facts == result.facts
    assert np.array_equal(back.times, result.times)
    assert list(back.quantities) and set(back.quantities) == set(result.quantities)
    for key, quantity in result.quantities.items():
        other = back.quantities[key]
        assert np.array_equal(other.values, quantity.values)
        assert (other.unit, other.columns) == (quantity.unit, quantity.columns)
    assert np.array_equal(back.column("bridge_force", "A2"), result["bridge_force"][:, 1])
    assert [path.name for path in tmp_path.iterdir()] == [name]


def test_an_npz_is_read_with_numpy_alone(tmp_path, result):
    save_result(result, tmp_path / "out.npz")
    with np.load(tmp_path / "out.npz") as file:
        assert np.array_equal(file["bridge_force"], result["bridge_force"])
        assert '"unit": "N"' in str(file["metadata"])


def test_a_failure_leaves_the_old_file(tmp_path, result, monkeypatch):
    (tmp_path / "out.npz").write_bytes(b"precious")

    def fails(path, *_):
        path.write_bytes(b"half")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(module, "_write", fails)
    with pytest.raises(UkrtError, match="No space left"):
        save_result(result, tmp_path / "out.npz")
    assert [(path.name, path.read_bytes()) for path in tmp_path.iterdir()] == [("out.npz", b"precious")]


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("out.npz", b"", "no result"),
        ("out.npz", b"PK\x03\x04 torn", "no result"),
        ("out.txt", b"", "ends in"),
        ("absent.npz", None, "no such file"),
        ("out.h5", b"nothing of that kind", "no result"),
    ],
)
def test_what_is_no_result(tmp_path, name, content, words):
    if name.endswith("h5"):
        pytest.importorskip("h5py")
    if content is not None:
        (tmp_path / name).write_bytes(content)
    with pytest.raises(UkrtError, match=words):
        load_result(tmp_path / name)


@pytest.mark.parametrize("suffix", ["npz", "h5"])
@pytest.mark.parametrize("damage", ["cut", "flipped"])
def test_a_damaged_result(tmp_path, result, suffix, damage):
    if suffix == "h5":
        pytest.importorskip("h5py")
    path = tmp_path / f"out.{suffix}"
    save_result(result, path)
    content = bytearray(path.read_bytes())
    if damage == "cut":
        content = content[: len(content) // 2]
    else:
        start = content.find(b"bridge_force.npy" if suffix == "npz" else b"GCOL") + 60
        content[start : start + 100] = bytes(255 - byte for byte in content[start : start + 100])
    path.write_bytes(content)
    with pytest.raises(UkrtError, match="no result"):
        load_result(path)


def test_an_npz_of_something_else(tmp_path):
    np.savez(tmp_path / "out.npz", times=np.zeros(3))
    with pytest.raises(UkrtError, match="no result"):
        load_result(tmp_path / "out.npz")


def test_where_a_result_may_go(tmp_path, monkeypatch):
    for name, words in (("out.mat", "written as"), ("no/such/out.npz", "no folder")):
        with pytest.raises(UkrtError, match=words):
            check_result_path(tmp_path / name)
    monkeypatch.setitem(__import__("sys").modules, "h5py", None)
    with pytest.raises(MissingExtraError, match=r"ukrt\[hdf5\]"):
        check_result_path(tmp_path / "out.h5")
