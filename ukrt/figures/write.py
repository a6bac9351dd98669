"""A figure as files: `FigureData` enters; a picture, the data behind it, a table of numbers and sounds leave, all or
none."""

import csv
import os
import pathlib
import tempfile
from dataclasses import asdict, fields

import numpy as np

from .. import __version__
from ..drivers.files.audio import AudioWriter
from ..errors import UkrtError
from ..experiment.result import save_quantities
from ..model.preset_text import dump_preset
from .data import Number
from .registry import load_figure, stem
from .style import SETTINGS


def check_folder(path):
    """Where figures go (Path): a folder, or a name for one in a folder that exists."""
    path = pathlib.Path(path)
    if path.exists() and not path.is_dir():
        raise UkrtError(f"{path} is a file, figures need a folder")
    if not path.exists() and not path.absolute().parent.is_dir():
        raise UkrtError(f"{path}: there is no folder {path.absolute().parent} to make it in")
    existing = path if path.exists() else path.absolute().parent
    if not os.access(existing, os.W_OK | os.X_OK):
        raise UkrtError(f"{path} cannot be written: {existing} is not writable")
    return path


def write_figure(number, data, folder, solver):
    """Write figure_NN.png, figure_NN.npz, figure_NN.csv and the sounds; older ones are replaced once all are whole.

    Parameters
    ----------
    number : int
    data : ukrt.figures.data.FigureData
    folder : str or os.PathLike
        Is made where it is missing.
    solver : str
        By which the cases were run.

    Returns
    -------
    list of pathlib.Path

    Raises
    ------
    ukrt.errors.UkrtError
        The folder cannot be written.
    """
    folder = check_folder(folder)
    try:
        folder.mkdir(exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=f".{stem(number)}.", dir=folder) as part:
            _write_all(number, data, pathlib.Path(part), solver)
            names = sorted(path.name for path in pathlib.Path(part).iterdir())
            for name in names:
                os.replace(pathlib.Path(part, name), folder / name)
    except OSError as error:
        raise UkrtError(f"{folder} cannot be written: {error.strerror or error}") from None
    return [folder / name for name in names]


def _write_all(number, data, folder, solver):
    module = load_figure(number)
    _draw(module, data, folder / f"{stem(number)}.png")
    metadata = {
        "program": f"ukrt {__version__}",
        "figure": number,
        "title": module.TITLE,
        "solver": solver,
        "cases": [dump_preset(case) for case in data.cases],
        "numbers": [_plain(one) for one in data.numbers],
    }
    save_quantities(data.arrays, metadata, folder / f"{stem(number)}.npz")
    write_numbers(data.numbers, folder / f"{stem(number)}.csv")
    for name, (rate_hz, samples) in data.sounds.items():
        samples = np.asarray(samples, float)
        samples = samples.reshape(len(samples), -1)
        with AudioWriter(folder / f"{name}.wav", rate_hz, samples.shape[1]) as sound:
            sound.write(samples)


def _plain(number):
    """A `Number` as a dict of Python's own types: comparisons of arrays leave NumPy's."""
    agrees = None if number.agrees is None else bool(number.agrees)
    return {**asdict(number), "value": float(number.value), "agrees": agrees}


def _draw(module, data, path):
    import matplotlib
    from matplotlib.figure import Figure

    with matplotlib.rc_context(SETTINGS):
        figure = Figure()
        module.draw(data, figure)
        figure.savefig(path)


def write_numbers(numbers, path):
    """The table of numbers as CSV, UTF-8, one column for each attribute of `Number`."""
    with open(path, "w", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        table.writerow([one.name for one in fields(Number)])
        for one in map(_plain, numbers):
            agrees = {True: "yes", False: "no", None: ""}[one["agrees"]]
            table.writerow({**one, "agrees": agrees}.values())
