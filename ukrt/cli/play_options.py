"""The options of ``ukrt play``: a parser enters and gets them; parsed arguments enter and are refused where they
contradict each other."""

import argparse
import math
import pathlib

from .common import (
    UsageError,
    add_block_option,
    add_fingering_option,
    add_keyswitch_option,
    add_mode_options,
    add_rate_option,
    add_set_option,
    add_tuning_options,
    number,
    piece,
)
from .report import check_report_path

DRIVERS = ("portaudio", "jack", "null")
MOST_LATENCY_MS = 10_000.0
_EPILOG = """\
Without a MIDI port the bundled piece is played once, and whoever plugs in a keyboard joins in. Without a sound card the
same engine runs on a clock, block by block, and what would have been heard is written to a WAV file in the current
folder. Ctrl-C ends with a summary, a second one at once. A preset file that changes on the disk is taken over while
playing. Exit codes: 0 played, 1 a device failed for good, 2 refused.

examples:
  ukrt play                                    first MIDI input, default audio output
  ukrt play --list                             what there is to choose from
  ukrt play --midi-in keystation --audio-out 3 --latency low
  ukrt play --driver jack --record take.mid    JACK without PortAudio between; ukrt render take.mid gives the same bits
  ukrt play --preset a.toml --preset b.toml    program change 0 and 1 choose between them
  ukrt play --learn vibrato,mute               move a knob for each; what they play is kept for the next time
  ukrt play song.mid --loop --seconds 600      a MIDI file through the live path
  ukrt play song.mid --wait-for-midi           it begins with the first note from a keyboard
"""


def latency(text):
    """An argument type: ``low``, ``high`` or milliseconds; gives the words or seconds."""
    if text in ("low", "high"):
        return text
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0.0 <= value <= MOST_LATENCY_MS:
        words = f"neither low nor high nor a number from 0 to {MOST_LATENCY_MS:g} ms"
        raise argparse.ArgumentTypeError(f"{text!r} is {words}")
    return value / 1000.0


def add_options(parser):
    """All options of the command."""
    parser.epilog = _EPILOG
    parser.add_argument(
        "piece",
        nargs="?",
        type=piece,
        metavar="IN.mid",
        help="play this MIDI file (romance and demonstration come with ukrt), then end",
    )
    _add_audio(parser.add_argument_group("sound"))
    _add_midi(parser.add_argument_group("MIDI"))
    _add_guitar(parser.add_argument_group("the guitar"))
    _add_piece(parser.add_argument_group("the piece"))
    _add_files(parser.add_argument_group("what is kept and shown"))


def _add_audio(group):
    group.add_argument(
        "--driver",
        choices=DRIVERS,
        help="how sound leaves: through PortAudio, as a JACK client of its own, or on a clock without a sound card "
        "(default: portaudio, null where there is no card)",
    )
    group.add_argument(
        "--audio-out",
        metavar="NAME|INDEX",
        help="audio output by index or part of its name; with --driver jack the ports to connect to, none: nowhere",
    )
    group.add_argument("--host-api", metavar="NAME", help="only outputs of this host API, by a part of its name")
    group.add_argument(
        "--channels",
        type=number("", 1, 256, whole=True),
        metavar="N",
        help="channels of the card to open, 1 to 256: one gets the mean of left and right, of more the first two are "
        "played (default: 2, or 1 where the card has no more)",
    )
    add_rate_option(group, None, "default: 48000 where the sound card can, else the card's own")
    add_block_option(group, None, "default: 128; on JACK the server's")
    group.add_argument(
        "--latency",
        type=latency,
        metavar="low|high|MS",
        help="what is asked of the sound system, as it names it or in milliseconds (default: low)",
    )
    group.add_argument("--no-limiter", action="store_true", help="hold full scale by clipping instead of bending")
    shedding = group.add_mutually_exclusive_group()
    shedding.add_argument(
        "--no-shedding", action="store_true", help="never leave out what is least heard when the computer is too slow"
    )
    shedding.add_argument(
        "--shed-budget",
        type=number("", 0.1, 1.0),
        metavar="LOAD",
        help="share of a block's time beyond which something is left out, 0.1 to 1 (default: 0.9)",
    )


def _add_midi(group):
    group.add_argument(
        "--midi-in",
        action="append",
        metavar="NAME|INDEX",
        help="MIDI input by index or part of its name, which may be plugged in later; may be repeated. all: whatever "
        "there is; none: no input (default: the first one there is, and none where a piece is played)",
    )
    group.add_argument("--midi-virtual", metavar="NAME", help="offer a MIDI input of this name to other programs")
    group.add_argument(
        "--midi-delay",
        type=number("ms", 0, 1000),
        metavar="MS",
        help="constant delay from a key to its note, which hides the grid of blocks (default: one block)",
    )
    group.add_argument(
        "--learn",
        nargs="?",
        const="",
        metavar="NAME,...",
        help="learn which knob plays what while playing (vibrato, place, mute, ...), and keep it for the next time; "
        "without names they are asked for",
    )
    mapping = group.add_mutually_exclusive_group()
    mapping.add_argument(
        "--mapping",
        metavar="FILE|none",
        help="what knobs play, as --learn keeps it (default: the file in the user's folder of settings, "
        "UKRT_CONFIG_DIR overrides the folder)",
    )
    mapping.add_argument(
        "--no-mapping", dest="mapping", action="store_const", const="none", help="every controller means itself"
    )


