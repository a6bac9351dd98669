"""``ukrt tab``: a MIDI file becomes tablature, MusicXML or annotations of which string and fret plays each note."""

import shutil
import sys

from .. import __version__
from ..errors import MidiFileError, MissingExtraError
from .common import (
    UsageError,
    add_command,
    add_fingering_option,
    add_guitar_options,
    add_keyswitch_option,
    add_mode_options,
    add_part_options,
    add_tuning_options,
    announce_compiling,
    load_guitar,
    number,
    piece,
    say,
)
from .report import check_report_path, write_whole

_EPILOG = """\
The guitarist of `ukrt render` plays, without sound: strings and frets are those that it would have. Onsets are put on a
grid of up to 16 parts of a quarter note, as coarse as they allow; annotations keep the exact times.

examples:
  ukrt tab song.mid                               tablature on the terminal
  ukrt tab song.mid --from bar:5 --to bar:9       bars 5 to 8
  ukrt tab song.mid --preset drop-d -o song.txt
  ukrt tab song.mid -o song.musicxml              for MuseScore and others (needs ukrt[notation])
  ukrt tab song.mid -o song.jams                  annotations as in GuitarSet: notes of each string, frets, beats
"""
_SUFFIXES = {".txt": "text", ".musicxml": "MusicXML", ".xml": "MusicXML", ".jams": "JAMS"}


def add_parser(commands):
    """Add the subcommand to the parser."""
    parser = add_command(commands, "tab", "print which string and fret plays each note of a MIDI file", _EPILOG)
    parser.add_argument("midi", type=piece, metavar="IN.mid", help="MIDI file, format 0, 1 or 2")
    parser.add_argument(
        "-o", "--output", metavar="FILE", help="write .txt, .musicxml (or .xml) or .jams; is replaced (default: print)"
    )
    add_guitar_options(parser)
    add_tuning_options(parser)
    add_mode_options(parser)
    add_keyswitch_option(parser)
    add_part_options(parser, "show only what begins here")
    add_fingering_option(parser)
    parser.add_argument(
        "--width",
        type=number("letters", 40, 1000, whole=True),
        metavar="N",
        help="letters in a line of tablature, 40 to 1000 (default: the terminal's, 80 in files)",
    )
    parser.set_defaults(run=run)


def run(args):
    """Play silently, write down."""
    kind = _kind(args.output)
    from ..drivers.files.midi import load_midi_file
    from ..drivers.files.position import find_part

    score = load_midi_file(args.midi)
    start_s, end_s = find_part(args.start, args.end, score, args.midi)
    if start_s > score.duration_s:
        raise UsageError(f"--from {args.start.text}: {args.midi} ends at {score.duration_s:.1f} s, before that")
    guitar = load_guitar(args)
    announce_compiling("player_message", what="the guitarist", long="some seconds")
    from ..notation.silent import play_silently
    from ..playing.written_fingering import choose_fingering

    fingered, _ = choose_fingering(score, guitar, args.fingering or "look-ahead")
    sheet = _sheet(args.midi, score, guitar.name, play_silently(guitar, fingered), start_s, end_s)
    text = _write(kind, sheet, score, args)
    for warning in score.warnings:
        say(f"{args.midi}: {warning}")
    if not args.output:
        encoding = sys.stdout.encoding or "utf-8"
        print(text.encode(encoding, "replace").decode(encoding), end="")
        return 0
    write_whole(args.output, text.encode(), "-o")
    print(f"{args.output}: {len(sheet.tones)} notes in {len(sheet.measures)} bars, not played {len(sheet.lost)}")
    return 0


def _kind(output):
    """What is to be written, refused before anything is computed if it cannot be."""
    if output is None:
        return "text"
    suffix = check_report_path(output, "-o").suffix
    kind = _SUFFIXES.get(suffix.lower())
    if kind is None:
        raise UsageError(f"-o {output}: its suffix is {suffix!r}, {', '.join(_SUFFIXES)} are legal")
    if kind == "MusicXML":
        try:
            import musicxml  # noqa: F401
        except ImportError:
            raise MissingExtraError(
                f"-o {output} needs the package musicxml, which is missing: pip install 'ukrt[notation]'"
            ) from None
    return kind


def _sheet(path, score, name, played, start_s, end_s):
    from ..notation.sheet import make_sheet

    notes, open_keys, _ = played
    try:
        return make_sheet(score, name, notes, open_keys, start_s, end_s)
    except MidiFileError as error:
        raise MidiFileError(f"{path}: {error}") from None


def _write(kind, sheet, score, args):
    """The text of the file, or of the terminal."""
    software = f"ukrt {__version__}"
    if kind == "MusicXML":
        from ..notation.musicxml_file import make_musicxml

        return make_musicxml(sheet, software)
    if kind == "JAMS":
        from ..notation.jams_file import make_jams

        return make_jams(sheet, score, software)
    from ..notation.tablature import draw

    width = args.width or (80 if args.output else shutil.get_terminal_size((80, 24)).columns)
    return draw(sheet, width)
