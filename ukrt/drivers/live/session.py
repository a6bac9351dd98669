"""A live session: an engine, a way to open an output, and sources of messages enter; it plays until closed, whatever
happens to the devices.

Start and end are in the one order that is safe: recorders listen before the first frame exists, the output counts
frames before messages are stamped with them, and nobody sends any more when the output goes. Between them `tend` is
called about twenty times a second; it looks after everything, never waits, and what happened is told in sentences.
"""

import collections
import time

from ukrt.drivers.live.change import GuitarChanger, make_instance
from ukrt.drivers.live.output import OutputKeeper
from ukrt.drivers.live.watch import MissingFrames, ShedWatch, load_quantile
from ukrt.engine import stage_layout as at
from ukrt.units import gain_to_db

__all__ = ["LiveSession", "load_quantile"]

_QUIET_RATIO = 1e-6  # energy after a piece relative to its largest: -60 dB
_QUANTILES = {"load_p50": 0.5, "load_p99": 0.99, "load_p999": 0.999, "load_max": 1.0}


class LiveSession:
    """Context manager that keeps an engine playing.

    Parameters
    ----------
    engine : Engine
    open_output : callable () -> output
        Opens the output without starting it; called again whenever the output has gone. Raises `UkrtError`. An output
        may have ``news()``, and ``tend()`` where it wants to be looked after; both give sentences.
    midi_sources : sequence of object
        Each with ``start()`` and ``close()``, and where they have something to tell ``news()`` and ``counts()``.
    player : object, optional
        Of a piece; with ``start()`` and ``close()``.
    recorders : sequence of object
        Each with ``start()``, ``close()`` and ``announce(instance)``, which is told of every change of guitar or sample
        rate right before it is armed.
    prepare : callable (engine, guitar, sample_rate) -> Instance, optional
        Builds the instances that take over.

    Attributes
    ----------
    output : object
        Who asks the engine for blocks now: the device, or the null output while it is away.
    seconds : float [s]
        Since the start, to the end.
    closed_cleanly : bool
        Whether the output ended by itself.
    """

    def __init__(
        self,
        engine,
        open_output,
        midi_sources=(),
        player=None,
        recorders=(),
        *,
        prepare=make_instance,
    ):
        self.engine, self.player = engine, player
        self.midi_sources, self.recorders = list(midi_sources), list(recorders)
        self.closed_cleanly = True
        self._news = collections.deque()
        self._changer = GuitarChanger(engine, self._refresh, self._news.append, self._announce, prepare)
        self._keeper = OutputKeeper(engine, open_output, self._changer, self._news.append)
        self._missing, self._generation = MissingFrames(), 0
        self._shedding = ShedWatch()
        self._failed = set()  # parts whose end has been told
        self._told = set()  # what the system did not allow the output: once is enough, however often it is reopened
        self._began = self._ended = None
        self._largest_energy = 0.0

    def __enter__(self):
        try:
            for recorder in self.recorders:
                recorder.start()
            self._keeper.open()
            self._began = time.monotonic()
            for source in self.midi_sources:
                source.start()
            if self.player is not None:
                self.player.start()
        except BaseException:
            self._close()
            raise
        return self

    def __exit__(self, *_):
        self._close()

    def _close(self):
        """Close everything, in order; an interrupt or a fault in one part keeps none of the others open."""
        steps = [part.close for part in (self.player, *self.midi_sources) if part is not None]
        steps += [self._changer.close, self._close_output]
        steps += [recorder.close for recorder in self.recorders]
        failure = None
        for step in steps:
            try:
                step()
            except BaseException as error:
                failure = failure or error
        self._ended = time.monotonic()
        if failure is not None:
            raise failure

    def _close_output(self):
        self.closed_cleanly = self._keeper.close()

    def _refresh(self):
        self._keeper.refresh()

    def _announce(self, instance):
        for recorder in self.recorders:
            recorder.announce(instance)

    @property
    def output(self):
        """Who asks the engine for blocks now."""
        return self._keeper.output

    @property
    def away(self):
        """Whether the null output stands in for the device (bool)."""
        return self._keeper.away

    @property
    def reconnections(self):
        """How often the device has come back (int)."""
        return self._keeper.reconnections

    @property
    def seconds(self):
        """How long it has been playing [s]."""
        return 0.0 if self._began is None else (self._ended or time.monotonic()) - self._began

    def tend(self):
        """Look after everything: to be called about twenty times a second. Never waits."""
        self._keeper.tend()
        self._news.extend(getattr(self.output, "tend", list)())
        if self._generation != self._keeper.generation:
            self._generation = self._keeper.generation
            self._missing.restart()
        if (sentence := self._shedding.look(int(self.engine.stage.si[at.G_SHED]))) is not None:
            self._news.append(sentence)
        if not self.away:
            self._missing.look(*self.engine.stamp(), self.engine.sample_rate, self._block())

    def change_preset(self, guitar):
        """Change to ``guitar``, a `Guitar` or a callable that gives one, once it is prepared; returns at once.

        What rings goes on ringing on the new guitar. What goes wrong is told by `news`.
        """
        self._changer.want(guitar)

    def news(self):
        """What has happened since the last call (list of str, one sentence each)."""
        output = self.output
        for sentence in output.news() if hasattr(output, "news") else []:
            if sentence not in self._told:
                self._told.add(sentence)
                self._news.append(sentence)
        for part in filter(None, [*self.midi_sources, self.player, *self.recorders]):
            if hasattr(part, "news"):
                self._news.extend(part.news())
            elif (failure := getattr(part, "failure", None)) is not None and part not in self._failed:
                self._failed.add(part)
                self._news.append(f"{type(part).__name__} has failed: {failure}")
        return [self._news.popleft() for _ in range(len(self._news))]

    def xruns(self):
        """Gaps in the sound that outputs have told of (int)."""
        return self._keeper.xruns()

    def sounding(self):
        """Whether the guitar still has more than a millionth of the largest energy that this function has seen."""
        energy = self.engine.energy()
        self._largest_energy = max(self._largest_energy, energy)
        return energy > _QUIET_RATIO * self._largest_energy

    def state(self):
        """How things stand (dict of plain data), for a status line and for a report.

        ``peak_db`` is the loudest sample since the last call; loads and counts are since the start.
        """
        engine, output = self.engine, self.output
        counters = engine.counters()
        loads = counters["load_histogram"]
        peak, block = engine.peak_recent(), self._block()
        latency = max(output.latency, block / engine.sample_rate) if output is not None else 0.0
        return {
            "seconds": self.seconds,
            "output": output.name if output is not None else "none",
            "away": self.away,
            "sample_rate": float(engine.sample_rate),
            "block_size": block,
            "latency_ms": 1000.0 * latency,
            **{name: load_quantile(loads, share) for name, share in _QUANTILES.items()},
            "blocks": counters["blocks"],
            "xruns": self.xruns(),
            "late_blocks": counters["late_blocks"],
            "missing_frames": self._missing.frames,
            "reconnections": self.reconnections,
            "changes": self._changer.changes,
            "midi": [source.counts() for source in self.midi_sources if hasattr(source, "counts")],
            "peak_db": gain_to_db(peak) if peak > 0.0 else None,
            "limited_samples": counters["limited_samples"],
            "limiter_db": counters["limiter_db"],
            "shed_level": counters["shed_level"],
        }

    def _block(self):
        """Frames of the last block, or what the output was opened with (int)."""
        output = self.output
        return int(self.engine.stage.si[at.G_STAMP_BLOCK]) or (output.block_size if output is not None else 0)
