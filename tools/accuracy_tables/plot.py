"""Errors of pitch and decay over the frets as a picture: comparisons enter, a PNG leaves."""

import numpy as np
from accuracy import limits

from .tables import schemes_of

COLORS = {"reference": "tab:red", 44100.0: "tab:cyan", 48000.0: "tab:blue", 96000.0: "tab:green"}
FLOOR = 1e-6  # cents and per cent: less is drawn there


def _worst(results, scheme, n_contacts, errors):
    """Frets, and the worst and the median of all strings and partials 1-5 at each; open strings at 0."""
    frets = sorted({result.note.fret for result in results if result.note.n_contacts in (0, n_contacts)})
    worst, middle = [], []
    for fret in frets:
        values = [
            np.abs(errors(result)[[k for k, n in enumerate(result.partials) if n <= 5]])
            for result in results
            if result.scheme == scheme and result.note.fret == fret and result.note.n_contacts in (0, n_contacts)
        ]
        values = np.concatenate(values)
        worst.append(max(FLOOR, values.max()))
        middle.append(max(FLOOR, np.median(values)))
    return frets, worst, middle


def draw(path, results):
    """One column for each number of contacts, pitch above, decay below; open strings stand at fret 0 in each."""
    from matplotlib.figure import Figure

    contacts = sorted({result.note.n_contacts for result in results} - {0}) or [0]
    figure = Figure(figsize=(4.3 * len(contacts) + 1.0, 7.5), layout="constrained")
    panels = figure.subplots(2, len(contacts), sharex=True, sharey="row", squeeze=False)
    rows = (
        ("pitch error / cents", lambda result: result.cents, 0, 1.0),
        ("error of decay rate / %", lambda result: 100.0 * result.decay_errors, 1, 100.0),
    )
    for column, n_contacts in enumerate(contacts):
        for row, (label, errors, which, scale) in enumerate(rows):
            panel = panels[row, column]
            for scheme in schemes_of(results):
                color = COLORS.get(scheme.rate if scheme.solver == "engine" else "reference")
                frets, worst, middle = _worst(results, scheme, n_contacts, errors)
                panel.plot(frets, worst, "o-", ms=3.5, lw=1.3, color=color, label=f"{scheme}: worst")
                panel.plot(frets, middle, ":", lw=1.0, color=color, label=f"{scheme}: median")
            bound = limits(n_contacts, 1)
            if bound:
                panel.axhline(scale * bound[which], color="black", ls="--", lw=1.0, label="limit at 48 kHz")
            panel.set(yscale="log")
            panel.grid(alpha=0.3, which="major")
            if column == 0:
                panel.set_ylabel(label)
            if row == 0:
                panel.set_title(f"{n_contacts} contact{'s' if n_contacts != 1 else ''}")
            else:
                panel.set_xlabel("fret (0: open strings)")
                panel.set_xticks(range(0, 20, 3))
    figure.suptitle("Poles of all six strings, partials 1-5:\nerrors against continuous time with modes to 400 kHz")
    handles, names = panels[0, 0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower center", ncols=len(contacts) + 1, fontsize="small")
    figure.savefig(path, dpi=110)
