"""Several MIDI inputs become one lane: open inputs enter, stamped messages go into the stage, ends of notes too.

Each input keeps its own keys: when it vanishes, or stops saying that it is there (active sensing), what it holds down
is let go, unless another input holds the same key.
"""

from ukrt.drivers.midi.held import Held
from ukrt.drivers.midi.port import shown_name
from ukrt.drivers.midi.stream import ACTIVE_SENSING
from ukrt.engine import stage_layout as at

_SENSING_NS = round(at.SENSING_SECONDS * 1e9)


class _Source:
    """An input with what it holds down."""

    def __init__(self, source):
        self.input, self.held = source, Held()
        self.heard_ns, self.sensed = 0, False
        self.name = source.port.name if source.virtual else shown_name(source.port)


class Merger:
    """Polls inputs and writes into a lane.

    Parameters
    ----------
    lane : Lane
    clock : FrameClock

    Attributes
    ----------
    received : int
        Messages that came, of all kinds that leave a `MidiStream` but active sensing.
    sensing_timeouts : int
    news : list of str
        Sentences; whoever takes them clears the list.
    """

    def __init__(self, lane, clock):
        self.received = self.sensing_timeouts = 0
        self.news = []
        self._lane, self._clock = lane, clock
        self._sources = []

    @property
    def inputs(self):
        """The open inputs (list)."""
        return [source.input for source in self._sources]

    @property
    def names(self):
        """Their names (list of str)."""
        return [source.name for source in self._sources]

    def add(self, opened):
        """Take in an input: object with ``poll()``, ``port``, ``virtual`` and ``close()``."""
        source = _Source(opened)
        self._sources.append(source)
        self.news.append(f"listening to {source.name}")

    def remove(self, opened, why):
        """End what an input holds down and close it; ``why`` makes a sentence after its name."""
        source = next(s for s in self._sources if s.input is opened)
        self._sources.remove(source)
        ended = self._let_go(source)
        self.news.append(f"{source.name} {why}{_ended(ended)}")
        opened.close()

    def end(self):
        """End whatever is held down; nothing is closed."""
        for source in self._sources:
            self._let_go(source)

    def poll(self, now):
        """Move whatever has arrived into the lane; True if there was anything.

        Parameters
        ----------
        now : int
            The clock of the stamps [ns].
        """
        self._clock.look()
        received = self.received
        for source in self._sources:
            found = source.input.poll()
            if found:
                source.heard_ns = now
                self._write(source, found)
            elif source.sensed and now - source.heard_ns > _SENSING_NS:
                self._silence(source)
        return self.received != received

    def _write(self, source, found):
        for arrived, message in found:
            if message.status == ACTIVE_SENSING:
                source.sensed = True
                continue
            self.received += 1
            if (meant := self._lane.meaning(*message)) is not None:
                source.held.take(*meant)
                self._lane.push(self._clock.acts_at(arrived), *meant)

    def _silence(self, source):
        source.sensed = False
        self.sensing_timeouts += 1
        self.news.append(f"{source.name} has fallen silent: cable?{_ended(self._let_go(source))}")

    def _let_go(self, source):
        others = [other.held for other in self._sources if other is not source]
        keys = len(source.held.keys)
        now = self._clock.frame()
        for message in source.held.release(others):
            self._lane.push(now, *message)
        return keys


def _ended(keys):
    return f"; the {keys} notes it held end" if keys > 1 else "; the note it held ends" if keys else ""
