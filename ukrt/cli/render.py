"""``ukrt render``: MIDI files become audio files; a take becomes exactly what was heard when it was played."""

import os
import pathlib
import sys

from .common import (
    UsageError,
    add_block_option,
    add_command,
    add_fingering_option,
    add_guitar_options,
    add_keyswitch_option,
    add_mode_options,
    add_part_options,
    add_rate_option,
    add_tuning_options,
    clock_time,
    given_settings,
    load_guitar,
    make_console,
    make_engine,
    number,
    piece,
    say,
    sound_of,
)
from .render_report import summary
from .report import check_report_path, write_report

_EPILOG = """\
examples:
  ukrt render song.mid                            song.wav, 48 kHz, 24 bit
  ukrt render song.mid -o song.flac --rate 96000
  ukrt render song.mid --preset drop-d --set pluck.place=0.8
  ukrt render song.mid --tuning DADGAD --capo 2 --scale meantone.scl
  ukrt render song.mid --signal strings --bits 32f -o strings.wav
  ukrt render song.mid --report song.json         which string and fret each note took
  ukrt render song.mid --from bar:5 --to bar:9    bars 5 to 8, bit for bit as in the whole
  ukrt render song.mid --from marker:Coda         from a marker on; --from 1:30 --to 95.5 are times
  ukrt render *.mid -o wavs --jobs 4              several files into a folder, four at a time
  ukrt render demonstration -o all.wav            every articulation, each against the plain note; one of them:
  ukrt render demonstration --from marker:slide --to marker:trill -o slide.wav
  ukrt render take.mid -o heard.wav               a take of `ukrt play --record`, bit for bit as it was played
  ukrt render take.mid --set pluck.place=0.9      its messages on another guitar, as any MIDI file
"""
TAIL_DB = -60.0


class _Unchosen(str):
    """A default that can be told from the same word given by hand."""


def add_parser(commands):
    """Add the subcommand to the parser."""
    parser = add_command(commands, "render", "turn a MIDI file into an audio file", _EPILOG)
    parser.add_argument(
        "midi",
        nargs="+",
        type=piece,
        metavar="IN.mid",
        help="MIDI file, format 0, 1 or 2, or a take; or what comes with ukrt: romance, demonstration",
    )
    parser.add_argument(
        "-o",
        "--output",
        metavar="OUT.wav",
        help="file to write, .wav or .flac; is replaced if it exists (default: the input's name with .wav, beside it; "
        "of what comes with ukrt, in the current folder); of several files the folder they go to",
    )
    parser.add_argument(
        "--jobs",
        type=number("", 1, 1024, whole=True),
        metavar="N",
        help="of several files, how many are rendered at a time, each on a core of its own (default: all cores)",
    )
    add_guitar_options(parser)
    add_tuning_options(parser)
    add_mode_options(parser)
    add_keyswitch_option(parser)
    parser.set_defaults(preset=_Unchosen("classical"))
    add_rate_option(parser, None, "default: 48000; a take's own")
    add_block_option(parser, 512, "default: %(default)s")
    parser.add_argument(
        "--bits", choices=("16", "24", "32f"), help="sample format, 32f is float (default: 24; a take's 32f in a .wav)"
    )
    parser.add_argument(
        "--signal",
        choices=("pressure", "bridge-force", "strings"),
        help="stereo sound, the force on the bridge, or each string's share of it in a channel (default: pressure; a "
        "take's own)",
    )
    parser.add_argument(
        "--gain",
        type=number("dB", -200, 200),
        default=0.0,
        metavar="DB",
        help="louder or softer by this, on top of the preset's gain; full scale is 1 Pa or 1 N times the gain",
    )
    parser.add_argument(
        "--normalize", action="store_true", help="put the peak of the whole at -1 dBFS, whatever it was"
    )
    add_part_options(parser, "write only what begins here; computed as in the whole, bit for bit")
    parser.add_argument(
        "--tail-db",
        type=number("dB", -200, -1),
        default=TAIL_DB,
        metavar="DB",
        help="end when this little energy is left after the last event, 30 s after it at most (default: %(default)g)",
    )
    parser.add_argument(
        "--max-minutes",
        type=number("minutes", 0, 1e6),
        default=120.0,
        metavar="MIN",
        help="refuse longer music (default: %(default)g)",
    )
    add_fingering_option(parser, "; a take's messages: causal")
    parser.add_argument("--force", action="store_true", help="replace the output file if it exists, without -o as well")
    parser.add_argument("--report", metavar="FILE.json", help="write what happened to each note as JSON")
    parser.set_defaults(run=run)


def run(args):
    """Render and tell what came of it."""
    report_path = args.report and check_report_path(args.report)
    if len(args.midi) > 1 or (args.output and pathlib.Path(args.output).is_dir()):
        return _run_many(args, report_path)
    if args.jobs is not None:
        raise UsageError("--jobs is for several files; leave it away, the strings of one piece cannot be parted")
    args.midi = args.midi[0]
    with _progress() as progress:
        report = render_one(args, progress)
    if report_path:
        write_report(report_path, report)
    _tell(args, report)
    return 0


