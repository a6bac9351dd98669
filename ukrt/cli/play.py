"""``ukrt play``: a MIDI keyboard (or a MIDI file) plays the guitar through the sound card, live."""

import contextlib
import pathlib
import sys
import time
from dataclasses import asdict

from ..drivers.files.bundled import ROMANCE
from ..errors import UkrtError
from .common import add_command, say
from .play_options import add_options, check_options
from .play_parts import (
    find_controllers,
    find_way,
    fingered_piece,
    load_piece,
    make_live_engine,
    make_player,
    midi_sources,
    remove_memory,
    wanted_inputs,
)
from .programs import Programs

_TAIL_SECONDS = 8.0  # the most that is waited for a piece's last notes
_TURN_SECONDS = 0.05
_SHOW_SECONDS = 0.1  # between two status lines
_LOOK_SECONDS = 0.5  # between two looks at preset files
_PORTS_SECONDS = 1.0  # between two questions what MIDI comes from
_MIDI_SECONDS = 3.0  # the most that is waited for the MIDI inputs at the start


def add_parser(commands):
    """Add the subcommand to the parser."""
    parser = add_command(commands, "play", "play the guitar live, from a MIDI keyboard or a MIDI file", "")
    add_options(parser)
    parser.set_defaults(run=run)


def run(args):
    """Play until the piece is over, or until Ctrl-C."""
    if args.list:
        from .devices import print_devices

        print_devices()
        return 0
    check_options(args)
    from .interrupts import Interrupts
    from .preset_shelf import PresetShelf
    from .status import StatusLine

    shelf = PresetShelf(args.preset or ["classical"], dict(args.overrides))
    piece = load_piece(args, shelf.guitar)
    controllers = find_controllers(args)
    with Interrupts() as interrupts, StatusLine(not args.quiet and args.learn is None) as status:
        return Playing(args, shelf, piece, controllers, interrupts, status).play()


