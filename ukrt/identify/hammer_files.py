"""Reads records of the hammer measurement: names of a file of force and of one or two of pressure enter, calibrated
signals leave."""

import dataclasses

import numpy as np

from ..errors import MeasurementError
from .files import AUDIO, read_audio

MOST_MICROPHONES = 2  # left and right


@dataclasses.dataclass(frozen=True)
class HammerRecord:
    """Force and pressure at the same time.

    Attributes
    ----------
    force : ndarray (n,) [N]
    pressure : ndarray (n, k) [Pa]
    sample_rate : int [Hz]
    name : str
        For messages.
    """

    force: np.ndarray
    pressure: np.ndarray
    sample_rate: int
    name: str

    def check_like(self, other):
        """Refuse another sample rate or number of microphones than ``other`` has."""
        for what, own, wanted in (
            ("a sample rate in Hz", self.sample_rate, other.sample_rate),
            ("a number of microphones", self.pressure.shape[1], other.pressure.shape[1]),
        ):
            if own != wanted:
                raise MeasurementError(
                    f"{self.name} has {what} of {own}, but {other.name} of {wanted}: must be the same"
                )


def read_hammer_record(names, newtons=1.0, pascals=1.0):
    """Read one record.

    Parameters
    ----------
    names : sequence of str
        File of the force (one channel), then one or two files of pressure with two channels together at most.
    newtons, pascals : float
        Per unit of the files.

    Returns
    -------
    HammerRecord

    Raises
    ------
    MeasurementError
        A file cannot be read, rates or lengths differ, channels are too many.
    """
    signals = []
    for name in names:
        if not str(name).lower().endswith(AUDIO):
            raise MeasurementError(f"{name}: a record must be one of {', '.join(AUDIO)}")
        signals.append(read_audio(name))
    force, rate = signals[0]
    if force.shape[1] != 1:
        raise MeasurementError(f"{names[0]} has {force.shape[1]} channels, but the force is one")
    for name, (samples, own) in zip(names, signals, strict=True):
        if own != rate:
            raise MeasurementError(
                f"{name} has a sample rate of {own} Hz, but {names[0]} has {rate} Hz: must be the same"
            )
        if len(samples) != len(force):
            raise MeasurementError(
                f"{name} has {len(samples)} samples, but {names[0]} has {len(force)}: both must be equally long"
            )
    pressure = np.concatenate([samples for samples, _ in signals[1:]], axis=1)
    if pressure.shape[1] > MOST_MICROPHONES:
        raise MeasurementError(
            f"{names[1]}: there are {pressure.shape[1]} microphones, but 1 or 2 (left, right) are legal"
        )
    return HammerRecord(newtons * force[:, 0], pascals * pressure, rate, str(names[0]))