def _run_many(args, report_path):
    """Several files, several at a time."""
    from .render_many import choose_jobs, plan, prepare, render_many, tell

    plans = plan(args)
    prepare(args)
    results = render_many(plans, choose_jobs(args.jobs, len(plans)), render_one)
    if report_path:
        write_report(report_path, {"files": [_entry(one, result) for one, result in zip(plans, results, strict=True)]})
    return tell(plans, results, _tell)


def _entry(args, result):
    return {"input": args.midi, **({"error": result} if isinstance(result, str) else result)}


def render_one(args, progress=None):
    """Render one file (``args.midi``), or a take; returns the report."""
    from ..drivers.takes.reader import is_take

    target = _target(args)
    render = _render_take if is_take(args.midi) else _render
    return {"output": str(target), **render(args, target, progress)}


def _tell(args, report):
    """What came of one file, in words."""
    for warning in report["warnings"]:
        say(f"{args.midi}: {warning}")
    for warning in report.get("tuning_warnings", ()):
        say(f"tuning: {warning}")
    print(summary(report["output"], report))


def _render(args, target, progress, guitar=None, rate=48000, signal="pressure", fingering="look-ahead"):
    """Render a MIDI file; returns the report."""
    from ..render import render_file

    return render_file(
        args.midi,
        target,
        guitar or load_guitar(args),
        bits=args.bits or "24",
        overwrite=args.force or args.output is not None,
        sample_rate=args.rate or rate,
        block_size=args.block,
        signal=args.signal or signal,
        gain_db=args.gain,
        normalize=args.normalize,
        tail_db=args.tail_db,
        max_minutes=args.max_minutes,
        start=args.start,
        end=args.end,
        fingering=args.fingering or fingering,
        progress=progress,
        engine_factory=make_engine,
    )


def _render_take(args, target, progress):
    """Render a take as it was played, or its messages in another way where that is asked for; returns the report."""
    from ..drivers.takes.files import render_take
    from ..drivers.takes.reader import read_take

    take = read_take(args.midi)
    start_s, end_s = _part_of_take(args)
    if other := _other_than(args, take):
        say(f"{args.midi}: with {', '.join(other)} the take is rendered like any MIDI file, not bit for bit as played")
        return _render(args, target, progress, _guitar_of(args, take), round(take.sample_rate), take.signal, "causal")
    return render_take(
        args.midi,
        target,
        bits=args.bits or ("24" if target.suffix.lower() == ".flac" else "32f"),
        overwrite=args.force or args.output is not None,
        block_size=args.block,
        max_minutes=args.max_minutes,
        start_s=start_s,
        end_s=end_s,
        progress=progress,
        engine_factory=make_engine,
    )


def _part_of_take(args):
    """The part of a take that is wanted: (start, end) [s]."""
    from ..drivers.files.position import find_part

    for option, position in (("--from", args.start), ("--to", args.end)):
        if position is not None and position.seconds is None:
            raise UsageError(f"{option} {position.text}: {args.midi} is a take, which has times (12.5 or 1:30) alone")
    return find_part(args.start, args.end, None, args.midi)


def _other_than(args, take):
    """The options that ask for something else than was played (list of str)."""
    wanted = {
        "--preset": not isinstance(args.preset, _Unchosen),
        **dict.fromkeys(given_settings(args.overrides), True),
        "--rate": args.rate not in (None, take.sample_rate),
        "--signal": args.signal not in (None, take.signal),
        "--gain": args.gain != 0.0,
        "--normalize": args.normalize,
        "--tail-db": args.tail_db != TAIL_DB,
        "--fingering": args.fingering is not None,
    }
    return [option for option, is_other in wanted.items() if is_other]


def _guitar_of(args, take):
    """The guitar of ``--preset``, else the take's own, with ``--set``."""
    if not isinstance(args.preset, _Unchosen):
        return load_guitar(args)
    from ..model.presets import parse_preset

    return parse_preset(take.presets[0], f"{args.midi}: its preset", dict(args.overrides))


def _target(args):
    """Where the sound goes; refuses what would overwrite something that was not named."""
    midi = pathlib.Path(args.midi)
    target = pathlib.Path(args.output) if args.output else sound_of(midi)
    if target.exists():
        if midi.exists() and os.path.samefile(midi, target):
            raise UsageError(f"{target} is the input itself; name another file with -o")
        if not (args.force or args.output):
            raise UsageError(f"{target} exists already; replace it with --force, or name a file with -o")
    return target


class _progress:
    """A progress bar on a terminal, nothing elsewhere; gives the callback for `render_file`."""

    def __enter__(self):
        if not sys.stderr.isatty():
            return None
        from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

        columns = (TextColumn("{task.fields[words]}"), BarColumn(), TimeRemainingColumn())
        self._bar = Progress(*columns, console=make_console(), transient=True)
        task = self._bar.add_task("", total=None, words="preparing")
        self._bar.start()

        def show(done_s, total_s):
            words = f"{clock_time(done_s)} of {clock_time(total_s)}"
            self._bar.update(task, completed=done_s, total=total_s, words=words)

        return show

    def __exit__(self, *_):
        if bar := getattr(self, "_bar", None):
            bar.stop()
