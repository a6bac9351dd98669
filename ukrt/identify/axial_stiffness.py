"""The axial stiffness ES of a string: the frequency of a mass that hangs on it and bounces enters, ES leaves.

The mass on its spring ES / L oscillates with f = (1/2 pi) sqrt(ES / (L M)) (Debut & Antunes 2020, who measured ES so).
"""

import math
from typing import NamedTuple

from ..errors import ParameterError

RAYLEIGH = 1.0 / 3.0  # of the string's own mass moves with the load (Rayleigh, The Theory of Sound, par. 156)


class Stiffness(NamedTuple):
    """ES and its standard uncertainty, both in N; the uncertainty is 0 where none was given."""

    newtons: float
    uncertainty: float


def axial_stiffness(
    frequency_hz, length, mass, *, string_mass=0.0, frequency_error=0.0, length_error=0.0, mass_error=0.0,
    string_mass_error=0.0,
):  # fmt: skip
    """ES = (2 pi f)^2 L (M + m / 3).

    Parameters
    ----------
    frequency_hz : float [Hz]
        Of the vertical oscillation.
    length : float [m]
        Of the string under the load.
    mass : float [kg]
        What hangs on it.
    string_mass : float [kg]
        The string's own, a third of which counts (Rayleigh: the string stretches evenly). 0 leaves it out, as the paper
        does. Against the exact x tan x = m / M of a bar with a load the result is then low by less than
        (m / M)^2 / 45: 2e-6 for 5 g under 500 g.
    frequency_error, length_error, mass_error, string_mass_error : float
        Standard uncertainties, each in the unit of its quantity, taken as independent.

    Returns
    -------
    Stiffness

    Raises
    ------
    ParameterError
        A value is not finite, or not above 0 (the string's mass and the uncertainties: below 0).
    """
    values = {"frequency_hz": frequency_hz, "length": length, "mass": mass}
    others = {
        "string_mass": string_mass,
        "frequency_error": frequency_error,
        "length_error": length_error,
        "mass_error": mass_error,
        "string_mass_error": string_mass_error,
    }
    for key, value in (values | others).items():
        if not (math.isfinite(value) and (value > 0.0 if key in values else value >= 0.0)):
            raise ParameterError(key, value, f"it must be {'above 0' if key in values else '0 or more'} and finite")
    moving = mass + RAYLEIGH * string_mass
    newtons = (2.0 * math.pi * frequency_hz) ** 2 * length * moving
    relative = math.hypot(
        2.0 * frequency_error / frequency_hz,
        length_error / length,
        mass_error / moving,
        RAYLEIGH * string_mass_error / moving,
    )
    return Stiffness(newtons, newtons * relative)
