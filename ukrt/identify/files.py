"""Reads measurements: ``FILE`` or ``FILE@PATHS`` enters, a `Record` leaves (WAV and FLAC by soundfile, MAT by scipy).

CSV and MAT hold either impulse responses over time or admittances over frequency; the first column's name (in MAT the
variables' names) decides, and nothing is guessed from the numbers. An admittance becomes an impulse response by inverse
Fourier transform."""

import os
import pathlib

import numpy as np
import soundfile

from ..errors import MeasurementError
from .measurement import PATHS, POWERS, Record
from .tables import read_csv, read_mat

AUDIO, TEXT, MATLAB = (".wav", ".flac"), (".csv", ".txt", ".tsv"), (".mat",)
UNEVEN = 0.01  # of a step: what rounding in a text file may do to equal steps
SOFT_EDGE = 0.09  # of the band, tapered at its upper edge, lest a sharp one rings; above `LEAST_OVERSAMPLING`
FULL_SCALE = 0.9999


def split_paths(argument):
    """``FILE@bass-bass,bass-treble`` as file name and paths (tuple of str, or None where none are named).

    Raises
    ------
    MeasurementError
        What stands behind the @ is no path, and no file of the whole name exists.
    """
    name, at, words = argument.rpartition("@")
    if not at or os.path.exists(argument):
        return argument, None
    paths = tuple(word.strip() for word in words.split(","))
    for path in paths:
        if path not in PATHS:
            raise MeasurementError(
                f"{argument}: {path!r} is no path from drive to response, legal are {', '.join(PATHS)}"
            )
    return name, paths


def read_record(name, quantity="velocity"):
    """Read one file.

    Parameters
    ----------
    name : str or os.PathLike
        ``.wav``, ``.flac``, ``.csv`` (also ``.txt``, ``.tsv``) or ``.mat``.
    quantity : str
        A key of `POWERS`: how an admittance goes on below its first frequency.

    Returns
    -------
    Record

    Raises
    ------
    MeasurementError, MissingExtraError
    """
    path = pathlib.Path(name)
    suffix = path.suffix.lower()
    if suffix not in AUDIO + TEXT + MATLAB:
        raise MeasurementError(f"{name}: its suffix is {suffix!r}, but legal are {', '.join(AUDIO + TEXT + MATLAB)}")
    if suffix in AUDIO:
        samples, rate = read_audio(name)
        return Record(samples, float(rate), str(name))
    check_is_file(name)
    table = read_csv(name) if suffix in TEXT else read_mat(name)
    if not np.isfinite(table.steps).all() or not np.isfinite(table.values).all():
        raise MeasurementError(f"{name} holds values that are not finite numbers, but every one must be a number")
    step = _step(table.steps, "s" if table.over_time else "Hz", name)
    return _from_time(table, step, name) if table.over_time else _from_frequency(table, step, name, POWERS[quantity])


def read_audio(name):
    """Samples (n, k) and rate [Hz] of a WAV or FLAC file; integer formats have full scale 1 and must stay below it."""
    check_is_file(name)
    try:
        info = soundfile.info(name)
        samples, rate = soundfile.read(name, dtype="float64", always_2d=True)
    except (soundfile.SoundFileError, RuntimeError, OSError, TypeError) as error:
        reason = " ".join(str(error).split()).rstrip(".")
        raise MeasurementError(f"{name} is not an audio file that can be read: {reason}") from None
    if not len(samples):
        raise MeasurementError(f"{name} is empty, but a response is needed")
    if info.subtype.startswith("PCM") and np.sum(np.abs(samples) >= FULL_SCALE) > 1:
        raise MeasurementError(f"{name} is clipped: it reaches full scale, but a response must stay below it")
    return samples, rate


def check_is_file(name):
    """Refuse a name that is no file's."""
    if not os.path.isfile(name):
        what = "it is a folder" if os.path.isdir(name) else "there is no such file"
        raise MeasurementError(f"{name} cannot be read: {what}")


def _step(steps, unit, name):
    """The distance between equal steps."""
    if len(steps) < 2:
        raise MeasurementError(f"{name} has {len(steps)} rows, but a response has many")
    step = (steps[-1] - steps[0]) / (len(steps) - 1)
    even = steps[0] + step * np.arange(len(steps))
    if not step > 0.0 or np.abs(steps - even).max() > UNEVEN * step + 1e-9 * np.abs(steps).max():
        raise MeasurementError(f"{name}: its first column must rise in equal steps of {unit}, but it does not")
    return step


def _from_time(table, step, name):
    begin = int(round(-table.steps[0] / step))
    if begin < 0:
        raise MeasurementError(
            f"{name} begins at {table.steps[0]:g} s, but must begin at the impulse, 0 s, or before it"
        )
    if np.iscomplexobj(table.values):
        raise MeasurementError(f"{name} holds complex values over time, but an impulse response is real")
    return Record(table.values[begin:], float(f"{1.0 / step:.9g}"), str(name), table.names)


def _from_frequency(table, step, name, power):
    """Impulse responses of admittances, whose band is filled down to 0 Hz as below all resonances."""
    first = table.steps[0] / step
    if first < -UNEVEN or abs(first - round(first)) > 10 * UNEVEN:
        raise MeasurementError(
            f"{name}: its frequencies are {table.steps[0]:g} Hz in steps of {step:g} Hz, but must be its multiples"
        )
    first, values = int(round(first)), table.values
    low = np.arange(first)[:, None] / max(first, 1)
    whole = np.concatenate([values[0].real * low**power if power != 1 else 1j * values[0].imag * low, values])
    edge = max(int(SOFT_EDGE * len(whole)), 1)
    whole[-edge:] *= np.cos(0.5 * np.pi * (np.arange(edge) + 1) / edge)[:, None] ** 2
    count = 2 * (len(whole) - 1)
    return Record(np.fft.irfft(whole, count, axis=0) * count * step, count * step, str(name), table.names, True)
