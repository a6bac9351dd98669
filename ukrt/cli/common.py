"""What the commands share: the parser's manners, types of arguments with their legal ranges, the guitar's options."""

import argparse
import contextlib
import math
import pathlib
import sys

from ..drivers.files.bundled import FOLDER, bundled_pieces
from ..errors import MissingExtraError, ParameterError, UkrtError


class UsageError(UkrtError):
    """The arguments do not fit together; the message says what would."""


class Parser(argparse.ArgumentParser):
    """argparse with errors in one sentence, and help texts that keep their lines."""

    def __init__(self, **options):
        options.setdefault("formatter_class", argparse.RawDescriptionHelpFormatter)
        options.setdefault("allow_abbrev", False)
        super().__init__(**options)

    def error(self, message):
        raise UsageError(f"{message} (see: {self.prog} --help)")


def add_command(commands, name, words, epilog):
    """A subcommand's parser; ``words`` say in one line what it does."""
    return commands.add_parser(name, help=words, description=f"{words[0].upper()}{words[1:]}.", epilog=epilog)


def number(unit, low, high, whole=False):
    """An argument type: a number from ``low`` to ``high`` [``unit``], in a sentence otherwise."""
    kind = "a whole number" if whole else "a number"
    words = f"{kind} from {low:g} to {high:g} {unit}".rstrip()

    def parse(text):
        try:
            value = int(text) if whole else float(text)
        except ValueError:
            value = math.nan
        if not low <= value <= high:
            raise argparse.ArgumentTypeError(f"{text!r} is not {words}")
        return value

    return parse


def assignment(text):
    """An argument type: KEY=VALUE as a pair of strings."""
    key, equals, value = text.partition("=")
    if not equals or not key.strip():
        raise argparse.ArgumentTypeError(f"{text!r} is not KEY=VALUE, such as pluck.place=0.85")
    return key.strip(), value.strip()


def add_set_option(parser, words, keys="`ukrt presets NAME` prints"):
    """``--set``; ``keys`` say where the legal keys are seen."""
    parser.add_argument(
        "--set",
        dest="overrides",
        type=assignment,
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help=f"{words}, by the dotted key that {keys}; may be repeated",
    )


TUNING_OPTIONS = {  # option -> the key of the preset that it sets, its metavar, help
    "--tuning": (
        "tuning.open_strings",
        "NOTES|NAME",
        'tune the open strings, from the bass side: "D2 A2 D3 G3 B3 E4", DADGBE, or a name such as drop-d or open-g',
    ),
    "--capo": ("playing.capo", "FRET", "a capo on all strings at this fret, 0 to 12"),
    "--scale": ("tuning.scale", "FILE.scl", "a scale in Scala's format; the frets move to it"),
    "--keyboard-map": ("tuning.keyboard", "FILE.kbm", "which key plays which note of the scale, in Scala's format"),
}
MODE_OPTIONS = {
    "--mode": (
        "playing.midi_mode",
        "MODE",
        "what MIDI channels stand for: keyboard, guitar (a string each), mpe (a note each), guitar-mpe (both)",
    ),
    "--base-channel": ("playing.base_channel", "N", "channel of the highest string with --mode guitar, 1 to 16"),
}


def add_tuning_options(parser):
    """``--tuning``, ``--capo``, ``--scale`` and ``--keyboard-map``, which are short for ``--set`` of a key."""
    _add_short_options(parser, TUNING_OPTIONS)


def add_mode_options(parser):
    """``--mode`` and ``--base-channel``, likewise."""
    _add_short_options(parser, MODE_OPTIONS)


def _add_short_options(parser, options):
    for option, (key, metavar, words) in options.items():
        parser.add_argument(
            option,
            dest="overrides",
            type=lambda text, key=key: (key, text),
            action="append",
            default=[],
            metavar=metavar,
            help=words,
        )


KEYSWITCHES = ("playing.keyswitches", "on")


def add_keyswitch_option(parser):
    """``--keyswitches``, which is short for ``--set playing.keyswitches=on``."""
    parser.add_argument(
        "--keyswitches",
        dest="overrides",
        action="append_const",
        const=KEYSWITCHES,
        help="keys below the guitar's range (from playing.keyswitch_key on, 21 or A0) say how notes are played",
    )


def add_guitar_options(parser):
    """``--preset`` and ``--set``."""
    parser.add_argument(
        "--preset",
        default="classical",
        metavar="NAME|FILE",
        help="the guitar: a name that `ukrt presets` lists, or a TOML file (default: %(default)s)",
    )
    add_set_option(parser, "change one value of the preset")


def piece(text):
    """An argument type: a MIDI file, or the name of one that comes with the package where no file is called so; gives
    its path (str)."""
    return text if pathlib.Path(text).exists() else str(bundled_pieces().get(text, text))


