"""What came out of an experiment: arrays with units and axes, and what made them; kept as NPZ or, where large, HDF5."""

import json
import os
import pathlib
import zipfile
import zlib
from dataclasses import dataclass, field

import numpy as np

from .. import __version__
from ..errors import MissingExtraError, UkrtError
from ..model.preset_text import dump_preset
from .case_file import parse_case

SUFFIXES = (".npz", ".h5", ".hdf5")


@dataclass(frozen=True)
class Quantity:
    """One recorded quantity.

    Attributes
    ----------
    values : ndarray (n_times, ...)
    unit : str
        SI.
    columns : tuple of str
        What the second axis is, if there is one.
    """

    values: np.ndarray
    unit: str
    columns: tuple = ()


@dataclass(frozen=True)
class Result:
    """A run of a case.

    Attributes
    ----------
    case : ukrt.experiment.case.Case
    solver : str
    times : ndarray (n_times,) [s]
    quantities : dict of str to Quantity
        Which there are depends on ``case.record``; ``result["energies"]`` is short for their values.
    facts : dict
        About the run: steps, step [s], modes, largest drift [m], seconds taken.
    """

    case: object
    solver: str
    times: np.ndarray
    quantities: dict
    facts: dict = field(default_factory=dict)

    def __getitem__(self, name):
        return self.quantities[name].values

    def column(self, name, label):
        """One column of a quantity: ndarray (n_times,)."""
        quantity = self.quantities[name]
        return quantity.values[:, quantity.columns.index(label)]

    @property
    def rate_hz(self):
        """Kept samples per second [Hz]."""
        return 1.0 / (self.times[1] - self.times[0])


def check_result_path(path):
    """Refuse a name whose ending says no format that results are kept in, or one whose package is missing."""
    path = pathlib.Path(path)
    if path.suffix.lower() not in SUFFIXES:
        raise UkrtError(f"{path}: results are written as {', '.join(SUFFIXES)}; give the file one of these endings")
    if path.suffix.lower() != ".npz":
        _h5py()
    if path.parent != pathlib.Path() and not path.parent.is_dir():
        raise UkrtError(f"{path}: there is no folder {path.parent}")
    return path


def save_result(result, path):
    """Write a result; a file of that name is replaced only once the new one is whole.

    Parameters
    ----------
    result : Result
    path : str or os.PathLike
        Ends in .npz (NumPy; ``metadata`` holds JSON) or .h5 / .hdf5 (attributes hold it).
    """
    metadata = {
        "program": f"ukrt {__version__}",
        "solver": result.solver,
        "case": dump_preset(result.case),
        "facts": result.facts,
    }
    save_quantities({"times": Quantity(result.times, "s"), **result.quantities}, metadata, path)


def save_quantities(quantities, metadata, path):
    """Write arrays with their units; a file of that name is replaced only once the new one is whole.

    Parameters
    ----------
    quantities : dict of str to Quantity
    metadata : dict
        What JSON can hold; units and columns are added under ``quantities``.
    path : str or os.PathLike
        As for `save_result`.
    """
    path = check_result_path(path)
    about = {name: {"unit": one.unit, "columns": list(one.columns)} for name, one in quantities.items()}
    arrays = {name: one.values for name, one in quantities.items()}
    part = path.with_name(f".{path.name}.part{path.suffix}")
    try:
        _write(part, arrays, {**metadata, "quantities": about})
        os.replace(part, path)
    except OSError as error:
        raise UkrtError(f"{path} cannot be written: {error.strerror or error}") from None
    finally:
        part.unlink(missing_ok=True)


def load_result(path):
    """Read a result that `save_result` wrote.

    Parameters
    ----------
    path : str or os.PathLike

    Returns
    -------
    Result

    Raises
    ------
    UkrtError
        A file that cannot be read, or that is no result.
    """
    path = pathlib.Path(path)
    if path.suffix.lower() not in SUFFIXES:
        raise UkrtError(f"{path}: a result is a file whose name ends in {', '.join(SUFFIXES)}")
    if not path.is_file():
        raise UkrtError(f"{path}: no such file")
    try:
        arrays, metadata = _read(path)
        about = metadata["quantities"]
        quantities = {name: Quantity(arrays[name], one["unit"], tuple(one["columns"])) for name, one in about.items()}
        times, case = quantities.pop("times").values, parse_case(metadata["case"], f"{path}: its case")
        return Result(case, metadata["solver"], times, quantities, metadata["facts"])
    except (OSError, EOFError, ValueError, KeyError, TypeError, zipfile.BadZipFile, zlib.error):
        raise UkrtError(f"{path} is no result that `ukrt simulate` wrote, or it is damaged") from None


def _read(path):
    """Arrays and metadata of a file."""
    if path.suffix.lower() == ".npz":
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
        return arrays, json.loads(str(arrays.pop("metadata")))
    with _h5py().File(path, "r") as file:
        return {name: data[()] for name, data in file.items()}, json.loads(file.attrs["metadata"])


def _write(path, arrays, metadata):
    if path.suffix.lower() == ".npz":
        np.savez_compressed(path, metadata=np.array(json.dumps(metadata)), **arrays)
        return
    with _h5py().File(path, "w") as file:
        file.attrs["metadata"] = json.dumps(metadata)
        for name, values in arrays.items():
            data = file.create_dataset(name, data=values, compression="gzip", shuffle=True)
            about = metadata["quantities"][name]
            data.attrs["unit"] = about["unit"]
            data.attrs["columns"] = about["columns"]


def _h5py():
    try:
        import h5py
    except ImportError:
        raise MissingExtraError("HDF5 needs h5py, which is missing: pip install 'ukrt[hdf5]'; or write .npz") from None
    return h5py