class Playing:
    """One call of the command, from opening the devices to the report.

    Parameters
    ----------
    args : argparse.Namespace
        Checked.
    shelf : PresetShelf
    piece : (Score, Summary) or (None, None)
        With how its strings were chosen.
    controllers : Controllers
    interrupts : Interrupts
    status : StatusLine
    """

    def __init__(self, args, shelf, piece, controllers, interrupts, status):
        self._args, self._shelf, self._interrupts, self._status = args, shelf, interrupts, status
        self._session, self._away, self._failure = None, False, None
        self._news = []  # (seconds, sentence)
        self._programs, self._controllers, self._learning = Programs(shelf, piece[0] is not None), controllers, None
        self._piece, self._fingering = piece
        self._demo = False  # whether the piece is the bundled one, for want of a keyboard
        self._next_look = self._next_show = self._next_ports = 0.0
        self._ports, self._state, self._output_counts, self._tail_ends = 0, {}, {}, 0.0

    def play(self):
        """Play; returns the exit code."""
        from ..drivers.live.session import LiveSession
        from ..drivers.takes.recorder import Recorder

        args, way = self._args, find_way(self._args)
        self._engine = engine = make_live_engine(args, self._shelf.guitar, way.sample_rate)
        self._guitar = engine.guitar
        self._warn(intonation_known=True)
        audio = args.record_audio
        if way.fallback and audio is None:
            from ..drivers.sound.null import new_recording_path

            audio = new_recording_path()
            self._tell(f"{way.fallback}: playing on a clock instead; what would be heard goes to {audio}")
        with contextlib.closing(engine):
            sources = midi_sources(args, engine, way.driver)
            self._recorder = recorder = Recorder(engine, args.record, audio)
            self._interrupts.hurried += [recorder.close, lambda: remove_memory(engine)]
            recorder.follow(self._programs.follow)
            self._controllers.put_on(engine)
            player = self._piece and make_player(args, engine, self._piece, lambda: self._session.output)
            self._session = LiveSession(engine, lambda: way.open(engine), sources, player, [recorder])
            try:
                ended, code = self._perform(self._session)
            finally:
                self._discard_empty()
            return self._conclude(ended, code)

    # While it plays --------------------------------------------------------------------------------------------------
    def _perform(self, session):
        """Open everything and play to the end; why it ended, and the exit code."""
        from .gauge import Gauge

        self._gauge = Gauge(self._engine)
        try:
            with session:
                try:
                    ended = self._play_on(session)
                finally:
                    self._state, self._away = session.state(), session.away
                    self._output_counts = getattr(session.output, "counts", dict)()
        except (KeyboardInterrupt, Exception) as error:
            if session.seconds == 0.0:
                raise
            if not isinstance(error, KeyboardInterrupt):
                self._failure = error
                return f"failed: {error}", 1
            ended = "interrupted"
        self._take_news()
        if self._away:
            return f"{ended}, while the output was away", 1
        return ended, 1 if session.player is not None and session.player.failure else 0

    def _play_on(self, session):
        """Play until it is over; why."""
        rate, output = self._engine.sample_rate, session.output.name
        self._tell(f"{self._engine.guitar.name} at {rate:.0f} Hz on {output}; Ctrl-C ends")
        self._tell_controllers()
        self._find_something_to_play()
        while (ended := self._over()) is None:
            self._turn()
            time.sleep(_TURN_SECONDS)
        return ended

    def _tell_controllers(self):
        """Say what knobs have been made to mean; begin to learn where that is wanted."""
        from .learning import Learning, wanted_functions

        controllers, names = self._controllers, self._args.learn
        if controllers.mapping.controllers:
            self._tell(f"controllers by {controllers.path}: {controllers.mapping}")
        if names is not None:
            self._learning = Learning(self._engine, controllers, wanted_functions(names), self._tell)
            self._recorder.follow(self._learning.hear)

    def _find_something_to_play(self):
        """Without a piece, without a keyboard and without a wish for one the bundled piece is played."""
        args, session = self._args, self._session
        if self._piece is not None or args.wait_for_midi or args.midi_virtual or args.driver == "jack":
            return
        if wanted_inputs(args) or args.learn is not None:
            return
        for source in session.midi_sources:
            source.wait_ready(_MIDI_SECONDS)
        self._turn()
        if any(source.ports() for source in session.midi_sources):
            return
        path = ROMANCE
        self._piece, self._fingering = fingered_piece(path, self._guitar, args.fingering)
        self._demo = True
        session.player = make_player(args, self._engine, self._piece, None)
        session.player.start()
        self._tell(f"no MIDI input; playing the bundled piece, {self._piece.title or path.stem}")

    def _turn(self):
        """Look after everything once."""
        now, session = time.monotonic(), self._session
        self._interrupts.check()
        session.tend()
        self._take_news()
        self._choose_program()
        if self._learning is not None:
            self._learning.turn()
        if now >= self._next_look:
            self._next_look = now + _LOOK_SECONDS
            for sentence in self._shelf.look():
                self._tell(sentence)
        if self._shelf.guitar != self._guitar:
            self._guitar = self._shelf.guitar
            session.change_preset(self._guitar)
            self._warn()
        if now >= self._next_show:
            self._next_show = now + _SHOW_SECONDS
            self._show(now)

    def _show(self, now):
        session, player = self._session, self._session.player
        if not self._status.shown:
            return
        moment = self._gauge.moment(session.state())
        if now >= self._next_ports:
            self._next_ports = now + _PORTS_SECONDS
            self._ports = sum(len(source.ports()) for source in session.midi_sources) + self._jack_sources()
        moment.ports = self._ports
        recorded = self._recorder.counts()
        if recorded["files"]:
            moment.recording_s = max(recorded["take_frames"], recorded["sound_frames"]) / self._engine.sample_rate
        if player is not None:
            moment.piece_s, moment.piece_of_s = player.position_s, self._piece.duration_s
        self._status.show(moment)

    def _jack_sources(self):
        ports = getattr(self._session.output, "ports", dict)()
        return sum(len(others) for name, others in ports.items() if name.startswith("midi"))

    def _take_news(self):
        for sentence in self._session.news():
            self._tell(sentence)

    def _tell(self, sentence):
        self._news.append((self._session.seconds if self._session else 0.0, sentence))
        self._status.say(sentence)

    def _warn(self, intonation_known=False):
        """Say what real strings would say to the tuning and, where the solver has run, which notes are wolves."""
        from ..model.string_limits import tuning_warnings, wolf_warnings

        for warning in tuning_warnings(self._guitar) + (wolf_warnings(self._guitar) if intonation_known else []):
            self._tell(f"tuning: {warning}")

    def _choose_program(self):
        for sentence in self._programs.look():
            self._tell(sentence)

    def _over(self):
        """Why it is over, None if it is not."""
        args, session = self._args, self._session
        if args.seconds is not None and session.seconds >= args.seconds:
            return f"{args.seconds:g} s are over"
        player = session.player
        if player is None:
            return None
        if player.failure is not None:
            return "the piece could not be played on"
        sounds = session.sounding()
        if not player.over:
            self._tail_ends = time.monotonic() + _TAIL_SECONDS
            return None
        if sounds and time.monotonic() < self._tail_ends:
            return None
        if self._demo and args.midi_in != ["none"] and (self._any_ports() or sys.stdin.isatty()):
            self._tell("the bundled piece is over; waiting for a MIDI input, Ctrl-C ends")
            session.player, self._piece = None, None
            player.close()
            return None
        return "the piece is over"

    def _any_ports(self):
        return any(source.ports() for source in self._session.midi_sources)

    # Afterwards ------------------------------------------------------------------------------------------------------
    def _discard_empty(self):
        """Remove files of a session that never came to its first frame."""
        if self._session.seconds == 0.0:
            for path in self._recorder.counts()["files"]:
                pathlib.Path(path).unlink(missing_ok=True)

    def _conclude(self, ended, code):
        from .play_report import make_report, summary
        from .report import write_report

        self._status.__exit__()
        known = (self._state, self._output_counts, self._recorder, self._shelf)
        report = make_report(self._session, *known, ended, self._news, self._args)
        report["fingering"] = self._fingering and asdict(self._fingering)
        report["programs"], report["mapping"] = self._programs.counts(), self._controllers.describe()
        print(summary(report), flush=True)
        if code:
            say(ended)
        if self._args.report:
            try:
                write_report(self._args.report, report)
            except UkrtError as error:
                say(error)
                code = 1
        if self._failure is not None and not isinstance(self._failure, UkrtError):
            raise self._failure  # a fault of the program shows where it is
        return code
