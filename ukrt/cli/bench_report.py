"""What ``ukrt bench`` has measured, as tables and pictures: a report enters, words leave."""

from ..benchmark.compare import compare_reports
from .common import say


def _console():
    from rich.console import Console

    return Console(highlight=False, soft_wrap=True)


def _table(*columns):
    from rich import box
    from rich.table import Table

    table = Table(box=box.SIMPLE)
    for n, name in enumerate(columns):
        table.add_column(name, justify="left" if n == 0 else "right", no_wrap=True)
    return table


def show(report):
    """All that was measured, on standard output."""
    console = _console()
    console.print(
        f"{report['preset']} at {report['rate_hz']} Hz, blocks of {report['block_frames']} frames "
        f"({1e3 * report['period_ms']:.0f} us), {report['response_s']:g} s of stereo convolution;\n"
        f"median of {report['runs']} runs of {report['seconds']:g} s on one core of {report['machine']['processor']};\n"
        "times of blocks in us"
    )
    table = _table("case", "x real time", "p50", "p99", "p99.9", "max", "p99.9 of period")
    for case in report["cases"]:
        times = case["block_us"]
        share = f"{0.1 * times['p99.9'] / report['period_ms']:.1f} %"
        table.add_row(case["name"], f"{case['times_real_time']:.1f}", *(f"{t:.0f}" for t in times.values()), share)
    console.print(table)
    for case in report["cases"]:
        console.print(f"  {case['name']:<13} {case['words']}")
    if "parts_ns" in report:
        _show_parts(console, report)


def _show_parts(console, report):
    table = _table("part, by itself", "ns a sample")
    for name, cost in report["parts_ns"].items():
        table.add_row(name, f"{cost:.0f}")
    console.print(table)
    table = _table("message or gesture, beside its samples", "us")
    for name, cost in report["gestures_us"].items():
        table.add_row(name, f"{cost:.1f}")
    console.print(table)
    roof = report["roofline"]
    console.print(
        f"The sweeps do {roof['flops']:.0f} flops on {roof['bytes'] / 1024:.0f} KiB a sample. This core reaches "
        f"{1e-9 * roof['peak_flops']:.0f} Gflop/s in a loop of\nmultiply-adds and {1e-9 * roof['peak_bytes']:.0f} GB/s "
        f"from its first-level cache: no code could take less than {roof['least_ns']:.0f} ns.\n"
        f"They take {roof['measured_ns']:.0f} ns: {100 * roof['share']:.0f} % of the roofline."
    )


def show_comparison(old, new, path):
    """How much faster each case is than in the older report."""
    rows, differing = compare_reports(old, new)
    for words in differing:
        say(f"--compare {path}: {words}")
    table = _table("case", "x real time before", "now", "ratio")
    for name, before, now, ratio in rows:
        table.add_row(name, f"{before:.1f}", f"{now:.1f}", f"{ratio:.3f}")
    _console().print(table)


def show_growth(growths):
    """The line of each quantity."""
    console = _console()
    table = _table("cost of a sample against", "from", "to", "none, ns", "each, ns", "off the line")
    for growth in growths:
        slope, start = growth.line
        low, high = (f"{value:.3g} {growth.unit}".strip() for value in (growth.amounts.min(), growth.amounts.max()))
        table.add_row(growth.name, low, high, f"{start:.0f}", f"{slope:.2g}", f"{100 * growth.deviation:.0f} %")
    console.print(table)


def draw_blocks(path, report):
    """How often blocks took how long, for each case, into a picture."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, panel = pyplot.subplots(figsize=(9, 5), layout="constrained")
    for case in report["cases"]:
        histogram = case["histogram"]
        panel.stairs(histogram["blocks"], histogram["edges_us"], label=case["name"])
    panel.axvline(1e3 * report["period_ms"], color="0.4", linestyle="--", label="period")
    panel.set(xscale="log", yscale="log", xlabel="time of a block [us]", ylabel="blocks")
    panel.legend()
    minutes = report["runs"] * report["seconds"] / 60.0
    panel.set_title(
        f"{report['preset']}, {report['block_frames']} frames at {report['rate_hz']} Hz, {minutes:.3g} minutes of each"
    )
    figure.savefig(path)
    pyplot.close(figure)
