"""Body modes from measurements of the bridge, and the axial stiffness of strings: see `README.md` beside this file."""

from .axial_stiffness import Stiffness, axial_stiffness
from .identification import Identification, identify
from .measurement import Measurement, Record, make_measurement
from .preset import preset_of

__all__ = [
    "Identification",
    "Measurement",
    "Record",
    "Stiffness",
    "axial_stiffness",
    "identify",
    "make_measurement",
    "preset_of",
]