def _add_guitar(group):
    group.add_argument(
        "--preset",
        action="append",
        metavar="NAME|FILE",
        help="the guitar: a name that `ukrt presets` lists, or a TOML file; repeated, program change 0, 1, ... chooses "
        "among them, in bank 1 among all of `ukrt presets --banks` (default: classical)",
    )
    add_tuning_options(group)
    add_mode_options(group)
    add_keyswitch_option(group)
    add_set_option(group, "change one value of the preset")


def _add_piece(group):
    group.add_argument("--loop", action="store_true", help="begin the piece again at its end, without a gap")
    group.add_argument(
        "--wait-for-midi",
        action="store_true",
        help="begin the piece with the first note that is played; without a piece, wait for a keyboard",
    )
    add_fingering_option(group)
    group.add_argument("--transport", action="store_true", help="the piece follows JACK's transport (--driver jack)")
    group.add_argument(
        "--seconds", type=number("s", 0.1, 1e7), metavar="N", help="end after so long (default: the piece's end)"
    )


def _add_files(group):
    group.add_argument("--record", metavar="TAKE.mid", help="keep what is played, for `ukrt render` to repeat exactly")
    group.add_argument("--record-audio", metavar="TAKE.wav", help="keep what is heard, as 32-bit float")
    group.add_argument("--report", metavar="FILE.json", help="write counters, loads and news as JSON at the end")
    group.add_argument("--quiet", "--no-status", action="store_true", help="no status line on the terminal")
    group.add_argument("--list", action="store_true", help="list audio outputs and MIDI inputs, and end")


def check_options(args):
    """Refuse contradictions, in a sentence, before anything is opened."""
    _check_audio(args)
    _check_midi(args)
    _check_learning(args)
    _check_piece(args)
    _check_files(args)


def _given(args, *names):
    """Those of the options that were given, as they are written."""
    values = {name: getattr(args, name) for name in names}  # 0 is given, False is not
    return [f"--{name.replace('_', '-')}" for name, value in values.items() if value is not None and value is not False]


def _check_audio(args):
    if args.driver == "null" and (given := _given(args, "audio_out", "host_api", "channels", "latency")):
        raise UsageError(f"--driver null plays into no sound card; leave {' and '.join(given)} away")
    if args.driver == "jack" and (given := _given(args, "host_api", "channels", "latency", "block", "rate")):
        raise UsageError(f"--driver jack: rate, block and the like are the server's; leave {' and '.join(given)} away")


def _check_midi(args):
    names = args.midi_in or []
    for word in ("all", "none"):
        if word in names and len(set(names)) > 1:
            raise UsageError(f"--midi-in {word} and other inputs contradict each other; name one or the other")
    if "none" in names and args.wait_for_midi and not args.midi_virtual:
        raise UsageError("--wait-for-midi waits for ever with --midi-in none; leave one of them away")
    if args.driver == "jack" and (given := _given(args, "midi_virtual", "midi_delay")):
        words = "--driver jack: the client's own MIDI port is open to all programs and has no delay"
        raise UsageError(f"{words}; leave {' and '.join(given)} away")


def _check_learning(args):
    if args.learn is None:
        return
    from .learning import wanted_functions

    wanted_functions(args.learn)
    if args.mapping == "none":
        raise UsageError("--learn keeps what it learns; leave --no-mapping away")
    if args.piece:
        raise UsageError(f"--learn listens to a player and plays no piece; leave {args.piece} away")
    if "none" in (args.midi_in or []) and not args.midi_virtual:
        raise UsageError("--learn listens for ever with --midi-in none; leave one of them away")


def _check_piece(args):
    if args.piece is None and (given := _given(args, "loop", "transport")):
        raise UsageError(f"{' and '.join(given)}: a piece is needed, as in: ukrt play song.mid {given[0]}")
    if args.transport and args.driver != "jack":
        raise UsageError("--transport follows JACK's transport; add --driver jack")
    if args.transport and (given := _given(args, "loop", "wait_for_midi")):
        raise UsageError(f"--transport says when the piece is played; leave {' and '.join(given)} away")


def _check_files(args):
    given = {name: getattr(args, name) for name in ("record", "record_audio", "report") if getattr(args, name)}
    if len({pathlib.Path(path).absolute() for path in given.values()}) < len(given):
        raise UsageError(f"{' and '.join(_given(args, *given))} name the same file; each needs its own")
    for name in ("record", "record_audio"):
        if name in given and pathlib.Path(given[name]).exists():
            option = f"--{name.replace('_', '-')}"
            raise UsageError(f"{option} {given[name]}: exists already, and takes are never replaced; name another file")
    if args.report:
        check_report_path(args.report)
        if args.piece and pathlib.Path(args.report).absolute() == pathlib.Path(args.piece).absolute():
            raise UsageError(f"--report {args.report}: is the piece itself; name another file")
