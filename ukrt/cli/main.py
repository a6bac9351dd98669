"""The command ``ukrt``: arguments enter, one of the subcommands runs, its exit code leaves.

Exit codes: 0 done, 1 what was asked for came to nothing (a device failed while playing), 2 refused in one sentence (bad
arguments, files or parameters), 130 interrupted.
"""

import os
import signal
import sys
import threading

from .. import __version__
from ..errors import UkrtError
from . import bench, devices, doctor, figures, identify, ir, play, presets, render, simulate, tab
from .common import Parser

_EPILOG = """\
examples:
  ukrt render song.mid                 song.wav beside it, 48 kHz, 24 bit
  ukrt play                            a MIDI keyboard plays the guitar; the bundled piece, where there is none
  ukrt tab song.mid                    its tablature: which string and fret plays each note
  ukrt presets                         the guitars there are
  ukrt presets classical > mine.toml   a guitar to change; then: ukrt play --preset mine.toml
  ukrt identify bass.wav -o mine.toml  the body of a guitar from measured responses of its bridge
  ukrt ir hammer.wav mic.wav -o ir.wav its sound from records of a hammer and a microphone
  ukrt simulate case.toml -o out.npz   a numerical experiment; ukrt simulate --template prints one
  ukrt doctor                          why it crackles, and what to do about it
  ukrt bench                           how many times faster than real time this machine is
  ukrt figures 6 -o figs               a figure of the paper, the data behind it, numbers beside the paper's

Each command has its own --help.
"""


def make_parser():
    """The argument parser with all subcommands."""
    parser = Parser(prog="ukrt", description="A nylon-string guitar computed from its physics.", epilog=_EPILOG)
    parser.add_argument("--version", action="version", version=f"ukrt {__version__}")
    commands = parser.add_subparsers(title="commands", dest="command", metavar="COMMAND", required=True)
    for module in (render, play, tab, devices, presets, identify, ir, simulate, figures, bench, doctor):
        module.add_parser(commands)
    return parser


def main(argv=None):
    """Run ``ukrt`` with ``argv`` (default: the process's arguments); returns the exit code."""
    try:
        args = make_parser().parse_args(argv)
        code = args.run(args) or 0
        sys.stdout.flush()  # here, where a closed pipe can still be dealt with
        return code
    except UkrtError as error:
        _complain(error)
        return 2
    except KeyboardInterrupt:
        _complain("interrupted; nothing half-written is left")
        return 130
    except BrokenPipeError:  # whoever read our output has seen enough (ukrt presets | head)
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0


def run():
    """Entry point of the console script: a termination signal ends as tidily as Ctrl-C."""
    if threading.current_thread() is threading.main_thread():
        for number in (signal.SIGINT, signal.SIGTERM):  # a shell starts background jobs with SIGINT ignored
            signal.signal(number, signal.default_int_handler)
    sys.exit(main())


def _complain(message):
    sentence = " ".join(str(message).split())
    print(f"ukrt: {sentence}", file=sys.stderr)
