"""Fig. 7: the pluck of Fig. 6 with losses."""

import numpy as np

from ..experiment.result import Quantity
from .data import FigureData, Number
from .figure_06 import after_release, oblique_case
from .spectra import db, repetition_hz

NUMBER = 7
TITLE = "Energies with losses"
LABELS = ("strings Y", "strings Z", "fingers Y", "fingers Z", "body", "total")
_EDGE = 0.02  # s over which energies are averaged: two periods of the note
_EXCHANGES_HZ = (60.0, 1000.0)  # slower are decay and beats


def make(run):
    """One second."""
    case = oblique_case("with losses", losses=True)
    result = run(case)
    energies = np.stack([result.column("energies", label) for label in LABELS], axis=1)
    arrays = {"time": Quantity(result.times, "s"), "energies": Quantity(energies, "J", LABELS)}
    return FigureData(arrays, tuple(numbers(result)), cases=(case,))


def decay_db(result, label, since, until):
    """How far an energy falls between two times, each the beginning of 20 ms to average over [dB, positive]."""
    values = result.column("energies", label)
    first, last = (np.mean(values[(result.times >= t) & (result.times < t + _EDGE)]) for t in (since, until))
    return float(0.5 * db(first / last))


def numbers(result):
    """What can be compared with the paper's Fig. 7 (iterator of Number); Fig. 3 asks for it with other shapes."""
    begin, end = result.times[after_release(result)][0], result.times[-1] - _EDGE
    for since, until in ((begin, begin + 0.25), (begin, end)):
        fall_y, fall_z = (decay_db(result, f"strings {way}", since, until) for way in "YZ")
        what, note = f"strings: Y falls in {until - since:.2g} s by", f"Z by {fall_z:.2f} dB"
        yield Number(what, fall_y, "dB", "more than Z", fall_y > fall_z, note)
    note = "from its autocorrelation; the note sounds at 110.4 Hz"
    for label, name, order in (("fingers Y", "fret, Y", -5), ("body", "body", -4)):
        largest = float(np.max(result.column("energies", label)[after_release(result)]))
        agrees = round(np.log10(largest)) == order
        yield Number(f"{name}: largest energy", largest, "J", f"of order 1e{order}", agrees)
        hz = exchange_hz(result, label)
        yield Number(f"{name}: energy pulses at", hz, "Hz", "the frequency of the note", abs(hz - 110.4) < 2.0, note)


def exchange_hz(result, label):
    """How often an energy repeats itself: one over the delay, 1 to 17 ms, at which it is most like itself [Hz]."""
    return repetition_hz(result.column("energies", label)[after_release(result)], result.rate_hz, *_EXCHANGES_HZ)


def draw(data, figure):
    """Four panels: strings, fret, body, full system."""
    from .style import BLACK, BLUE, ORANGE, RED

    figure.set_size_inches(6.6, 7.2)
    times, energies = data.arrays["time"].values, data.arrays["energies"].values
    panels = figure.subplots(4, 1, sharex=True)
    rows = (
        ("STRINGS", -3, 1.5, ((0, "Y-dir", BLUE), (1, "Z-dir", ORANGE))),
        ("FRET", -5, 1.5, ((2, "Y-dir", BLUE), (3, "Z-dir", ORANGE))),
        ("BODY", -4, 1.1, ((4, None, RED),)),
        ("FULL SYSTEM", -3, 1.85, ((5, None, BLACK),)),
    )
    for panel, (title, power, top, curves) in zip(panels, rows, strict=True):
        for column, label, color in curves:
            panel.plot(times, energies[:, column] / 10.0**power, color=color, label=label, lw=0.7)
        panel.set(title=title, ylabel=f"[10$^{{{power}}}$ J]", ylim=(0, top), xlim=(0, times[-1]))
        if len(curves) > 1:
            for line in panel.legend(loc="upper right").get_lines():
                line.set_linewidth(1.5)
    panels[-1].set_xlabel("Time  [s]")
