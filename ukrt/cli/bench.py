"""``ukrt bench``: how many times faster than real time this machine computes the guitar, which part costs what, and how
near that is to what the processor can do at all."""

import contextlib
import json

from .common import (
    UsageError,
    add_block_option,
    add_command,
    add_guitar_options,
    add_rate_option,
    add_tuning_options,
    load_guitar,
    make_console,
    need_compiled,
    need_matplotlib,
    number,
)
from .report import check_report_path

_EPILOG = """\
Blocks are timed one by one, on the core that has least to do; chords are plucked again each second, nothing sleeps.
Ratios between runs on one machine count, times do not.

examples:
  ukrt bench
  ukrt bench --json > before.json              then, after a change:
  ukrt bench --compare before.json
  ukrt bench --cases worst --seconds 120 --plot blocks.png     how long blocks take over ten minutes of the worst case
  ukrt bench --growth --plot growth.png        cost against modes, strings, contacts, blocks, rate, response
"""


def add_parser(commands):
    """Add the subcommand to the parser."""
    parser = add_command(commands, "bench", "measure how fast this machine computes the guitar", _EPILOG)
    add_guitar_options(parser)
    add_tuning_options(parser)
    add_rate_option(parser, 48000, "default: %(default)s")
    add_block_option(parser, 128, "default: %(default)s")
    parser.add_argument(
        "--seconds",
        type=number("s", 1, 600),
        default=10.0,
        metavar="S",
        help="sound computed in each of 5 runs of each case (default: %(default)g)",
    )
    parser.add_argument("--cases", metavar="NAME,...", help="measure only these cases, and no parts")
    parser.add_argument("--json", action="store_true", help="print JSON instead of tables")
    parser.add_argument(
        "--compare", metavar="OLD.json", help="say how much faster each case is than in an older report"
    )
    parser.add_argument("--growth", action="store_true", help="measure how cost grows with what there is to compute")
    parser.add_argument(
        "--plot", metavar="PNG", help="draw how long blocks take, or with --growth costs (needs matplotlib)"
    )
    parser.set_defaults(run=run)


def run(args):
    """Measure and print."""
    from ..benchmark.compare import read_report

    _check(args)
    older = read_report(args.compare) if args.compare else None
    guitar = load_guitar(args)
    need_compiled(guitar)
    if args.growth:
        return _run_growth(args, guitar)
    report = _measure(args, _chosen(args.cases), guitar)
    from . import bench_report

    if args.plot:
        bench_report.draw_blocks(args.plot, report)
    if args.json:
        print(json.dumps(report, indent=2))
    else:
        bench_report.show(report)
    if older:
        bench_report.show_comparison(older, report, args.compare)
    return 0


def _check(args):
    """Refuse contradictions before anything is measured."""
    if args.plot:
        check_report_path(args.plot, "--plot")
        need_matplotlib("--plot")
    if args.growth and (given := [f"--{name}" for name in ("cases", "compare", "json") if getattr(args, name)]):
        raise UsageError(f"--growth measures something else; leave {' and '.join(given)} away")
    if args.json and args.compare:
        raise UsageError("--compare prints a table, --json prints JSON; leave one of them away")


def _chosen(names):
    """The cases of that list, all without one."""
    from ..benchmark.cases import CASES

    if names is None:
        return CASES
    known = {case.name: case for case in CASES}
    wanted = [name.strip() for name in names.split(",")]
    for name in wanted:
        if name not in known:
            raise UsageError(f"--cases {name}: there is no such case; legal are {', '.join(known)}")
    return [known[name] for name in dict.fromkeys(wanted)]


def _measure(args, cases, guitar):
    """The report of all that is asked for."""
    from ..benchmark.machine import describe_machine, one_core
    from ..benchmark.parts import measure_parts
    from ..benchmark.whole import RESPONSE_SECONDS, RUNS, measure_cases

    with one_core() as core, _progress("cases", RUNS * len(cases)) as step:
        results = measure_cases(cases, guitar, args.rate, args.block, args.seconds, progress=step)
        parts = {} if args.cases else measure_parts(guitar, args.rate)
    return {
        "preset": guitar.name,
        "rate_hz": args.rate,
        "block_frames": args.block,
        "period_ms": 1e3 * args.block / args.rate,
        "response_s": RESPONSE_SECONDS,
        "seconds": args.seconds,
        "runs": RUNS,
        "machine": describe_machine(core),
        "cases": results,
        **parts,
    }


def _run_growth(args, guitar):
    from ..benchmark.growth import MEASUREMENTS, measure_growth, plot_growth
    from ..benchmark.machine import one_core, processor_name
    from . import bench_report

    with one_core(), _progress("growth", MEASUREMENTS) as step:
        growths = measure_growth(guitar, step)
    bench_report.show_growth(growths)
    if args.plot:
        plot_growth(growths, args.plot, f"{guitar.name} on one core of {processor_name()}")
    return 0


@contextlib.contextmanager
def _progress(words, total):
    """A bar on a terminal; it is drawn between measurements, not during them. Gives what brings it one step on."""
    from rich.progress import Progress

    console = make_console()
    with Progress(console=console, transient=True, auto_refresh=False, disable=not console.is_terminal) as bar:
        task = bar.add_task(words, total=total)
        yield lambda: bar.update(task, advance=1, refresh=True)
