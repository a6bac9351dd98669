"""``ukrt identify``: measured responses of a guitar's bridge become a preset with that body."""

import pathlib

from .common import UsageError, add_command, add_guitar_options, load_guitar, need_matplotlib, number, say
from .report import check_report_path, write_whole

_EPILOG = """\
A MEASUREMENT holds impulse responses (WAV, FLAC; CSV and MAT over time) or admittances (CSV and MAT over frequency)
between the two ends of the bridge. Which path a response is, from drive to motion, stands behind the file's name,
several with commas, or is the name of its column. Otherwise responses are taken in this order:

  one    bass-bass                            (the treble end is taken to move alike)
  two    bass-bass, bass-treble
  three  bass-bass, bass-treble, treble-treble
  four   bass-bass, bass-treble, treble-bass, treble-treble

CSV: the first line names the columns; the first one is time (t...) in s, with one column for each response, or
frequency (f...) in Hz, with a real and an imaginary column for each. MAT: t or fs with h, or f with a complex H.

examples:
  ukrt identify bb.wav bt.wav tt.wav -o mine.toml --plot fit.png
  ukrt identify low.wav@bass-bass high.wav@treble-treble -o mine.toml
  ukrt identify stereo.wav@bass-bass,bass-treble -o mine.toml --quantity acceleration --scale 9.81
  ukrt identify admittance.csv -o mine.toml --max-hz 700 --modes 10
  ukrt identify bridge.wav -o mine.toml --taps       bridge.wav was made by `ukrt ir`, from a velocity
  ukrt play --preset mine.toml
"""
DOUBTFUL = 0.1  # of a value: a larger spread over model orders is marked


def add_parser(commands):
    """Add the subcommand to the parser."""
    parser = add_command(commands, "identify", "make a preset of a measured guitar body", _EPILOG)
    parser.add_argument("measurement", nargs="+", metavar="MEASUREMENT", help="a file, or FILE@DRIVE-RESPONSE,...")
    parser.add_argument("-o", "--output", required=True, metavar="OUT.toml", help="preset to write; is replaced")
    parser.add_argument("--plot", metavar="FIT.png", help="draw the fit into this file (needs matplotlib)")
    for option, default, words in (("--max-hz", 1000.0, "highest"), ("--min-hz", 40.0, "lowest")):
        parser.add_argument(
            option,
            type=number("Hz", 10, 20000),
            default=default,
            metavar="HZ",
            help=f"{words} frequency of a mode (default: %(default)g)",
        )
    parser.add_argument(
        "--modes",
        type=number("", 1, 64, whole=True),
        metavar="N",
        help="the N strongest modes (default: all that are stable over the model orders and stand out of the noise)",
    )
    _add_units(parser)
    add_guitar_options(parser)
    parser.set_defaults(run=run)


def _add_units(parser):
    parser.add_argument(
        "--quantity",
        choices=("velocity", "acceleration", "displacement"),
        default="velocity",
        help="what was measured (default: velocity)",
    )
    parser.add_argument(
        "--scale",
        type=number("", -1e12, 1e12),
        default=1.0,
        metavar="X",
        help="what one unit in the file means: in impulse responses (m/s)/(N s), the unit of the paper's Fig. 2, in "
        "admittances (m/s)/N; m or m/s^2 with another --quantity (default: 1; negative turns a sensor round)",
    )
    parser.add_argument(
        "--taps",
        action="store_true",
        help="samples are responses to 1 N that lasts one sample, (m/s)/N, as `ukrt ir` writes them",
    )
    parser.add_argument(
        "--delay",
        type=number("ms", 0, 1000),
        default=0.0,
        metavar="MS",
        help="by which the responses come late (default: 0)",
    )


def run(args):
    """Read, identify, write, tell."""
    from ..identify import identify, preset_of

    target, plot = _target(args), args.plot and check_report_path(args.plot, "--plot")
    if plot:
        need_matplotlib("--plot")
    guitar, measurement = load_guitar(args), _read(args)
    found = identify(measurement, args.max_hz, args.min_hz, args.modes, 1e-3 * args.delay)
    text = preset_of(found, guitar, target.stem, measurement)
    if plot:
        from ..identify.picture import draw_fit

        write_whole(plot, draw_fit(found, measurement.quantity), "--plot")
    write_whole(target, text.encode(), "-o")
    for note in found.notes:
        say(note)
    _show(found, target)
    return 0


def _target(args):
    from ..identify.files import split_paths

    target = check_report_path(args.output, "-o")
    if target.suffix.lower() != ".toml":
        raise UsageError(f"-o {target}: its suffix is {target.suffix!r}, but a preset's file ends in .toml")
    for option, path in (("-o", target), ("--plot", args.plot and pathlib.Path(args.plot))):
        for one in args.measurement:
            if path and path.exists() and path.resolve() == pathlib.Path(split_paths(one)[0]).resolve():
                raise UsageError(f"{option} {path} is a measurement itself; name another file")
    return target


def _read(args):
    """The measurement that the arguments describe."""
    from ..identify.files import read_record, split_paths
    from ..identify.measurement import make_measurement

    if args.scale == 0.0:
        raise UsageError("--scale 0 leaves nothing of the measurement, any other number is legal")
    names, paths = zip(*map(split_paths, args.measurement), strict=True)
    records = [read_record(name, args.quantity) for name in names]
    if args.taps and records[0].periodic:
        raise UsageError("--taps is for impulse responses, but an admittance was given")
    return make_measurement(records, paths, args.quantity, args.scale, args.taps)


def _show(found, target):
    """The modes as a table on standard output."""
    from rich.console import Console
    from rich.table import Table

    table = Table("", "f / Hz", "zeta / %", "m / kg", "bass", "treble", "complexity")
    spread = found.uncertainties
    rows = zip(
        _pairs(found.frequencies_hz, spread["frequencies_hz"], "{:.2f}"),
        _pairs(100 * found.damping_ratios, 100 * spread["damping_ratios"], "{:.3f}"),
        _pairs(found.modal_masses, spread["modal_masses"], "{:.4g}"),
        _pairs(found.shapes[:, 0], spread["shapes"][:, 0], "{:.3f}", 1.0),
        _pairs(found.shapes[:, 1], spread["shapes"][:, 1], "{:.3f}", 1.0),
        (f"{value:.1f}°" for value in found.complexity_deg),
        strict=True,
    )
    for n, row in enumerate(rows, 1):
        table.add_row(str(n), *row)
    console = Console(highlight=False)
    console.print(table)
    console.print("± standard uncertainty; ? above 10 % of the value. Of the response these modes leave unexplained:")
    for path, db in found.fits.items():
        console.print(f"  {path:<14} {db:6.1f} dB ({100 * 10 ** (db / 20):.2g} % in amplitude)", soft_wrap=True)
    print(f"{target}: {len(found.frequencies_hz)} modes")


def _pairs(values, errors, form, size=None):
    """Values with their uncertainties, doubtful ones marked (list of str)."""
    return [
        f"{form.format(value)} ±{error:.0e}{' ?' if error > DOUBTFUL * (size or abs(value)) else ''}"
        for value, error in zip(values, errors, strict=True)
    ]
