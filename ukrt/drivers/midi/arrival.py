"""When a MIDI message arrived: RtMidi's time since the message before and the time of polling enter, a time leaves.

Polling adds a wait of up to its own interval, more on a busy machine. RtMidi's times have none, but begin anywhere and
lose their place where it drops a message. So they are added up, and the polls that found a message soonest say where
on the computer's clock they lie; a result that cannot be is replaced by the time of polling.
"""

from ukrt.drivers.midi.clock import EarliestLine

_PER_SECOND = 1e6  # RtMidi counts microseconds
_SLACK = 0.25e-3 * _PER_SECOND  # sums that lag by more, 16 times, have lost something: half the polls' interval
_EARLIEST = 50e-3 * _PER_SECOND  # before the poll: what would have waited longer has come at another time (choice)


class Arrivals:
    """The times of arrival of one input."""

    def __init__(self):
        self._line, self._sum = EarliestLine(), 0

    def at(self, since_last, polled_ns):
        """Time of arrival [ns], from 50 ms before ``polled_ns`` to ``polled_ns``.

        Parameters
        ----------
        since_last : float
            What RtMidi gave with the message [s].
        polled_ns : int
            After it was fetched, or the sums would seem to run ahead for long.
        """
        self._sum += max(round(since_last * _PER_SECOND), 0)
        self._line.see(polled_ns, self._sum, _PER_SECOND, _SLACK, _EARLIEST)
        return polled_ns - round(max(self._line.at(polled_ns) - self._sum, 0.0) / _PER_SECOND * 1e9)
