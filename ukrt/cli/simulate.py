"""``ukrt simulate``: a case file becomes a result file, by the paper's scheme or by the engine."""

import sys

from ..errors import ParameterError
from .common import UsageError, add_command, add_set_option, announce_compiling, clock_time, make_console

_EPILOG = """\
examples:
  ukrt simulate --template > case.toml                    a complete case to change; it runs as it is
  ukrt simulate case.toml -o out.npz                      the paper's scheme at the case's step
  ukrt simulate case.toml -o out.h5 --solver engine       the real-time engine at its sample_rate; HDF5
  ukrt simulate case.toml -o out.npz --set plucks.0.force_y=5 --set guitar=classical

a short case:
  name = "open E2, rigid bridge"
  duration = 0.5                           # s
  bridge = "rigid"
  strings = ["E2"]
  plucks = [{ string = "E2", force_y = 5.0 }]
  [record]
  energies = true
  displacement = [{ string = "E2", place = 0.6 }]

The result is read with ukrt.experiment.result.load_result, an .npz also with numpy.load alone.
"""


def add_parser(commands):
    """Add the subcommand to the parser."""
    words = "run a numerical experiment described in a file"
    parser = add_command(commands, "simulate", words, _EPILOG)
    parser.add_argument("case", nargs="?", metavar="CASE.toml", help="the experiment")
    parser.add_argument(
        "-o", "--output", metavar="OUT.npz", help="file to write, .npz, .h5 or .hdf5; is replaced if it exists"
    )
    parser.add_argument(
        "--solver",
        choices=("reference", "engine"),
        default="reference",
        help="the paper's velocity-Verlet, or the real-time engine's own loop (default: %(default)s)",
    )
    add_set_option(parser, "change one value of the case", "`ukrt simulate --template` prints")
    parser.add_argument("--template", action="store_true", help="print a case with every key and its meaning, and end")
    parser.add_argument("--quiet", action="store_true", help="neither progress nor summary")
    parser.set_defaults(run=run)


def run(args):
    """Run the case and tell what came of it."""
    from ..experiment.case_file import example_text, load_case

    if args.template:
        if args.case or args.output or args.overrides:
            raise UsageError("--template prints a case and does nothing else; leave the other arguments out")
        print(example_text(), end="")
        return 0
    if args.case is None or args.output is None:
        raise UsageError("a case and a place for its result are needed: ukrt simulate CASE.toml -o OUT.npz")
    from ..experiment.result import check_result_path, save_result
    from ..simulate.run import simulate

    target = check_result_path(args.output)
    case = load_case(args.case, dict(args.overrides))
    if args.solver == "engine" and not args.quiet:
        announce_compiling("advance")
    try:
        with _progress(case.name, args.quiet) as progress:
            result = simulate(case, args.solver, progress)
    except ParameterError as error:  # legal in itself, but more than this solver can do
        raise UsageError(f"case {args.case}: {error}") from None
    save_result(result, target)
    if not args.quiet:
        print(_summary(target, result))
    return 0


class _progress:
    """A progress bar on a terminal, nothing elsewhere; gives the callback for a solver."""

    def __init__(self, words, quiet):
        self._words, self._bar = words, None
        self._wanted = not quiet and sys.stderr.isatty()

    def __enter__(self):
        if not self._wanted:
            return None
        from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

        columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn())
        self._bar = Progress(*columns, console=make_console(), transient=True)
        task = self._bar.add_task(self._words, total=1.0)
        self._bar.start()
        return lambda share: self._bar.update(task, completed=share)

    def __exit__(self, *_):
        if self._bar:
            self._bar.stop()


def _summary(target, result):
    """What was computed, and how long it took, in words."""
    facts, duration = result.facts, result.case.duration
    rows = {
        "solver": result.solver,
        "simulated": clock_time(duration),
        "steps": f"{facts['steps']} of {facts['step_s']:.4g} s",
        "modes": facts["modes"],
        "largest drift": f"{facts['largest_drift_m']:.2g} m",
        "energy at the end": None,
        "time taken": clock_time(facts["seconds_taken"]),
        "times real time": f"{duration / facts['seconds_taken']:.3g}",
    }
    if "energies" in result.quantities:
        rows["energy at the end"] = f"{result.column('energies', 'total')[-1]:.4g} J"
    lines = [f"  {name:<19}{value}" for name, value in rows.items() if value is not None]
    return "\n".join([f"{target}: {', '.join(result.quantities)}", *lines])
