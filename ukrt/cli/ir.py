"""``ukrt ir``: the hammer measurement: records of force and sound pressure become an impulse response that plays."""

import pathlib

from .common import UsageError, add_command, need_matplotlib, number, say
from .report import check_report_path, write_whole

_EPILOG = """\
The bridge is tapped with a hammer that measures its force, with all strings damped; a microphone, or two (left, right),
stands in front. Several hits make it better, in one record or in several (--more), and show the coherence: how much of
the pressure the force explains. With hits at the treble end of the bridge as well (--treble) the response between the
ends is interpolated, as the strings need it.

examples:
  ukrt ir force.wav mic.wav -o ir.wav --newtons 50 --pascals 2 --plot ir.png
  ukrt ir force.wav left.wav right.wav -o ir.wav --seconds 1
  ukrt ir f1.wav p1.wav --more f2.wav p2.wav --more f3.wav p3.wav -o ir.wav
  ukrt ir bass_f.wav bass_p.wav --treble treble_f.wav treble_p.wav -o ir.wav
  ukrt render song.mid --set radiation.impulse_response=ir.wav
"""
MOST_SECONDS = 2.0  # that the engine plays
SHOWN_HZ = (31.5, 63, 125, 250, 500, 1000, 2000, 4000, 8000, 16000)  # octaves, IEC 61260
ONSET, LEAD = 0.05, 0.0005  # of the largest tap that is the sound's arrival, and what is kept before it [s]


def add_parser(commands):
    """Add the subcommand to the parser."""
    parser = add_command(commands, "ir", "make an impulse response from records of hammer hits", _EPILOG)
    parser.add_argument("force", metavar="FORCE", help="record of the hammer's force, one channel (.wav, .flac)")
    parser.add_argument(
        "pressure", nargs="+", metavar="PRESSURE", help="of the microphone(s), at the same time: 1 or 2"
    )
    parser.add_argument("-o", "--output", required=True, metavar="OUT.wav", help="file to write; is replaced")
    for option, words in (("--more", "another record at the same place"), ("--treble", "a record at the treble end")):
        parser.add_argument(
            option,
            nargs="+",
            action="append",
            default=[],
            metavar=("FORCE", "PRESSURE"),
            help=f"{words}; may be repeated",
        )
    for option, unit, words in (("--newtons", "N", "force"), ("--pascals", "Pa", "pressure")):
        parser.add_argument(
            option,
            type=number(unit, -1e9, 1e9),
            default=1.0,
            metavar=unit.upper(),
            help=f"{unit} that one unit of the {words} file means; full scale is 1 (default: 1)",
        )
    parser.add_argument(
        "--seconds",
        type=number("s", 0.01, MOST_SECONDS),
        default=0.5,
        metavar="S",
        help=f"length of the response, to {MOST_SECONDS:g} (default: %(default)g)",
    )
    parser.add_argument(
        "--decay",
        type=number("s", 0.001, 100),
        metavar="S",
        help="weight records by an exponential of this time constant, for a sound longer than --seconds; it is taken "
        "out of the response again (default: none)",
    )
    parser.add_argument("--trim", action="store_true", help="leave out the time that the sound takes to the microphone")
    parser.add_argument("--plot", metavar="PNG", help="draw response and coherence into this file (needs matplotlib)")
    parser.set_defaults(run=run)


def run(args):
    """Read, estimate, write, tell."""
    from ..drivers.files.audio import AudioWriter, check_audio_path
    from ..identify.hammer import hammer_response

    check_audio_path(_target(args), "32f")
    plot = args.plot and check_report_path(args.plot, "--plot")
    if plot:
        need_matplotlib("--plot")
    places = {"bass end" if args.treble else "bridge": [[args.force, *args.pressure], *args.more]}
    if args.treble:
        places["treble end"] = args.treble
    records, rate = _read(args, places)
    found = {place: hammer_response(own, rate, args.seconds, args.decay) for place, own in records.items()}
    taps, trimmed = _taps(found, args.trim)
    if plot:
        from ..identify.hammer_picture import draw_response

        write_whole(plot, draw_response(found), "--plot")
    with AudioWriter(args.output, rate, taps.shape[1], "32f") as writer:
        writer.write(taps)
    _show(args, found, taps, trimmed)
    return 0


