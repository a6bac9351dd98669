"""Errors over basis and step: comparisons of a few notes enter; tables with measured orders, and a picture, leave."""

import numpy as np
from accuracy import PAPER_STEP
from rich.table import Table

BASIS = 10e3  # Hz: held while the step changes
COLORS = ("tab:blue", "tab:red", "tab:orange", "tab:green")
FLOOR = 1e-6  # cents: what is less is drawn there


def lowest(result, values):
    """Those of partials 1 to 5."""
    return values[[k for k, n in enumerate(result.partials) if n <= 5]]


def worst(result, values):
    """The largest of partials 1 to 5."""
    return float(np.max(np.abs(lowest(result, values))))


def order(now, before, ratio):
    """p where the error goes like the p-th power of what changed by ``ratio``; empty for the first."""
    return "" if before is None else f"{np.log(now / before) / np.log(ratio):+.2f}"


def verlet_cents(result):
    """What velocity-Verlet makes of the basis' poles, in cents: 2 / dt asin(omega dt / 2), about (omega dt)^2 / 24."""
    half = np.pi * result.frequencies_hz * 2.0 ** (result.theory.cut[0] / 1200.0) * result.scheme.step
    return 1200.0 * np.log2(np.arcsin(half) / half)


def _runs(results, keep, key):
    """(note, its results for which ``keep`` holds, sorted by ``key``)."""
    for note in dict.fromkeys(result.note for result in results):
        rows = [result for result in results if result.note == note and keep(result.scheme)]
        yield note, sorted(rows, key=lambda result: key(result.scheme))


def reference_bases(results):
    return _runs(results, lambda s: s.solver == "reference" and s.step == PAPER_STEP, lambda s: s.basis_hz)


def reference_steps(results):
    return _runs(results, lambda s: s.solver == "reference" and s.basis_hz == BASIS, lambda s: -s.step)


def engine_bases(results, rate):
    return _runs(results, lambda s: s.solver == "engine" and s.rate == rate, lambda s: s.basis_hz)


def engine_rates(results):
    return _runs(results, lambda s: s.solver == "engine" and s.basis_hz == BASIS, lambda s: s.rate)


def basis_table(results):
    """What the basis leaves out: the oracle cut there in continuous time, and the reference's whole error beside it."""
    table = Table("note", "basis / kHz", "cut alone: partial 1", "5", "worst pole", "order", "reference, 10 us: worst")
    table.title = "Truncation, cents (partials 1-5; pole: distance in the complex plane over frequency)"
    for note, rows in reference_bases(results):
        before = None
        for result in rows:
            theory, basis = result.theory, result.scheme.basis_hz
            cents, size = lowest(result, theory.cut[0]), worst(result, result.distance(*theory.cut))
            grade = "" if before is None else order(size, before[0], basis / before[1])
            cells = [f"{basis / 1e3:g}", f"{cents[0]:+.3f}", f"{cents[-1]:+.3f}", f"{size:.3f}", grade]
            table.add_row(str(note), *cells, f"{worst(result, result.distance(*theory.followed)):.3f}")
            before = size, basis
        table.add_section()
    return table


def step_table(results):
    """What the reference's step does: measured poles against the oracle with the same basis, and the closed form."""
    columns = ("closed form: 1", "5", "worst pole", "order", "worst decay %", "order", "against all modes")
    table = Table("note", "step / us", "partial 1", "5", *columns)
    table.title = "Velocity-Verlet with a basis of 10 kHz, cents, against the oracle with the same basis"
    for note, rows in reference_steps(results):
        before = None
        for result in rows:
            theory, step = result.theory, result.scheme.step
            size, loss = worst(result, result.distance(*theory.step)), worst(result, theory.step[1])
            grades = ("", "")
            if before is not None:
                grades = (order(size, before[0], step / before[2]), order(loss, before[1], step / before[2]))
            ends = [lowest(result, cents)[k] for cents in (theory.step[0], verlet_cents(result)) for k in (0, -1)]
            cells = [f"{step * 1e6:g}", *(f"{cents:+.4f}" for cents in ends), f"{size:.4f}", grades[0]]
            whole = worst(result, result.distance(*theory.followed))
            table.add_row(str(note), *cells, f"{100 * loss:.4f}", grades[1], f"{whole:.3f}")
            before = size, loss, step
        table.add_section()
    return table


