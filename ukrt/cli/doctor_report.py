"""What ``ukrt doctor`` found, for people: a report (dict) enters, tables on the terminal or a picture leave."""

_NONE_PERCENT = 1e-3  # where no loss is drawn on a logarithmic axis
_MARKS = {"problem": "[bold red]!![/]", "hint": "[yellow] ![/]", "good": "[green] +[/]"}


def show(report):
    """Print facts, loads, delays and advice to standard output."""
    from rich.console import Console
    from rich.markup import escape
    from rich.table import Table

    console = Console(highlight=False)
    console.print(_machine_table(report["machine"]))
    output = report["output"]
    for note in report["notes"]:
        console.print(f"{escape(note)}\n", soft_wrap=True)
    console.print(
        f"{escape(report['preset'])} at {output['rate_hz']:.0f} Hz on {escape(output['name'])}; "
        f"{report['strings_plucked']} of {report['strings']} strings ringing, "
        f"{report['contacts']} contacts on each stopped string",
        soft_wrap=True,
    )
    console.print(_load_table(report["cells"]))
    console.print(_delay_table(report["cells"]))
    advice = Table.grid(padding=(0, 1))
    for one in report["advice"]:
        advice.add_row(_MARKS[one["severity"]], escape(one["words"]))
    console.print(advice)


def _machine_table(machine):
    from rich import box
    from rich.markup import escape
    from rich.table import Table

    table = Table(box=box.SIMPLE, show_header=False)
    table.add_column(no_wrap=True)
    table.add_column(overflow="fold")
    for name, value in _machine_rows(machine):
        table.add_row(name, escape(value))
    return table


def _machine_rows(machine):
    """Facts in words (pairs of str)."""
    processor, scheduling, lock = machine["processor"], machine["scheduling"], machine["memory_lock"]
    cache, libraries = machine["jit_cache"], machine["libraries"]
    busy = "" if processor["load_average"] is None else f", {processor['load_average']:.1f} busy"
    kernel = {True: ", real-time kernel", False: "", None: ""}[machine["system"]["realtime_kernel"]]
    yield "system", f"{machine['system']['name']}{kernel}, Python {machine['system']['python']}"
    yield "processor", f"{processor['model']}, {processor['cores']} cores{busy}"
    yield "governor", ", ".join(processor["governors"] or ["not told by this system"])
    yield "real-time priority", _allowed(scheduling["allowed"], scheduling["rtprio_limit"])
    yield "memory lock", _allowed(lock["allowed"], lock["limit_bytes"])
    yield "compiled code", f"{'kept' if cache['warm'] else 'not yet'} in {cache['folder']}"
    absent = [name.replace("_", " ") for name, found in libraries.items() if not found]
    present = [name.replace("_", " ") for name, found in libraries.items() if found]
    yield "libraries", ", ".join(present) + (f"; not found: {', '.join(absent)}" if absent else "")
    for title, names in (("audio outputs", machine["audio_outputs"]), ("MIDI inputs", machine["midi_inputs"])):
        yield title, "; ".join(names) if names else "none"


def _allowed(allowed, limit):
    words = {True: "allowed", False: "refused", None: "not told by this system"}[allowed]
    return words if limit is None else f"{words} (limit {'none' if limit == -1 else limit})"


def _load_table(cells):
    from rich import box
    from rich.table import Table

    table = Table(box=box.SIMPLE, caption="load: % of a block's time; lost: callbacks that never happened")
    for name, side in (("frames", "right"), ("callback", "left")):
        table.add_column(name, justify=side, no_wrap=True)
    for name in ("p50", "p99", "p99.9", "max", "xruns", "lost", "of all"):
        table.add_column(name, justify="right", no_wrap=True)
    for cell in cells:
        for k, (name, result) in enumerate(cell["sources"].items()):
            first = (str(cell["block_frames"]), cell["stress"] if cell["stress"] != "none" else "", "")[k]
            loads = result["load"] or {}
            shares = [_percent(loads[q]) if loads else "" for q in ("p50", "p99", "p99.9", "max")]
            lost = f"{result['missing_percent']:.2g} %" if result["missing"] else ""
            table.add_row(first, name, *shares, str(result["xruns"]), str(result["missing"]), lost, end_section=k == 2)
    return table


def _percent(share):
    return f"{100 * share:.0f}" if share < 100.0 else ">9999"


def _delay_table(cells):
    from rich import box
    from rich.table import Table

    table = Table(box=box.SIMPLE, caption="from key to sound in ms, without the keyboard's own")
    for name in ("frames", "MIDI", "output", "pluck's force", "together"):
        table.add_column(name, justify="right", no_wrap=True)
    seen = set()
    for cell in cells:
        if cell["block_frames"] not in seen:
            seen.add(cell["block_frames"])
            delay = cell["delay"]
            parts = [f"{delay[key]:.1f}" for key in ("midi_ms", "output_ms", "pluck_ms", "total_ms")]
            table.add_row(str(cell["block_frames"]), *parts)
    return table


def draw(path, report):
    """Loads and lost callbacks of each source over block size and stress, into a PNG file."""
    from matplotlib.figure import Figure

    from ..errors import AudioFileError

    cells = report["cells"]
    names = [f"{cell['block_frames']}\n{cell['stress']}" for cell in cells]
    figure = Figure(figsize=(max(6.0, 0.7 * len(cells)), 7.0), layout="constrained")
    loads, losses = figure.subplots(2, 1, sharex=True)
    colors = {"compiled": "tab:blue", "empty": "tab:gray", "python": "tab:red"}
    for source, color in colors.items():
        results = [cell["sources"][source] for cell in cells]
        lost = [max(result["missing_percent"], _NONE_PERCENT) for result in results]
        losses.plot(names, lost, "o", color=color, label=source)
        if all(result["load"] for result in results):
            for quantile, mark in (("p50", "o"), ("p99.9", "^"), ("max", "x")):
                values = [100 * result["load"][quantile] for result in results]
                loads.plot(names, values, mark, color=color, label=f"{source} {quantile}")
    loads.set(yscale="log", ylabel="load / % of the block", title=f"{report['preset']} on {report['output']['name']}")
    losses.set(yscale="log", ylabel=f"lost callbacks / % (none: {_NONE_PERCENT})", xlabel="frames, stress")
    for panel in (loads, losses):
        panel.grid(alpha=0.3)
        panel.legend(fontsize="small", ncols=3)
    try:
        figure.savefig(path)
    except (OSError, ValueError) as error:
        raise AudioFileError(f"cannot write {path}: {error}") from error
