"""Results as tables: what was measured, and what was left out and why."""

import statistics

from rich import box
from rich.table import Table

from .measure import median_ratio
from .ukrt_itself import NAME as OURS

FAIRNESS = """\
Times real time: CPU time (user and system, all threads) of a render of {long:g} s less that of {short:g} s, so that
starting, loading and compiling are not in it; ukrt's engine, which starts for longer than it renders, counts its own
while it renders. Medians of {runs} turns; "of ukrt's" is the median of the ratios within each turn, above 1 where
faster than ukrt's engine. All at 48 kHz in blocks of 64 frames, each writes a sound file (`ukrt render` is called in
blocks of 512, which its engine cuts into 64). What else the machine does slows all: ratios hold where figures do not.
What they compute differs. Sampled voices and waveguides sound the notes as they come; a bank of modes rings 800 fixed
filters, struck at each note, without pitch, coupling, damping or choice of strings; the paper's scheme has one
fingering throughout. ukrt computes in float64. FluidSynth, SuperCollider, Csound and libstk are as Debian builds them,
for any processor of the kind; what is compiled here is so with {flags}.
Faust's bank with -vec was 1.2 times as fast as scalar when tried once, and took g++ six minutes.
Each call of zita-convolver waits until its threads have done what falls due, all on the one core: so its longest blocks
are work that it would spread over other cores, or over time. FFTConvolver is not in Debian."""


def speed_rows(peers, ready, results):
    """One dict for each system that was measured, in the order of ``peers``."""
    base, rows = results.get(OURS), []
    for peer in peers:
        if peer.name not in results:
            continue
        found = results[peer.name]
        facts = {"name": peer.name, "computes": peer.computes, "version": ready[peer.name].version}
        speed = {"times_real_time": statistics.median(found["runs"]), **found}
        speed["of_ukrt"] = median_ratio(found["runs"], base["runs"]) if base else None
        rows.append(facts | speed)
    return rows


def speed_table(rows):
    """The systems as a table."""
    table = Table(box=box.SIMPLE, title="The piece: 60 s, 495 notes, up to 6 at once", title_justify="left")
    for name, justify in (("system", "left"), ("what it computes", "left"), ("times real time", "right")):
        table.add_column(name, justify=justify)
    for name in ("from", "to", "of ukrt's"):
        table.add_column(name, justify="right", no_wrap=True)
    table.add_column("version")
    for row in rows:
        speeds = row["times_real_time"], min(row["runs"]), max(row["runs"])
        ratio = "" if row["of_ukrt"] is None else f"{row['of_ukrt']:.3g}"
        table.add_row(row["name"], row["computes"], *(f"{speed:.3g}" for speed in speeds), ratio, row["version"])
    return table


def convolver_table(rows, taps):
    """The convolvers as a table."""
    table = Table(box=box.SIMPLE, title=f"Convolution: {taps} taps, blocks of 64 frames", title_justify="left")
    table.add_column("convolver")
    table.add_column("how")
    for name in ("% of a core", "% a pair", "p50 us", "p99 us", "p99 / p50"):
        table.add_column(name, justify="right", no_wrap=True)
    table.add_column("version")
    for row in rows:
        numbers = row["percent"], row["percent_a_pair"], row["p50_us"], row["p99_us"], row["p99_us"] / row["p50_us"]
        table.add_row(row["name"], row["computes"], *(f"{number:.3g}" for number in numbers), row["version"])
    return table


def left_out_lines(left_out):
    """A line for each system that is not in the tables."""
    return [f"left out: {name}: {why}" for name, why in left_out.items()]