def engine_table(results):
    """The engine against all modes: over the rate with a basis of 10 kHz, over the basis at 48 and 96 kHz."""
    table = Table("note", "rate / kHz", "basis / kHz", "partial 1", "5", "worst pole", "order", "worst decay %")
    table.title = "Engine, cents, against the oracle with modes to 400 kHz (order: in the step, or in the basis)"
    for runs in (engine_rates(results), engine_bases(results, 48e3), engine_bases(results, 96e3)):
        for note, rows in runs:
            before = None
            for result in rows:
                cents, size = lowest(result, result.cents), worst(result, result.distances)
                scheme, grade = result.scheme, ""
                if before is not None:
                    same = before[1].basis_hz == scheme.basis_hz
                    ratio = before[1].rate / scheme.rate if same else scheme.basis_hz / before[1].basis_hz
                    grade = order(size, before[0], ratio)
                numbers = [f"{cents[0]:+.5f}", f"{cents[-1]:+.5f}", f"{size:.5f}", grade]
                loss = f"{100 * worst(result, result.decay_errors):.4f}"
                table.add_row(str(note), f"{scheme.rate / 1e3:g}", f"{scheme.basis_hz / 1e3:g}", *numbers, loss)
                before = size, scheme
            table.add_section()
    return table


def panels_of(results):
    """What each panel shows: title, ticks, and (runs, error, style, label) of its curves."""

    def whole(result):
        return result.distance(*result.theory.followed)

    bases, steps, rates = (list(runs(results)) for runs in (reference_bases, reference_steps, engine_rates))
    narrow, wide = (list(engine_bases(results, rate)) for rate in (48e3, 96e3))
    return (
        (
            "reference: basis / kHz",
            (bases, lambda r: r.distance(*r.theory.cut), "o-", "basis alone"),
            (bases, whole, "x--", "with a step of 10 us"),
        ),
        (
            "engine: basis / kHz",
            (narrow, lambda r: r.distances, "o-", "at 48 kHz"),
            (wide, lambda r: r.distances, "x--", "at 96 kHz"),
        ),
        (
            "reference: step / us",
            (steps, lambda r: r.distance(*r.theory.step), "o-", "step alone"),
            (steps, whole, "x--", "with a basis of 10 kHz"),
        ),
        ("engine: step / us", (rates, lambda r: r.distances, "o-", "with a basis of 10 kHz")),
    )


def along(scheme, title):
    """Where a scheme stands on a panel's axis."""
    if "basis" in title:
        return scheme.basis_hz / 1e3
    return 1e6 * (scheme.step if scheme.solver == "reference" else 1.0 / scheme.rate)


def draw(path, results):
    """Over the basis above, over the step below; the reference on the left, the engine on the right."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11.0, 8.0), layout="constrained")
    for panel, (title, *curves) in zip(figure.subplots(2, 2, sharey=True).flat, panels_of(results), strict=True):
        for runs, error, style, label in curves:
            for color, (_, rows) in zip(COLORS, runs, strict=False):
                size = [max(worst(row, error(row)), FLOOR) for row in rows]
                panel.plot([along(row.scheme, title) for row in rows], size, style, color=color, ms=4, lw=1.2)
            panel.plot([], [], style, color="black", ms=4, lw=1.2, label=label)
        ticks = (5, 7, 10, 14, 20) if "basis" in title else (2.5, 5, 10, 20)
        panel.set(xscale="log", yscale="log", title=title)
        panel.set_xticks(ticks, [f"{one:g}" for one in ticks])
        panel.tick_params(axis="x", which="minor", bottom=False, labelbottom=False)
        panel.grid(alpha=0.3)
        panel.legend(fontsize="small")
    figure.supylabel("worst pole of partials 1-5: distance / cents")
    notes = list(dict.fromkeys(str(result.note) for result in results))
    marks = [figure.axes[0].plot([], [], color=color, lw=2.0)[0] for color, _ in zip(COLORS, notes, strict=False)]
    figure.legend(marks, notes, loc="outside lower center", ncols=len(notes), fontsize="small")
    figure.savefig(path, dpi=110)
