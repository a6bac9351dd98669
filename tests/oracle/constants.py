"""Plain numbers of the paper's guitar and bare records for them: in nothing, out strings, body and contacts (Table I).

The field names are those of the instrument's own parameters, so that either kind of record can be given to the oracle;
nothing else is shared with the model.
"""

import types
from dataclasses import dataclass


@dataclass(frozen=True)
class StringData:
    """One string, SI."""

    name: str
    length: float
    tension: float
    linear_density: float
    bending_stiffness: float
    loss_internal: float
    loss_air: float
    loss_bending: float
    bridge_position: float


@dataclass(frozen=True)
class BodyData:
    """Body modes at the bridge: frequencies [Hz], damping ratios, masses [kg], shapes at the two ends of the bridge."""

    frequencies_hz: tuple
    damping_ratios: tuple
    modal_masses: tuple
    shapes_bass: tuple
    shapes_treble: tuple


@dataclass(frozen=True)
class ContactData:
    """A contact at `place` [m from the nut]: rigid, oscillator (m, c, k), or pure damper (mass = stiffness = 0)."""

    place: float
    mass: float = 0.0
    damping: float = 0.0
    stiffness: float = 0.0
    rigid: bool = False


# Woodhouse 2004, Acta Acustica 90, Table I; scale length of Debut & Antunes 2020.
_ROWS = (
    ("E2", 71.6, 6.24, 57, 2, 1.2, 2.0),
    ("A2", 73.9, 3.61, 40, 7, 0.9, 2.5),
    ("D3", 71.2, 1.95, 51, 5, 1.2, 2.0),
    ("G3", 58.3, 0.90, 310, 14, 1.7, 2.0),
    ("B3", 53.4, 0.52, 160, 40, 1.2, 2.0),
    ("E4", 70.3, 0.38, 130, 40, 1.5, 2.4),
)
STRINGS = tuple(
    StringData(name, 0.65, tension, density * 1e-3, bending * 1e-6, eta_f * 1e-5, eta_a, eta_b * 1e-2, s / 5.0)
    for s, (name, tension, density, bending, eta_f, eta_a, eta_b) in enumerate(_ROWS)
)


def make_body(shapes_bass=None, shapes_treble=None):
    """Table I of the paper (Friederich no. 694); without shapes every mode's shape is 1 at both ends of the bridge."""
    frequencies = (89.4, 182.6, 229.9, 310.2, 403.5, 511.4, 544.2, 613.9, 669.8, 848.4)
    damping = (1.50, 1.82, 0.64, 0.89, 0.55, 0.75, 0.53, 0.61, 0.69, 0.59)
    masses = (0.40, 0.08, 0.20, 0.47, 1.06, 0.58, 1.82, 0.69, 0.38, 0.81)
    ones = (1.0,) * len(frequencies)
    return BodyData(frequencies, tuple(z / 100.0 for z in damping), masses, tuple(shapes_bass or ones),
                    tuple(shapes_treble or ones))


BODY = make_body()


def make_guitar(strings=STRINGS, body=BODY):
    """A bare record with `strings` and `body`, all the oracle asks of a guitar."""
    return types.SimpleNamespace(strings=tuple(strings), body=body)
