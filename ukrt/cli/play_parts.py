"""What ``ukrt play`` is put together from: checked arguments enter; ways to open the output, MIDI inputs and a piece
player leave."""

import pathlib
from dataclasses import dataclass

from ..errors import DeviceError
from .common import UsageError

DEFAULT_RATE, DEFAULT_BLOCK = 48000.0, 128


@dataclass
class Way:
    """How sound leaves.

    Attributes
    ----------
    driver : str
        "portaudio", "jack" or "null".
    sample_rate : float [Hz]
    open : callable (engine) -> output
    fallback : str
        Why this is not what was hoped for, in a sentence; "" if it is.
    """

    driver: str
    sample_rate: float
    open: object
    fallback: str = ""


def find_way(args):
    """The `Way` that the arguments ask for, or that is there."""
    if args.driver == "jack":
        return _jack(args)
    if args.driver == "null":
        return _null(args)
    try:
        return _portaudio(args)
    except DeviceError as error:
        if any(one is not None for one in (args.driver, args.audio_out, args.host_api, args.channels, args.latency)):
            raise  # who names a card does not want to play on a clock
        return _null(args, str(error))


def _null(args, fallback=""):
    from ..drivers.sound.null import NullOutput

    return Way(
        "null",
        float(args.rate or DEFAULT_RATE),
        lambda engine: NullOutput(engine, args.block or DEFAULT_BLOCK, silent=True),
        fallback,
    )


def _portaudio(args):
    from ..drivers.sound.process import AudioProcess, probe

    device, rate = probe(args.audio_out, args.host_api, args.rate)
    if device is None:
        raise DeviceError("no sound card was found")
    wanted, host_api = args.audio_out, args.host_api
    if wanted is not None and wanted.isdecimal():  # after a reconnection the numbers may be others
        wanted, host_api = device.name, device.host_api

    def open_output(engine):
        return AudioProcess(
            engine,
            wanted,
            host_api=host_api,
            sample_rate=args.rate,
            block_size=args.block,
            latency=args.latency if args.latency is not None else "low",
            channels=args.channels,
        )

    return Way("portaudio", rate, open_output)


def _jack(args):
    from ..drivers.jack.client import JackOutput, server_rate

    connect = {None: True, "none": False}.get(args.audio_out, args.audio_out)
    midi = {(): not args.piece, ("all",): True, ("none",): False}.get(tuple(args.midi_in or ()), args.midi_in)
    if args.wait_for_midi and args.midi_in is None:
        midi = True
    return Way("jack", server_rate(), lambda engine: JackOutput(engine, connect=connect, midi=midi))


def make_live_engine(args, guitar, sample_rate):
    """The engine as the arguments turn its knobs, in memory that other processes can see."""
    from .common import make_engine

    engine = make_engine(guitar, sample_rate, shared=True)
    engine.output_gain = engine.instance.preset_gain
    engine.limiter = not args.no_limiter
    if args.no_shedding:
        engine.shed_budget = 0.0
    elif args.shed_budget is not None:
        engine.shed_budget = args.shed_budget
    engine.energy()  # loads what computes it, before the clock runs
    return engine


def remove_memory(engine):
    """Remove the names of the engine's shared memory, which goes with the last process that uses it."""
    from multiprocessing import shared_memory

    manifest = engine.manifest()
    for block in filter(None, (manifest["stage"], *manifest["slots"])):
        shared_memory.SharedMemory(block["name"]).unlink()


def midi_sources(args, engine, driver):
    """Where messages come from besides the output (list of one or none)."""
    wanted = wanted_inputs(args)
    if driver == "jack" or (wanted == [] and not args.midi_virtual):
        return []
    from ..drivers.midi.process import MidiProcess

    delay = None if args.midi_delay is None else round(args.midi_delay * engine.sample_rate / 1000.0)
    return [MidiProcess(engine.manifest(), wanted, virtual=args.midi_virtual, delay_frames=delay)]


def wanted_inputs(args):
    """None: the first device there is; "all"; or a list of names, which may be empty."""
    if args.midi_in is None:
        return [] if args.piece and not args.wait_for_midi else None
    if args.midi_in == ["all"]:
        return "all"
    return [] if "none" in args.midi_in else list(dict.fromkeys(args.midi_in))


def find_controllers(args):
    """What the arguments want controllers to mean (Controllers)."""
    from ..drivers.midi.mapping import Mapping, load_mapping, mapping_path
    from .learning import Controllers

    if args.mapping == "none":
        return Controllers(Mapping(), None)
    path = pathlib.Path(args.mapping) if args.mapping else mapping_path()
    absent = not path.exists() and (args.mapping is None or args.learn is not None)
    return Controllers(Mapping() if absent else load_mapping(path), path)


def load_piece(args, guitar):
    """The piece that was named, fingered for ``guitar`` (Score) and what that came to (Summary); None, None without."""
    if args.piece is None:
        return None, None
    score, chosen = fingered_piece(args.piece, guitar, args.fingering)
    if args.loop and not score.n_notes:
        raise UsageError(f"--loop: {args.piece} holds no note, a piece with notes is needed")
    return score, chosen


def fingered_piece(path, guitar, choice):
    """A MIDI file whose strings and positions are chosen beforehand, unless not wanted (Score, Summary)."""
    from ..drivers.files.midi import load_midi_file
    from ..playing.written_fingering import choose_fingering

    return choose_fingering(load_midi_file(path), guitar, choice or "look-ahead")


def make_player(args, engine, score, session_output):
    """The player of ``score``; with ``--transport`` it asks ``session_output()`` for JACK's transport."""
    from ..drivers.live.piece import PiecePlayer

    def transport():
        stamp = getattr(session_output(), "transport_stamp", None)
        if stamp is None:  # the stand-in, while the server is away
            return False, 0.0, 0
        rolling, frame, engine_frame = stamp()
        return rolling, frame / engine.sample_rate, engine_frame

    return PiecePlayer(
        engine, score, loop=args.loop, wait=args.wait_for_midi, transport=transport if args.transport else None
    )
