"""Fig. 11: what gets past a number of rigid contacts, as the standard deviation of the string's motion along it."""

import numpy as np

from ..experiment.case import Point, Record
from ..experiment.result import Quantity
from ..model.parameters import Contact
from .data import FigureData, Number
from .modal_sum import deviation_by_modes
from .spectra import db
from .stopped_string import (
    CHOSEN,
    CONTINUOUS_HZ,
    LENGTH,
    OTHER,
    READINGS,
    STRING,
    WIDTH,
    at_reading,
    contact_places,
    offsets,
    stopped_case,
)

NUMBER = 11
TITLE = "Standard deviation of the string's motion: the number of rigid contacts is varied"
COUNTS = (1, 2, 3, 5)
ZOOM = (0.16, 0.20)  # m: the paper's lower panel
DURATION = 1.0  # s: 0.2 and 5 s give the same leakage within 1.4 dB
RATE_HZ = 1e4  # kept samples; a standard deviation needs no more
WIDTHS = (0.010, 0.020, 0.025)  # m: other fingers
BASIS_HZ, WIDER_HZ = 10e3, CONTINUOUS_HZ  # the paper's, and one that resolves 0.7 mm
PAPER_LEAK = "more contacts need not pass less (Sec. IV B 2)"
NO_BASIS = "modes up to 10 kHz (Sec. IV A)"
PAPER_DEPENDS = "varies in a non-obvious way with the finger's width and other factors (Sec. IV B 2)"


def make(run):
    grid = np.unique(np.concatenate([np.linspace(0.0, LENGTH, 261), np.linspace(*ZOOM, 161)]).round(7))
    curves, cases, numbers = {}, [], []
    for reading, place in READINGS.items():
        made = [_deviation(run, count, grid, place) for count in COUNTS]
        curves[reading] = np.array([values for values, _ in made]).T
        cases += [case for _, case in made]
        numbers += _leaks([leakage(grid, *one) for one in made], at_reading(reading))
        numbers += _by_modes(grid, made, run.solver, at_reading(reading))
    places = [one for case in cases[: len(COUNTS)] for one in contact_places(case)]
    numbers += [_in_zoom(cases), *_other_widths(run, grid)]
    arrays = {
        "place": Quantity(grid, "m"),
        "deviation": Quantity(curves[CHOSEN], "m", tuple(f"F = {count}" for count in COUNTS)),
        "deviation_other_reading": Quantity(curves[OTHER], "m", tuple(f"F = {count}" for count in COUNTS)),
        "contact_places": Quantity(np.unique(np.round(places, 9)), "m"),
    }
    return FigureData(arrays, tuple(numbers), cases=tuple(cases))


def draw(data, figure):
    from .style import BLACK, BLUE, GREEN, RED

    figure.set_size_inches(6.3, 6.0)
    place, curves = data.arrays["place"].values, data.arrays["deviation"].values
    upper, lower = figure.subplots(2)
    styles = zip(COUNTS, curves.T, (BLACK, BLUE, GREEN, RED), ("-", "--", "-.", "-"), strict=True)
    for count, values, colour, dashes in styles:
        for panel in (upper, lower):
            panel.semilogy(place, values, color=colour, ls=dashes, lw=1.1, label=f"$F$ = {count}")
    for panel in (upper, lower):
        for x in data.arrays["contact_places"].values:
            panel.axvline(x, color="0.3", ls=":", lw=0.7, zorder=0)
        panel.set(xlabel="$x$ [m]", ylabel="STD($Y(t)$) [m]")
    upper.set(xlim=(0.0, LENGTH), ylim=(1e-8, 1e-2))
    lower.set(xlim=ZOOM, ylim=(1e-9, 1e-3))
    upper.legend(loc="lower right", ncols=2)


def leakage(grid, deviation, case):
    """Rms motion between nut and contacts over that between contacts and bridge [dB].

    Parameters
    ----------
    grid, deviation : ndarray (n,) [m]
        Places, evenly spaced or not, and the standard deviation there.
    case : ukrt.experiment.case.Case
    """
    places = contact_places(case)
    behind = _mean_square(grid, deviation, 0.0, min(places))
    return float(0.5 * db(behind / _mean_square(grid, deviation, max(places), LENGTH)))


def _mean_square(grid, deviation, start, end):
    x = np.linspace(start, end, 2001)
    return np.mean(np.interp(x, grid, deviation) ** 2)


