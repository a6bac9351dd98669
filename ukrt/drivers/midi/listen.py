"""Which knob a player has just moved: messages enter, the one source that moved farthest leaves once it rests.

Others may chatter meanwhile (a worn potentiometer, a lamp's dimmer in a pedal's cable): what sways by a few values is
taken for that.
"""

from dataclasses import dataclass

from ukrt.drivers.midi.mapping import BEND, PRESSURE
from ukrt.engine.controller_names import NO_KNOBS

SETTLE_SECONDS = 0.7  # without a message of it, a gesture is over (choice: slower than anybody turns a knob in steps)
CHATTER = 8  # values: what has moved less and came more than once is no gesture (choice)


@dataclass
class Heard:
    """A source that has been moved.

    Attributes
    ----------
    source : str
        As `ukrt.drivers.midi.mapping.Mapped` names it.
    channel : int
        1 to 16.
    low, high : int
        Its lowest and highest value.
    count : int
        Of its messages.
    last : float [s]
        When the last one came.
    """

    source: str
    channel: int
    low: int
    high: int
    count: int = 0
    last: float = 0.0

    @property
    def counts(self):
        """Whether this is a gesture and no chatter; a button may send one value alone."""
        return self.count == 1 or self.high - self.low >= CHATTER

    def __str__(self):
        span = f"value {self.low}" if self.low == self.high else f"{self.low} to {self.high}"
        return f"{self.source} of channel {self.channel}, {span}"


class Listener:
    """Listens for one gesture after another.

    Attributes
    ----------
    notes_channel : int
        On which the last note came, 1 to 16; 0 before the first one.
    """

    def __init__(self):
        self.notes_channel = 0
        self.restart()

    def restart(self):
        """Forget what was moved, but not where notes came."""
        self._heard = {}

    def take(self, word, now):
        """A message (status << 16 | data1 << 8 | data2) that has come by the time ``now`` [s]."""
        kind, channel = (word >> 16) & 0xF0, ((word >> 16) & 0x0F) + 1
        first, second = (word >> 8) & 0x7F, word & 0x7F
        if kind == 0x90 and second:
            self.notes_channel = channel
        elif kind == 0xB0 and first not in NO_KNOBS:
            self._note(f"CC {first}", channel, second, now)
        elif kind == 0xD0:
            self._note(PRESSURE, channel, first, now)
        elif kind == 0xE0:
            self._note(BEND, channel, second, now)

    def _note(self, source, channel, value, now):
        one = self._heard.setdefault((channel, source), Heard(source, channel, value, value))
        one.low, one.high = min(one.low, value), max(one.high, value)
        one.count, one.last = one.count + 1, now

    def gesture(self, now):
        """What was moved farthest and has come to rest (Heard), None as long as there is nothing."""
        moved = [one for one in self._heard.values() if one.counts]
        if not moved:
            return None
        best = max(moved, key=lambda one: (one.high - one.low, one.count))
        return best if now - best.last > SETTLE_SECONDS else None
