"""Fig. 6: what a conservative model does with its energy."""

from ..experiment.case import Case, ForceRamp, HeldString, Record
from ..experiment.result import Quantity
from .cases import FIFTH_FRET, paper_guitar
from .data import FigureData, Number

NUMBER = 6
TITLE = "Energies of the conservative model"


def make(run):
    case = Case(
        "conservative",
        1.0,
        paper_guitar(),
        losses=False,
        tension_modulation=False,
        held=[HeldString("E2", FIFTH_FRET)],
        plucks=[ForceRamp("E2", force_y=2.0, force_z=1.0)],
        record=Record(rate_hz=1e4, energies=True, bridge_force=False),
    )
    result = run(case)
    arrays = {"time": Quantity(result.times, "s"), "energies": result.quantities["energies"]}
    return FigureData(arrays, (Number("x", 1.0, "J", "y", True),), cases=(case,))


def draw(data, figure):
    panel = figure.subplots()
    panel.plot(data.arrays["time"].values, data.arrays["energies"].values)