def _deviation(run, count, grid, place, width=WIDTH, duration=DURATION):
    """Standard deviation of Y over the grid [m], and the case."""
    contacts = [Contact(offset, rigid=True) for offset in offsets(count, width)]
    points = tuple(Point(STRING, min(float(x / LENGTH), 1.0)) for x in grid)
    record = Record(rate_hz=RATE_HZ, displacement=points, bridge_force=False)
    name = f"{count} rigid contacts over {1e3 * width:g} mm at {place:.4f} L"
    case = stopped_case(name, contacts, place, duration, record=record)
    return np.std(run(case)["displacement"], axis=0), case


def _leaks(levels, at):
    """The leakage for each number of contacts."""
    numbers = []
    for n, (count, level) in enumerate(zip(COUNTS, levels, strict=True)):
        note = "more than with fewer contacts" if n and level > min(levels[:n]) else ""
        what = f"{at}motion behind the contacts over that before, F = {count}"
        numbers.append(Number(what, level, "dB", "", None, note))
    rise = _rise(levels)
    note = "not monotonic in F" if rise > 0.0 else "monotonic in F"
    what = f"{at}largest rise of the leakage over that of fewer contacts"
    return [*numbers, Number(what, rise, "dB", PAPER_LEAK, bool(rise > 0.0), note)]


def _in_zoom(cases):
    """Which reading of x_F puts all contacts into the paper's lower panel."""
    inside = [all(ZOOM[0] <= x <= ZOOM[1] for x in contact_places(case)) for case in cases]
    metres, lengths = sum(inside[: len(COUNTS)]), sum(inside[len(COUNTS) :])
    what = "cases with all contacts between 0.16 and 0.20 m if x_F is 0.1857 m"
    agrees = bool(metres == len(COUNTS) and lengths == 0)
    return Number(what, metres, "of 4", "lower panel of Fig. 11", agrees, f"if x_F is 0.1857 L: {lengths} of 4")


def _other_widths(run, grid):
    """How many contacts are best under fingers of other widths."""
    place, numbers = READINGS[CHOSEN], []
    for width in WIDTHS:
        levels = [leakage(grid, *_deviation(run, count, grid, place, width, duration=0.5)) for count in COUNTS]
        order = ", ".join(f"F = {count}: {level:.1f} dB" for count, level in zip(COUNTS, levels, strict=True))
        best = COUNTS[int(np.argmin(levels))]
        what = f"number of contacts that pass the least, finger {1e3 * width:g} mm wide"
        agrees = bool(best != max(COUNTS))
        numbers.append(Number(what, best, "", PAPER_DEPENDS, agrees, order))
    return numbers


def _by_modes(grid, made, solver, at):
    """The same from a sum of modes: with the paper's basis, as a check, and with a wide one, to see what stays."""
    narrow, wide = (
        [leakage(grid, deviation_by_modes(case, grid, hz), case) for _, case in made] for hz in (BASIS_HZ, WIDER_HZ)
    )
    alike, hz = (narrow, BASIS_HZ) if solver == "reference" else (wide, WIDER_HZ)  # the engine adds what a basis lacks
    off = max(abs(a - leakage(grid, *one)) for a, one in zip(alike, made, strict=True))
    what = f"{at}largest difference of these levels from a sum of coupled modes"
    note = f"basis up to {hz / 1e3:g} kHz; no time stepping"
    numbers = [Number(what, off, "dB", "(eigenvalue problem)", bool(off < 0.5), note)]
    for count, level in zip(COUNTS, wide, strict=True):
        what = f"{at}motion behind the contacts over that before, F = {count}, basis up to {WIDER_HZ / 1e3:g} kHz"
        numbers.append(Number(what, level, "dB", NO_BASIS, None, "sum of coupled modes"))
    rise = _rise(wide)
    what = f"{at}largest rise of the leakage over that of fewer contacts, basis up to {WIDER_HZ / 1e3:g} kHz"
    note = "half a wavelength at 10 kHz is 5.9 mm, five contacts stand 3.75 mm apart: the rise is the cut basis'"
    return [*numbers, Number(what, rise, "dB", PAPER_LEAK, bool(rise > 0.0), note)]


def _rise(levels):
    """Largest difference [dB] of a level from the lowest before it; negative where each is below all before."""
    return max(level - min(levels[:n]) for n, level in enumerate(levels) if n)
