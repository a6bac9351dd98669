"""``ukrt play``: a MIDI keyboard (or a MIDI file) plays the guitar through the sound card, live."""

import pathlib
import sys
import time

from ..errors import DeviceError
from .common import (
    add_block_option,
    add_command,
    add_guitar_options,
    add_rate_option,
    clock_time,
    describe_notes,
    load_guitar,
    make_engine,
    say,
)

_EPILOG = """\
Without a MIDI port the bundled piece is played once. Without a sound card the same engine runs on a clock, block by
block, and what would have been heard is written to a WAV file in the current folder. Ctrl-C ends with a summary.

examples:
  ukrt play                                    first MIDI input, default audio output
  ukrt play --list                             what there is to choose from
  ukrt play --midi-in keystation --audio-out 3
  ukrt play --preset drop-d --set pluck.place=0.85
  ukrt play song.mid                           a MIDI file through the live path
"""
_TAIL_SECONDS = 8.0  # the most that is waited for a piece's last notes
_LOOK_SECONDS = 1.0  # between two looks for a MIDI port


def add_parser(commands):
    """Add the subcommand to the parser."""
    parser = add_command(commands, "play", "play the guitar live, from a MIDI keyboard or a MIDI file", _EPILOG)
    parser.add_argument("piece", nargs="?", metavar="IN.mid", help="play this MIDI file, then end")
    parser.add_argument(
        "--midi-in", metavar="NAME", help="MIDI input by index or part of its name (none: no MIDI input)"
    )
    parser.add_argument(
        "--audio-out",
        metavar="NAME",
        help="audio output by index or part of its name (null: no sound card, a WAV file instead)",
    )
    add_guitar_options(parser)
    add_rate_option(parser, None, "default: 48000 where the sound card can, else the card's own")
    add_block_option(parser, None, "default: 128; on JACK the server's")
    parser.add_argument("--list", action="store_true", help="list audio outputs and MIDI inputs, and end")
    parser.set_defaults(run=run)


def run(args):
    """Play until the piece is over, or until Ctrl-C."""
    if args.list:
        from .devices import print_devices

        print_devices()
        return 0
    from ..drivers import feeder, live
    from ..drivers.midi_file import load_midi_file

    guitar = load_guitar(args)
    piece = load_midi_file(args.piece) if args.piece else None
    device, port = _find_device(args), _find_port(args)
    engine, output = _open_output(args, guitar, device)
    midi_input = _open_port(port)
    session = live.LiveSession(engine, output, feeder.Feeder(engine, midi_input))
    failed = False
    try:
        with session:
            say(f"{guitar.name} at {engine.sample_rate:.0f} Hz on {output.name}; Ctrl-C ends")
            _perform(args, session, piece, listening=midi_input is not None)
    except KeyboardInterrupt:
        pass
    except DeviceError as error:
        say(error)
        failed = True
    print(_summary(session))
    return 1 if failed else 0


def _find_device(args):
    """The audio output that was asked for or is there; None for the null output."""
    if args.audio_out == "null":
        return None
    from ..drivers import audio

    try:
        device = audio.find_output(args.audio_out)
    except DeviceError as error:
        if args.audio_out is not None:
            raise
        say(error)  # PortAudio itself is missing: as good as no sound card
        return None
    if device is None:
        say("no sound card found")
    return device


def _find_port(args):
    """The MIDI input that was asked for or is there; None without."""
    if args.midi_in == "none" or (args.piece and args.midi_in is None):
        return None
    from ..drivers import midi_in

    return midi_in.find_input(args.midi_in)


def _open_output(args, guitar, device):
    """The engine at the output's rate, and the output."""
    from ..drivers import audio, null

    if device is None:
        engine = _loud(make_engine(guitar, args.rate or 48000))
        output = null.NullOutput(engine, args.block or 128)
        say(f"playing on the null output, a clock instead of a sound card; what would be heard goes to {output.path}")
        return engine, output
    engine = _loud(make_engine(guitar, audio.choose_rate(device, args.rate)))
    return engine, audio.AudioOutput(engine, device, args.block)


def _loud(engine):
    """The engine with the preset's gain on its way to the card."""
    from ..units import db_to_gain

    engine.output_gain = db_to_gain(engine.guitar.radiation.gain_db)
    return engine


def _open_port(port):
    """The opened MIDI input; None without a port."""
    if port is None:
        return None
    from ..drivers.midi_in import MidiInput

    opened = MidiInput(port)
    say(f"listening to {opened.name}")
    return opened


def _perform(args, session, piece, listening):
    """What is to be heard: the piece that was named, else a keyboard, else the bundled piece and then a keyboard."""
    if piece is None and listening:
        while True:
            _rest(session)
    if piece is None:
        path = bundled_piece()
        from ..drivers.midi_file import load_midi_file

        piece = load_midi_file(path)
        say(f"no MIDI input; playing the bundled piece, {piece.title or path.stem}")
    _play_piece(session, piece)
    if args.piece or args.midi_in == "none" or not sys.stdin.isatty():
        return
    say("waiting for a MIDI input to be plugged in; Ctrl-C ends")
    session.feeder.listen(_open_port(_wait_for_port(session)))
    while True:
        _rest(session)


def _play_piece(session, piece):
    session.feeder.play(piece)
    while not session.feeder.piece_over:
        _rest(session)
        session.sounding()
    ends = time.monotonic() + _TAIL_SECONDS
    while session.sounding() and time.monotonic() < ends:
        _rest(session)


def _wait_for_port(session):
    from ..drivers.midi_in import find_input

    while (port := find_input()) is None:
        looked = time.monotonic()
        while time.monotonic() - looked < _LOOK_SECONDS:
            _rest(session)
    return port


def _rest(session):
    time.sleep(0.1)
    session.check()


def _summary(session):
    """What was played and how well, in words."""
    from ..drivers.live import load_quantile

    counters = session.engine.counters()
    loads = counters["load_histogram"]
    median, worst = (load_quantile(loads, share) for share in (0.5, 1.0))
    blocks = f"{counters['blocks']} in {clock_time(session.seconds)}, xruns {session.xruns()}"
    if median is not None:
        blocks += f", load median {100 * median:.1f} %, worst {100 * worst:.1f} %"
    lines = [
        f"blocks   {blocks}",
        f"notes    {describe_notes(counters)}",
        f"messages {counters['midi_received']}, too late {counters['late_messages']}, lost {counters['midi_dropped']}",
    ]
    if counters["clipped_samples"]:
        lines.append(f"clipped  {counters['clipped_samples']} samples; lower the gain with --set radiation.gain_db=...")
    if counters["nonfinite_resets"]:
        lines.append(f"restarts {counters['nonfinite_resets']} times, after something that was not a number")
    if path := getattr(session.output, "path", None):
        lines.append(f"recorded {path}")
    return "\n".join(lines)


def bundled_piece():
    """The demonstration piece that comes with the package (Path)."""
    folder = pathlib.Path(__file__).resolve().parents[1] / "data"
    return sorted(folder.glob("*.mid"))[0]
