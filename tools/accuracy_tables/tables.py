"""Comparisons as tables to read: every note, the worst of each kind by name, engine beside the paper's scheme."""

import numpy as np
from accuracy import PARTIALS, broken_limits
from rich.table import Table


def schemes_of(results):
    """The schemes there are, in order."""
    return list(dict.fromkeys(result.scheme for result in results))


def notes_table(results):
    """Every note in one row: cents, then per cent of the decay rate."""
    table = Table("scheme", "note", *(f"{n}: cents" for n in PARTIALS), *(f"{n}: %" for n in PARTIALS))
    for result in results:
        by_partial = dict(zip(result.partials, zip(result.cents, result.decay_errors, strict=True), strict=True))
        cells = [by_partial.get(n) for n in PARTIALS]
        cents = [f"{cell[0]:.3f}" if cell else "above the basis" for cell in cells]
        losses = [f"{100 * cell[1]:.2f}" if cell else "" for cell in cells]
        table.add_row(str(result.scheme), str(result.note), *cents, *losses)
    return table


def _cells(results, scheme, n_contacts, low, high):
    """(cents, decay error, note, partial) of one scheme and number of contacts, partials low to high."""
    return [
        (result.cents[k], result.decay_errors[k], str(result.note), n)
        for result in results
        if result.scheme == scheme and result.note.n_contacts == n_contacts
        for k, n in enumerate(result.partials)
        if low <= n <= high
    ]


def worst_table(results):
    """For each scheme and number of contacts the largest errors, their notes, and the middle of all."""
    columns = ("median |cents|", "worst cents", "of", "median |decay| %", "worst decay %", "of")
    table = Table("scheme", "contacts", "partials", *columns)
    for scheme in schemes_of(results):
        for n_contacts in sorted({result.note.n_contacts for result in results}):
            for low, high in ((1, 5), (8, 8)):
                cells = _cells(results, scheme, n_contacts, low, high)
                if not cells:
                    continue
                cents, loss = max(cells, key=lambda one: abs(one[0])), max(cells, key=lambda one: abs(one[1]))
                table.add_row(
                    str(scheme),
                    str(n_contacts),
                    "1-5" if low < high else "8",
                    f"{np.median([abs(one[0]) for one in cells]):.4f}",
                    f"{cents[0]:+.4f}",
                    f"{cents[2]}, partial {cents[3]}",
                    f"{100 * np.median([abs(one[1]) for one in cells]):.4f}",
                    f"{100 * loss[1]:+.3f}",
                    f"{loss[2]}, partial {loss[3]}",
                )
    return table


def pairs_of(results):
    """(engine's result, the reference's for the same note) of every engine scheme."""
    paper = {result.note: result for result in results if result.scheme.solver == "reference"}
    engine = [result for result in results if result.scheme.solver == "engine"]
    return [(one, paper[one.note]) for one in engine if one.note in paper]


MEASURES = {  # of a result; what two schemes are compared by
    "pole (pitch and decay)": lambda result: result.distances,
    "pitch": lambda result: np.abs(result.cents),
    "decay": lambda result: np.abs(result.decay_errors),
}


def beside_table(results):
    """Share of notes and of partials for which the engine errs less than the paper's own discretisation."""
    table = Table("engine", "contacts", "error of", "notes", "partials", "median ratio", "smallest ratio")
    pairs = pairs_of(results)
    for scheme in schemes_of([one for one, _ in pairs]):
        for n_contacts in sorted({one.note.n_contacts for one, _ in pairs}):
            rows = [(e, p) for e, p in pairs if e.scheme == scheme and e.note.n_contacts == n_contacts]
            for name, size in MEASURES.items():
                ratios = [size(p) / np.maximum(size(e), 1e-12) for e, p in rows]
                every = np.concatenate(ratios)
                table.add_row(
                    f"{scheme.rate / 1e3:g} kHz",
                    str(n_contacts),
                    name,
                    f"{sum(bool(np.all(one > 1.0)) for one in ratios)} of {len(ratios)}",
                    f"{np.count_nonzero(every > 1.0)} of {len(every)}",
                    f"{np.median(every):.0f}",
                    f"{np.min(every):.2f}",
                )
    return table


def exceptions(results):
    """Partials of which the engine's pole is further off than the paper's, in words: list of str."""
    words = []
    for engine, paper in pairs_of(results):
        for k, n in enumerate(engine.partials):
            for name, size in MEASURES.items():
                if not size(engine)[k] < size(paper)[k]:
                    words.append(
                        f"{engine.scheme}, {engine.note}, partial {n}, {name}: {engine.cents[k]:+.4f} cents,"
                        f" decay {100 * engine.decay_errors[k]:+.3f} %; paper {paper.cents[k]:+.4f} cents,"
                        f" {100 * paper.decay_errors[k]:+.3f} %"
                    )
    return words


def broken(results):
    """Limits of the project that the engine breaks, in words: dict of scheme to list of str."""
    engine = [result for result in results if result.scheme.solver == "engine"]
    return {
        scheme: [words for result in engine if result.scheme == scheme for words in broken_limits(result)]
        for scheme in schemes_of(engine)
    }