def sound_of(midi):
    """Where the sound of a MIDI file goes if nobody says: beside it, or what comes with the package to the current
    folder (Path)."""
    midi = pathlib.Path(midi)
    return (pathlib.Path(midi.name) if midi.parent == FOLDER else midi).with_suffix(".wav")


def add_rate_option(parser, default, words):
    """``--rate``."""
    parser.add_argument(
        "--rate",
        type=number("Hz", 44100, 192000, whole=True),
        default=default,
        metavar="HZ",
        help=f"sample rate, 44100 to 192000 ({words})",
    )


def add_block_option(parser, default, words):
    """``--block``."""
    parser.add_argument(
        "--block",
        type=number("frames", 1, 8192, whole=True),
        default=default,
        metavar="N",
        help=f"frames computed at once; the sound does not depend on it ({words})",
    )


def add_part_options(parser, words):
    """``--from`` and ``--to``, as ``args.start`` and ``args.end`` (Position or None)."""
    where = "seconds (12.5), 1:30, bar:5, bar:5.3 (its third beat) or marker:NAME"
    parser.add_argument("--from", dest="start", type=_position, metavar="PLACE", help=f"{words}: {where}")
    parser.add_argument("--to", dest="end", type=_position, metavar="PLACE", help="and ends before this, likewise")


def _position(text):
    """An argument type: a place in a piece."""
    from ..drivers.files.position import parse_position

    try:
        return parse_position(text)
    except ParameterError as error:
        raise argparse.ArgumentTypeError(f"{text!r} is no place in a piece; {error.legal}") from None


def add_fingering_option(parser, more=""):
    """``--fingering``."""
    parser.add_argument(
        "--fingering",
        choices=("look-ahead", "causal"),
        help="strings and positions chosen with the whole piece in view, or note by note as in live play (default: "
        f"look-ahead{more})",
    )


def load_guitar(args):
    """The guitar that ``--preset`` and ``--set`` describe."""
    from ..model.presets import load_preset

    return load_preset(args.preset, dict(args.overrides))


def given_settings(overrides):
    """The options that ``overrides`` come from, as they are written (list of str)."""
    short = {key: option for option, (key, *_) in (TUNING_OPTIONS | MODE_OPTIONS).items()}
    short[KEYSWITCHES[0]] = "--keyswitches"
    return list(dict.fromkeys(short.get(key, "--set") for key, _ in overrides))


def need_matplotlib(who):
    """Refuse early where no picture can be drawn; ``who`` needs it."""
    try:
        import matplotlib.figure  # noqa: F401
    except ImportError:
        raise MissingExtraError(f"{who} needs matplotlib, which is missing: pip install 'ukrt[plot]'") from None


def make_console():
    """A rich console on standard error, for what is not the command's result."""
    from rich.console import Console

    return Console(stderr=True, highlight=False, soft_wrap=not sys.stderr.isatty())


def say(message):
    """A line of progress to standard error."""
    print(f"ukrt: {message}", file=sys.stderr, flush=True)


def clock_time(seconds):
    """A duration in words, such as ``3:05`` or ``4.2 s``."""
    if seconds < 60:
        return f"{seconds:.1f} s"
    minutes, rest = divmod(int(round(seconds)), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{rest:02d}" if hours else f"{minutes}:{rest:02d}"


def announce_compiling(*needed, what="the engine", long="half a minute"):
    """Say so where something has to be compiled first, which takes a while; ``needed`` are functions' names.

    Returns whether it has to be (bool).
    """
    from ..engine.kernel_cache import cache_folder

    folder = pathlib.Path(cache_folder())
    missing = not all(any(folder.rglob(f"*.{name}-*.nbi")) for name in needed)
    if missing:
        say(f"compiling {what} for this machine; this is done once and takes {long}")
    return missing


def _begin_compiling():
    """Say so where the engine has to be compiled first, and let helpers do it; returns whether it has to be."""
    missing = announce_compiling("callback", "play", "take_over")
    if missing:
        from .compiling import share_compiling

        share_compiling(say)
    return missing


def make_engine(guitar, rate, **options):
    """An engine for ``guitar``; says so where it has to be compiled first."""
    _begin_compiling()
    from ..engine.engine import Engine

    return Engine(guitar, float(rate), **options)


def need_compiled(guitar):
    """Compile the engine where that has not been done yet, before several processes would do it side by side."""
    if _begin_compiling():
        from ..engine.engine import Engine

        with contextlib.closing(Engine(guitar, 48000.0)) as engine:
            engine.process(64)


def describe_notes(counters):
    """What became of the notes, in words, from the engine's counters; what did not happen is not mentioned."""
    words = [str(counters["notes_on"]), f"dropped {counters['notes_dropped']}"]
    for name, text in (
        ("notes_stolen", "cut short for another note"),
        ("notes_folded", "moved by octaves into the range"),
        ("notes_percussion", "of percussion, not played"),
    ):
        if counters.get(name):
            words.append(f"{text} {counters[name]}")
    return ", ".join(words)
