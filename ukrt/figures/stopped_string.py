"""The string of Figs. 9 to 12: E2 on a rigid bridge, held by a finger at x_F, plucked as in Fig. 5; a finger's contacts
enter, a case leaves.

The paper's text says x_F = 0.1857 L, but the lower panel of its Fig. 11 zooms on x = 0.16 to 0.20 m to show contacts
over 15 mm, and 0.1857 L is 0.1207 m. Read in metres the number lies in the panel and, with contacts from there towards
the nut, in its middle (0.1707 to 0.1857 m); 0.1857 m is also 2 L / 7. So metres are drawn, and 0.1857 L is run beside.
"""

from dataclasses import replace

import numpy as np

from ..experiment.case import Case, ForceRamp, HeldString, Point, Record
from ..model.contacts import held_by_finger
from ..model.parameters import Contact
from .cases import paper_guitar, with_contacts
from .coupled_modes import coupled_modes

STRING = "E2"
LENGTH = 0.65  # m
READINGS = {"0.1857 m": 0.1857 / LENGTH, "0.1857 L": 0.1857}
CHOSEN, OTHER = READINGS
MASS = 5e-3  # kg: the paper's m_F
WIDTH = 0.015  # m: the paper's finger width
PLUCK = 5.0  # N: of Fig. 5; with it Fig. 10's Y(t) fills the paper's axis of -2 to 4 mm at the plucked point
CONTINUOUS_HZ = 80e3  # a basis that resolves 0.7 mm
RATE_HZ = 50e3  # kept samples, five times the basis


def at_reading(reading):
    """What a number of the other reading of x_F is marked with (str); those of the chosen one stand as they are."""
    return "" if reading == CHOSEN else f"x_F = {reading}: "


def oscillator(stiffness, damping, offset=0.0):
    """One flexible contact of the paper's mass (Contact); stiffness [N/m], damping [N s/m], offset [m]."""
    return Contact(offset, MASS, damping, stiffness)


def offsets(count, width=WIDTH):
    """Offsets of ``count`` contacts over ``width`` [m], the first at the finger's place, the others towards the nut."""
    return tuple(-width * k / max(count - 1, 1) for k in range(count))


def stopped_case(name, contacts, place=READINGS[CHOSEN], duration=5.0, **changes):
    """E2 alone on a rigid bridge, linear, held by ``contacts`` from the beginning, plucked at 0.9 L in Y.

    Parameters
    ----------
    name : str
    contacts : sequence of ukrt.model.parameters.Contact
    place : float [L]
        Of the first contact.
    duration : float [s]
    **changes
        Other fields of the case.

    Returns
    -------
    ukrt.experiment.case.Case
    """
    case = Case(
        name,
        duration,
        with_contacts(paper_guitar(), *contacts),
        strings=(STRING,),
        bridge="rigid",
        tension_modulation=False,
        held=(HeldString(STRING, place),),
        plucks=(ForceRamp(STRING, force_y=PLUCK),),
        record=Record(rate_hz=RATE_HZ),
    )
    return replace(case, **changes)


def recorded(places):
    """A `Record` of Y at ``places`` [L] and of the bridge force."""
    return Record(rate_hz=RATE_HZ, displacement=tuple(Point(STRING, place) for place in places))


def contact_places(case):
    """Where the contacts stand: tuple of float [m]."""
    return tuple(p.place for p in held_by_finger(case.guitar.finger, case.held[0].place * LENGTH))


def modes_for(run, case):
    """Coupled modes of what a solver computes: of the basis as it is or, for the engine, which adds what a basis leaves
    out, of one so wide that little is missing."""
    return coupled_modes(case, None if run.solver == "reference" else CONTINUOUS_HZ)


def partials(case, modes, count):
    """Numbers of the modes that are the first ``count`` partials of the length before the contacts (ndarray of int).

    Near each multiple of c_T / 2l, the mode of which the least moves behind.

    Parameters
    ----------
    case : ukrt.experiment.case.Case
    modes : ukrt.figures.coupled_modes.CoupledModes
    count : int
    """
    start = max(contact_places(case))
    ideal = case.instrument.strings[0].wave_speed / (2.0 * (LENGTH - start)) * np.arange(1, count + 1)
    near = np.abs(modes.frequencies / ideal[:, None] - 1.0) < 0.03
    return np.argmin(np.where(near, modes.share_between(0.0, start), np.inf), axis=1)
