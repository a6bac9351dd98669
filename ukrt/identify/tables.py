"""Responses in tables: a CSV or MAT file enters, its first column and its responses leave, over time or frequency.

CSV: lines that begin with # are skipped, the first other line names the columns, separated by comma, semicolon, tab or
blanks. A first name that begins with ``t`` (time, t [s]) means seconds, and each further column is an impulse response;
one that begins with ``f`` (frequency, f/Hz) means hertz, and further columns are real and imaginary part in turn. A
column called ``bass-treble`` (in pairs ``bass-treble re``, ``bass-treble im``) says which path it is.

MAT: a vector ``t`` or ``time`` [s], or a number ``fs`` or ``rate`` [Hz], and ``h`` (one column each response); or a
vector ``f`` or ``frequency`` [Hz] and complex ``H``.
"""

import dataclasses
import re

import numpy as np

from ..errors import MeasurementError, MissingExtraError
from .measurement import PATHS

TIMES, RATES, FREQUENCIES = ("t", "time"), ("fs", "rate"), ("f", "freq", "frequency")
RESPONSES = ("h", "H", "ir", "frf")


@dataclasses.dataclass(frozen=True)
class Table:
    """Columns of a file.

    Attributes
    ----------
    over_time : bool
        Else over frequency.
    steps : ndarray (n,) [s or Hz]
    values : ndarray (n, k), complex over frequency
    names : tuple of str, optional
        Paths that the columns are named after.
    """

    over_time: bool
    steps: np.ndarray
    values: np.ndarray
    names: tuple | None


def read_csv(name):
    """Read a text file: `Table`."""
    try:
        with open(name, encoding="utf-8-sig") as file:
            lines = [line for line in file if line.strip() and not line.lstrip().startswith("#")]
    except (OSError, UnicodeDecodeError) as error:
        raise MeasurementError(f"{name} cannot be read as text: {getattr(error, 'strerror', None) or error}") from None
    if len(lines) < 2:
        raise MeasurementError(f"{name} is empty, but a line of names and rows of numbers are needed")
    mark = next((one for one in (";", "\t", ",") if one in lines[0]), None)
    head = [word.strip().strip("\"'") for word in lines[0].strip().split(mark)]
    kind = head[0][:1].lower()
    if kind not in ("t", "f"):
        raise MeasurementError(
            f"{name}: its first line begins with {head[0]!r}, but it must name columns, the first one time or frequency"
        )
    try:
        numbers = np.loadtxt(lines[1:], delimiter=mark, ndmin=2, comments=None)
    except ValueError as error:
        raise MeasurementError(f"{name} is not a table of numbers below its first line: {_reason(error)}") from None
    if numbers.shape[1] != len(head) or len(head) < 2:
        raise MeasurementError(
            f"{name} has {numbers.shape[1]} columns of numbers and {len(head)} names, but must have as many, at least 2"
        )
    if kind == "t":
        return Table(True, numbers[:, 0], numbers[:, 1:], _path_names(head[1:]))
    if len(head) % 2 == 0:
        raise MeasurementError(
            f"{name} has {len(head) - 1} columns beside the frequency, but real and imaginary parts come in pairs"
        )
    return Table(False, numbers[:, 0], numbers[:, 1::2] + 1j * numbers[:, 2::2], _path_names(head[1::2]))


def read_mat(name):
    """Read a MATLAB file up to version 7: `Table`."""
    try:
        import scipy.io
    except ImportError as error:
        raise MissingExtraError(
            f"{name}: MAT files need scipy, which is missing: pip install 'ukrt[measure]'"
        ) from error
    try:
        found = scipy.io.loadmat(name)
    except NotImplementedError:
        raise MeasurementError(f"{name} is a MAT file of version 7.3, but up to 7 is read: save it with -v7") from None
    except Exception as error:  # scipy raises whatever its parser meets: ValueError, TypeError, zlib.error, ...
        raise MeasurementError(f"{name} is not a MAT file that can be read: {_reason(error)}") from None
    found = {key: value for key, value in found.items() if isinstance(value, np.ndarray) and value.dtype.kind in "fiuc"}
    key = next((one for one in RESPONSES if one in found), None)
    if key is None:
        raise MeasurementError(
            f"{name} has the variables {', '.join(found) or 'none'}, but none of {', '.join(RESPONSES)}"
        )
    values = found[key].astype(complex if np.iscomplexobj(found[key]) else float)
    if values.ndim != 2:
        raise MeasurementError(
            f"{name}: {key} has {values.ndim} dimensions, but must have one column for each response"
        )
    values = values.T if values.shape[0] < values.shape[1] else values
    return Table(*_mat_steps(found, len(values), name), values, None)


def _mat_steps(found, count, name):
    """Whether a MAT file is over time, and its steps (count,)."""
    for names, over_time in ((TIMES, True), (FREQUENCIES, False)):
        for key in names:
            if key in found:
                steps = found[key].astype(float).ravel()
                if len(steps) != count:
                    raise MeasurementError(f"{name}: {key} has {len(steps)} values, but the responses have {count}")
                return over_time, steps
    for key in RATES:
        if key in found and found[key].size == 1 and found[key].item() > 0:
            return True, np.arange(count) / float(found[key].item())
    raise MeasurementError(
        f"{name} has the variables {', '.join(found)}, but no {', '.join((*TIMES, *RATES))} (impulse response), no "
        f"{', '.join(FREQUENCIES)} (admittance)"
    )


def _path_names(columns):
    """Paths that columns are named after (tuple of str), or None unless all are."""
    found = [re.match("|".join(PATHS), column.strip().lower()) for column in columns]
    return tuple(one[0] for one in found) if all(found) else None


def _reason(error):
    return " ".join(str(error).split()).rstrip(".")