def _target(args):
    target = pathlib.Path(args.output)
    if target.suffix.lower() != ".wav":
        raise UsageError(f"-o {target}: its suffix is {target.suffix!r}, but a response is written as .wav")
    for one in (args.force, *args.pressure, *(name for more in args.more + args.treble for name in more)):
        if target.exists() and target.resolve() == pathlib.Path(one).resolve():
            raise UsageError(f"-o {target} is a record itself; name another file")
    return target


def _read(args, places):
    """Records of each place, as `hammer_response` takes them, and their common rate [Hz]."""
    from ..identify.hammer_files import read_hammer_record

    if args.newtons == 0.0 or args.pascals == 0.0:
        raise UsageError("--newtons and --pascals may not be 0: that would leave nothing of the records")
    records, first = {}, None
    for place, lists in places.items():
        for names in lists:
            if len(names) < 2:
                raise UsageError(f"{names[0]} stands alone, but a record is a file of force and one or two of pressure")
            record = read_hammer_record(names, args.newtons, args.pascals)
            first = first or record
            record.check_like(first)
            records.setdefault(place, []).append((record.force, record.pressure, record.name))
    return records, first.sample_rate


def _taps(found, trim):
    """Channels of the file (n, 1, 2 or 4), and what was left out at the beginning [s]."""
    import numpy as np

    parts = [one.taps for one in found.values()]
    if len(parts) == 2 and parts[0].shape[1] == 1:  # four channels: each end to left and right
        parts = [np.repeat(one, 2, axis=1) for one in parts]
    taps, rate = np.concatenate(parts, axis=1), next(iter(found.values())).sample_rate
    if not trim:
        return taps, 0.0
    arrived = int(np.min(np.argmax(np.abs(taps) > ONSET * np.abs(taps).max(axis=0), axis=0)))
    start = max(arrived - int(LEAD * rate), 0)
    return taps[start:], start / rate


def _show(args, found, taps, trimmed):
    """What was found, by octaves, on standard output."""
    from rich.console import Console
    from rich.table import Table

    console, rate = Console(highlight=False), next(iter(found.values())).sample_rate
    for place, one in found.items():
        left_out = f", {one.left_out} left out" if one.left_out else ""
        hits = f"{one.hits} hit{'s' if one.hits > 1 else ''}{left_out}"
        names = [f"coherence {n + 1}" for n in range(one.taps.shape[1])] if one.taps.shape[1] > 1 else ["coherence"]
        table = Table("octave / Hz", "force / dB", *names, title=f"{place}: {hits}; force to {one.band_hz:.0f} Hz")
        for centre in SHOWN_HZ:
            inside = (one.frequencies >= centre / 2**0.5) & (one.frequencies < centre * 2**0.5)
            if inside.sum() < 2 or centre / 2**0.5 > rate / 2:
                continue
            share = [f"{value:.3f}" if value == value else "one hit" for value in one.coherence[inside].mean(axis=0)]
            table.add_row(f"{centre:g}", f"{one.force_db[inside].mean():z.0f}", *share)
        console.print(table)
        if one.hits == 1:
            say(f"{place}: one hit shows no coherence; hit several times to see what is noise")
    if trimmed:
        print(f"left out the first {1e3 * trimmed:.2f} ms, in which the sound travels")
    words = f"{taps.shape[1]} channel{'s' if taps.shape[1] > 1 else ''}"
    print(
        f"{args.output}: {len(taps) / rate:.3g} s, {rate:.0f} Hz, {words}, in Pa/N; plays as radiation.impulse_response"
    )
