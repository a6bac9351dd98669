"""Small experiments for the tests of the solvers: the paper's guitar with few strings, and fingers of every kind."""

from dataclasses import replace

from ukrt.experiment.case import Case, ForceRamp, HeldString, Point, Record
from ukrt.model.parameters import Basis, Contact, Finger
from ukrt.model.presets import load_preset

FINGERS = {
    "oscillator": (Contact(0.0, 5e-3, 1.0, 1e6),),
    "rigid": (Contact(0.0, rigid=True), Contact(-0.01, rigid=True)),
    "three": (Contact(0.0, 5e-3, 1.0, 1e6), Contact(-0.004, 5e-3, 10.0, 1e4), Contact(-0.008, 5e-3, 10.0, 1e4)),
    "soft": (Contact(0.0, 0.0, 2.0, 0.0),),
    "damper": (Contact(0.0, 5e-3, 1.0, 1e6), Contact(-0.006, 0.0, 2.0, 0.0)),
}
EVERYTHING = Record(
    displacement=(Point("E2", 0.6), Point("E2", 1.0), Point("E2", 0.6, "Z")),
    energies=True,
    tension=True,
    amplitudes=True,
)


def guitar(finger="oscillator", bandwidth_hz=10000.0):
    """The paper's guitar with one of `FINGERS` and another basis."""
    paper = load_preset("paper")
    return replace(paper, finger=Finger(FINGERS[finger]), basis=Basis(bandwidth_hz))


def case(finger="oscillator", bandwidth_hz=10000.0, **changes):
    """E2 and A2, E2 stopped at its fifth fret and plucked obliquely, all recorded; ``changes`` replace fields."""
    fields = {
        "name": "test",
        "duration": 0.02,
        "guitar": guitar(finger, bandwidth_hz),
        "strings": ("E2", "A2"),
        "held": (HeldString("E2", 0.2509),),
        "plucks": (ForceRamp("E2", 0.9, 0.002, 0.01, 3.0, 2.0),),
        "record": EVERYTHING,
    }
    return Case(**(fields | changes))


def fig_6(**changes):
    """The paper's Fig. 6: six strings, nothing lost, linear; E2 held at 0.2509 L, 2 N in Y and 1 N in Z."""
    fields = {
        "name": "Fig. 6",
        "duration": 1.0,
        "guitar": load_preset("paper"),
        "losses": False,
        "tension_modulation": False,
        "held": (HeldString("E2", 0.2509),),
        "plucks": (ForceRamp("E2", 0.9, 0.0, 0.010, 2.0, 1.0),),
        "record": Record(bridge_force=False, energies=True),
    }
    return Case(**(fields | changes))
