"""``ukrt figures``: the figures of the paper, computed; pictures, data, sounds and a table of comparable numbers."""

import argparse
import contextlib
import time

from .common import add_command, announce_compiling, make_console, need_matplotlib, say

_EPILOG = """\
Each figure becomes figure_NN.png, the data behind it with units and cases (figure_NN.npz) and its numbers beside the
paper's (figure_NN.csv); 12 and 13 also sound (.wav). What was done, what agrees and what does not stands on a page for
each figure, in ukrt/figures/README.md.

examples:
  ukrt figures                                 all of them, into the folder figures
  ukrt figures 6 7 -o /tmp/figs                two of them
  ukrt figures all -o figs --solver engine     by the engine that plays live, instead of the paper's own scheme
"""
_ALL = "all"
_MARKS = {True: "[green]yes[/]", False: "[bold red]no[/]", None: ""}


def add_parser(commands):
    """Add the subcommand to the parser."""
    from ..figures.registry import NUMBERS
    from ..simulate.run import SOLVERS

    parser = add_command(commands, "figures", "compute the figures of the paper", _EPILOG)
    parser.add_argument(
        "numbers",
        type=_figure,
        nargs="*",
        default=[_ALL],
        metavar="FIGURE",
        help=f"{', '.join(map(str, NUMBERS))} or all (default: all)",
    )
    parser.add_argument(
        "-o", "--output", default="figures", metavar="DIR", help="folder to write into (default: %(default)s)"
    )
    parser.add_argument(
        "--solver",
        choices=SOLVERS,
        default=SOLVERS[0],
        help="what computes them: the paper's own scheme, or the engine that plays live (default: %(default)s)",
    )
    parser.set_defaults(run=run)


def run(args):
    """Compute, write and compare."""
    from ..figures.registry import NUMBERS
    from ..figures.write import check_folder

    need_matplotlib("ukrt figures")
    folder = check_folder(args.output)
    if args.solver == "engine":
        announce_compiling("advance")
    wanted = NUMBERS if _ALL in args.numbers else sorted(set(args.numbers))
    made = {}
    with _Progress(len(wanted)) as progress:
        for number in wanted:
            made[number] = _make(number, folder, args.solver, progress)
    _show(made)
    return 0


def _figure(text):
    from ..figures.registry import NUMBERS

    if text == _ALL:
        return text
    if text.isdecimal() and int(text) in NUMBERS:
        return int(text)
    raise argparse.ArgumentTypeError(f"{text!r} is no figure; there are {', '.join(map(str, NUMBERS))} and all")


def _make(number, folder, solver, progress):
    """One figure from case to files; returns its `FigureData`."""
    from ..figures.registry import load_figure
    from ..figures.runs import Run
    from ..figures.write import write_figure

    began = time.perf_counter()
    module = load_figure(number)
    progress.begin(number)
    data = module.make(Run(solver, progress.show))
    paths = write_figure(number, data, folder, solver)
    names = ", ".join(path.name for path in paths)
    progress.done(f"figure {number} in {time.perf_counter() - began:.1f} s: {names} in {folder}")
    return data


class _Progress(contextlib.AbstractContextManager):
    """A bar for the figures and one for the case that runs, on a terminal; elsewhere a line for each figure."""

    def __init__(self, count):
        from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn

        console = make_console()
        columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn())
        self._bar = Progress(*columns, console=console, transient=True, disable=not console.is_terminal)
        self._figures = self._bar.add_task("figures", total=count)
        self._case = self._bar.add_task("", total=1.0)

    def __enter__(self):
        self._bar.start()
        return self

    def __exit__(self, *_):
        self._bar.stop()

    def begin(self, number):
        self._bar.update(self._figures, description=f"figure {number}")

    def show(self, name, share):
        self._bar.update(self._case, description=name, completed=share)

    def done(self, words):
        self._bar.update(self._figures, advance=1)
        if self._bar.disable:
            say(words)
        else:
            self._bar.console.print(words, soft_wrap=True, markup=False)


def _show(made):
    """The numbers of all figures as a table on standard output."""
    from rich import box
    from rich.console import Console
    from rich.markup import escape
    from rich.table import Table

    console = Console(highlight=False)
    if not console.is_terminal:
        console.width = max(console.width, 140)
    table = Table(box=box.SIMPLE, caption="notes to each number: figure_NN.csv")
    table.add_column("figure", justify="right")
    for name, ratio in (("what", 5), ("here", None), ("unit", None), ("the paper", 5), ("agrees", None)):
        table.add_column(name, ratio=ratio, justify="right" if name == "here" else "left", no_wrap=ratio is None)
    for number, data in made.items():
        for k, one in enumerate(data.numbers):
            first, last = str(number) if k == 0 else "", k == len(data.numbers) - 1
            cells = escape(one.what), f"{one.value:.5g}", escape(one.unit), escape(one.paper), _MARKS[one.agrees]
            table.add_row(first, *cells, end_section=last)
    console.print(table)
