"""Fig. 6: without losses the total energy stays, and flows between strings, fret and body."""

import numpy as np

from ..experiment.case import Case, ForceRamp, HeldString, Record
from ..experiment.result import Quantity
from .cases import FIFTH_FRET, paper_guitar
from .data import FigureData, Number
from .plucked import ramp_work, static_work

NUMBER = 6
TITLE = "Energies of the conservative model"
FORCE_Y, FORCE_Z = 2.0, 1.0  # N
PARTS = ("STRINGS", "FRET", "BODY", "TOTAL")


def oblique_case(name, losses, guitar=None, duration=1.0):
    """E2 stopped at the fifth fret and plucked obliquely, six linear strings: the case of Figs. 6 and 7."""
    return Case(
        name,
        duration,
        guitar or paper_guitar(),
        losses=losses,
        tension_modulation=False,
        held=[HeldString("E2", FIFTH_FRET)],
        plucks=[ForceRamp("E2", force_y=FORCE_Y, force_z=FORCE_Z)],
        record=Record(rate_hz=1e4, energies=True, bridge_force=False),
    )


def parts_of(result):
    """Energies of strings, fret, body and all [J]: ndarray (n_times, 4), as `PARTS`."""
    energy = {label: result.column("energies", label) for label in result.quantities["energies"].columns}
    strings = energy["strings Y"] + energy["strings Z"]
    return np.stack([strings, energy["fingers Y"] + energy["fingers Z"], energy["body"], energy["total"]], axis=1)


def after_release(result):
    """Samples after the pluck (ndarray of bool)."""
    return result.times > result.case.plucks[0].duration + 1e-9


def make(run):
    """One second after the pluck."""
    case = oblique_case("conservative", losses=False)
    result = run(case)
    parts = parts_of(result)
    arrays = {"time": Quantity(result.times, "s"), "energies": Quantity(parts, "J", PARTS)}
    return FigureData(arrays, (*_numbers(result, parts), *_drift(result)), cases=(case,))


def _numbers(result, parts):
    free = after_release(result)
    times, total = result.times[free], parts[free, 3]
    mean = float(np.mean(total))
    paper = "about 2 (read from the axis)"
    note = "what the pluck has brought in when it lets go"
    yield Number("total energy", 1e3 * mean, "mJ", paper, round(1e3 * mean) == 2, note)
    slow, quick = _closed_forms(result.case)
    yield Number("- closed form: flexible string, bent slowly", 1e3 * slow, "mJ", "", None, "F^2 a b / (2 T0 (a + b))")
    note = "a ramp of 1.1 periods of the note: the string is not in equilibrium when it is let go"
    yield Number("- closed form: the same, ramp of 10 ms", 1e3 * quick, "mJ", "", None, note)
    trend = float(np.polyfit(times, total, 1)[0] * (times[-1] - times[0]) / mean)
    yield Number("total energy: trend over the run", trend, "of the mean", "roughly constant", abs(trend) < 1e-3)
    ripple = float(np.ptp(total) / mean)
    verlet = "Verlet keeps a neighbour of the energy, which differs from it by (omega dt)^2"
    note = verlet if result.solver == "reference" else ""
    yield Number("total energy: largest minus smallest", ripple, "of the mean", "roughly constant", ripple < 0.01, note)
    for k, name in enumerate(PARTS[:3]):
        low, high = 1e3 * float(np.min(parts[free, k])), 1e3 * float(np.max(parts[free, k]))
        flows = high - low > 10.0 * 1e3 * mean * ripple
        what, note = f"{name.lower()}: energy that comes and goes", f"between {low:.3g} and {high:.3g} mJ"
        yield Number(what, high - low, "mJ", "flows back and forth", flows, note)


def _closed_forms(case):
    """Energy brought in by a slow force and by the ramp, on a flexible string between rigid fret and bridge [J]."""
    string, pluck = case.instrument.strings[0], case.plucks[0]
    span, place = (FIFTH_FRET * string.length, string.length), pluck.place * string.length
    force = float(np.hypot(FORCE_Y, FORCE_Z))
    return static_work(string, span, place, force), ramp_work(string, span, place, force, pluck.duration)


def _drift(result):
    """How well constraints hold: the reference satisfies them in acceleration, the engine in place."""
    if "drift" in result.quantities:
        drift = float(np.max(result["drift"]))
        yield Number("constraint drift, largest", drift, "m", "below 2.0e-13", drift < 2.0e-13)


def draw(data, figure):
    """One panel, as in the paper."""
    from .style import BLACK, BLUE, GREEN, RED

    figure.set_size_inches(6.6, 3.6)
    panel = figure.subplots()
    times, energies = data.arrays["time"].values, data.arrays["energies"].values
    for column, (name, color) in enumerate(zip(PARTS, (BLUE, GREEN, RED, BLACK), strict=True)):
        panel.plot(times, 1e3 * energies[:, column], color=color, label=name, lw=1.2 if name == "TOTAL" else 0.6)
    panel.set(xlabel="Time  [s]", ylabel="Modal energy  [10$^{-3}$ J]", xlim=(0, times[-1]), ylim=(0, 2))
    for line in panel.legend(ncols=4, loc="upper center", bbox_to_anchor=(0.5, 0.71)).get_lines():
        line.set_linewidth(1.5)
