"""Turns ticks into seconds and back: the tempo changes of a sequence enter, times leave.

All sums are integers (ticks times microseconds) or fractions, so times are exact to the rounding of one division.
"""

import bisect
from fractions import Fraction

import numpy as np

DEFAULT_TEMPO = 500_000  # microseconds per quarter note, 120 a minute (RP-001)


class TempoMap:
    """Times of ticks: by tempo changes, or for SMPTE divisions by a fixed number of ticks per second.

    Parameters
    ----------
    tempos : list of (tick, microseconds per quarter note)
        Ignored with SMPTE divisions, whose ticks are parts of a second.
    ticks_per_quarter : int or None
    ticks_per_second : Fraction or None
        Of SMPTE divisions; one of the two is None.

    Attributes
    ----------
    ticks_per_quarter : int or Fraction
        With an SMPTE division, which knows no quarter notes, as at 120 of them a minute.
    tempos : list of (tick, microseconds per quarter note)
        In order, the first at tick 0.
    """

    def __init__(self, tempos, ticks_per_quarter, ticks_per_second):
        if ticks_per_second is not None:  # t = tick / rate, written as tempo / unit: numerators stay integer
            starts, rates = [0], [ticks_per_second.denominator]
            self._unit = ticks_per_second.numerator
            self.ticks_per_quarter = ticks_per_second * DEFAULT_TEMPO / 1_000_000
            self.tempos = [(0, DEFAULT_TEMPO)]
        else:
            starts, rates = [0], [DEFAULT_TEMPO]
            self._unit = ticks_per_quarter * 1_000_000
            for tick, tempo in sorted(tempos, key=lambda change: change[0]):
                if tick == starts[-1]:
                    rates[-1] = tempo
                else:
                    starts.append(tick)
                    rates.append(tempo)
            self.ticks_per_quarter = ticks_per_quarter
            self.tempos = list(zip(starts, rates, strict=True))
        sums = [0]
        for k in range(1, len(starts)):
            sums.append(sums[-1] + (starts[k] - starts[k - 1]) * rates[k - 1])
        self._starts, self._rates, self._sums = starts, rates, sums

    def seconds(self, tick):
        """Time of one tick, an int or a Fraction [s]."""
        k = bisect.bisect_right(self._starts, tick) - 1
        scaled = self._sums[k] + (tick - self._starts[k]) * self._rates[k]
        return float(scaled / self._unit) if isinstance(scaled, Fraction) else scaled / self._unit

    def seconds_array(self, ticks):
        """Times of ticks, an int64 array (n,), as float64 (n,) [s]."""
        starts = np.array(self._starts, dtype=np.int64)
        rates, sums = np.array(self._rates, dtype=np.float64), np.array(self._sums, dtype=np.float64)
        k = np.searchsorted(starts, ticks, side="right") - 1
        return (sums[k] + (ticks - starts[k]) * rates[k]) / self._unit

    def tick(self, seconds):
        """The tick, with its fraction, that falls on a time [s] (float); not negative."""
        scaled = max(seconds, 0.0) * self._unit
        k = bisect.bisect_right(self._sums, scaled) - 1
        return self._starts[k] + (scaled - self._sums[k]) / self._rates[k]
