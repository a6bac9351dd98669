"""Fig. 3: mode shapes of the body at the six bridge points; as they are estimates, also what others would change."""

from dataclasses import replace

import numpy as np

from ..experiment.result import Quantity
from ..model.body import bridge_shapes
from .cases import paper_guitar
from .data import FigureData, Number
from .figure_05 import bridge_case, bridge_spectrum, coupling, partial_peaks
from .figure_06 import oblique_case
from .figure_07 import numbers as energy_numbers

NUMBER = 3
TITLE = "Mode shapes of the body at the bridge (estimates)"
_LETTERS = ("E", "A", "D", "G", "B", "E")


def choices():
    """Guitars with other mode shapes, by what was chosen: dict of str to ukrt.model.parameters.Guitar.

    The first is the preset. The others are plausible as well: no tilt at all (an earlier paper of the same authors,
    JASA 141, 2139 (2017), has one shape value 1 for each mode), and the preset's with bass and treble exchanged, which
    has the same number of tilted modes.
    """
    guitar = paper_guitar()
    body, ones = guitar.body, (1.0,) * len(guitar.body.frequencies_hz)
    exchanged = replace(body, shapes_bass=body.shapes_treble, shapes_treble=body.shapes_bass)
    return {
        "preset": guitar,
        "all ones": replace(guitar, body=replace(body, shapes_bass=ones, shapes_treble=ones)),
        "bass and treble exchanged": replace(guitar, body=exchanged),
    }


def make(run):
    """The shapes, and the comparable numbers of Figs. 5 and 7 with each choice of them."""
    guitars, cases, compared = choices(), [], {}
    for name, guitar in guitars.items():
        three = (
            bridge_case(f"one string, {name}", ("E2",), guitar=guitar),
            bridge_case(f"six strings, {name}", guitar=guitar),
            oblique_case(f"energies, {name}", True, guitar),
        )
        cases.extend(three)
        compared[name] = list(_compared(three, [run(case) for case in three]))
    shapes = [bridge_shapes(guitar) for guitar in guitars.values()]
    largest = np.max(np.abs(shapes[0]), axis=0)
    off = float(np.max(np.abs(largest - 1.0)))
    numbers = [Number("shapes: largest over the six points, farthest from 1", off, "", "1 for each mode", off < 1e-9)]
    preset = compared.pop("preset")
    for name, rows in compared.items():
        for ours, other in zip(preset, rows, strict=True):
            note = f"with the preset's shapes {ours.value:.4g} {ours.unit}"
            numbers.append(replace(other, what=f"{name}: {other.what}", note=note))
    arrays = {
        "frequency": Quantity(np.array(guitars["preset"].body.frequencies_hz), "Hz"),
        "shapes": Quantity(shapes[0], "1"),
        "shapes_all_ones": Quantity(shapes[1], "1"),
        "shapes_exchanged": Quantity(shapes[2], "1"),
    }
    return FigureData(arrays, tuple(numbers), cases=tuple(cases))


def _compared(cases, results):
    """The numbers of Figs. 5 and 7 for one choice of shapes (iterator of Number)."""
    one, six = (bridge_spectrum(result) for result in results[:2])
    first = float(partial_peaks(*one)[0])
    yield Number("Fig. 5, first partial", first, "Hz", "82", round(first) == 82)
    for number in list(coupling(cases[1], one, six))[1:]:
        yield replace(number, what=f"Fig. 5, {number.what.removeprefix('six strings: ')}")
    for number in energy_numbers(results[2]):
        if number.what.startswith("strings") or "largest" in number.what:
            yield replace(number, what=f"Fig. 7, {number.what}")


def draw(data, figure):
    """One panel for each mode."""
    from .style import BLUE

    figure.set_size_inches(6.6, 7.6)
    panels = figure.subplots(5, 2, sharex=True, sharey=True)
    shapes, places = data.arrays["shapes"].values, np.arange(len(_LETTERS))
    for n, (panel, hz) in enumerate(zip(panels.T.flat, data.arrays["frequency"].values, strict=True)):
        panel.axhline(0.0, color="black", lw=0.6)
        panel.plot(places, shapes[:, n], "o-", color=BLUE, ms=3.5, lw=1.2)
        panel.set(title=f"f$_{{{n + 1}}}$ = {hz:.1f} Hz", ylim=(-1.25, 1.25), yticks=(-1, 0, 1))
        panel.set_xticks(places, _LETTERS)
    for n, panel in enumerate(panels[:, 0]):
        panel.set_ylabel(f"$\\phi_{{{n + 1}}}$(x$_B$)")
    for n, panel in enumerate(panels[:, 1]):
        panel.set_ylabel(f"$\\phi_{{{n + 6}}}$(x$_B$)")
    figure.suptitle("Estimates (real): the text gives no values", fontsize=8.5, color="0.3")
