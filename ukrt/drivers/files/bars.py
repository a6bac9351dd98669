"""The bars of a piece: its time signatures enter, bars with their times leave, and bars of times.

Bars are numbered from 1 through the whole file. Without a time signature there are four quarter notes to a bar
(RP-001). A time signature begins a new bar, and so does each sequence of format 2: where it stands within a bar, that
one is cut short. A bar's beats are those of the lower number of its signature. SMPTE divisions know no beats: their
bars are those of 120 quarter notes a minute.
"""

import bisect
import math
from dataclasses import dataclass
from fractions import Fraction

from ukrt.drivers.files.tempo_map import TempoMap


@dataclass(frozen=True)
class Sequence:
    """Tracks that sound together.

    Attributes
    ----------
    start_s : float [s]
        Where it begins in the piece.
    clock : TempoMap
    end_tick : int
    signatures : tuple of (tick, numerator, denominator)
    keys : tuple of (tick, fifths)
        Key signatures: sharps, or flats where negative.
    """

    start_s: float
    clock: TempoMap
    end_tick: int
    signatures: tuple = ()
    keys: tuple = ()


@dataclass(frozen=True)
class Bar:
    """One bar.

    Attributes
    ----------
    number : int
        From 1.
    start_s, end_s : float [s]
        In the piece; the last bar's end may lie beyond the piece's.
    numerator, denominator : int
        Of its time signature.
    quarters : Fraction
        Its length, less than the signature's where it is cut short.
    quarter_us : int [us]
        Duration of a quarter note at its beginning.
    fifths : int
        Of its key signature.
    """

    number: int
    start_s: float
    end_s: float
    numerator: int
    denominator: int
    quarters: Fraction
    quarter_us: int
    fifths: int


@dataclass(frozen=True)
class _Span:
    """Bars of one signature: the first one's number, their number, and where they are in their sequence."""

    first: int
    count: int
    start: int  # ticks
    end: Fraction  # ticks, where the next span begins; of the last one that of its last bar
    length: Fraction  # ticks of a whole bar
    numerator: int
    denominator: int
    sequence: Sequence

    def seconds(self, tick):
        return self.sequence.start_s + self.sequence.clock.seconds(tick)


class Bars:
    """The bars of a piece.

    Parameters
    ----------
    sequences : list of Sequence
        One after another.
    """

    def __init__(self, sequences):
        self.count = 0  # bars there are
        self._spans = []
        sequences = [sequence for sequence in sequences if sequence.end_tick > 0] or sequences[:1]
        for sequence in sequences:
            self._add(sequence, is_last=sequence is sequences[-1])
        self._firsts = [span.first for span in self._spans]
        self._starts = [span.seconds(span.start) for span in self._spans]

    def _add(self, sequence, is_last):
        end_tick = max(sequence.end_tick, 1)  # there is one bar at least
        changes = {0: (4, 4)} | {tick: rest for tick, *rest in sorted(sequence.signatures, key=lambda s: s[0])}
        ticks = [tick for tick in sorted(changes) if tick < end_tick]
        for tick, following in zip(ticks, [*ticks[1:], end_tick], strict=True):
            numerator, denominator = changes[tick]
            length = Fraction(sequence.clock.ticks_per_quarter) * 4 * numerator / denominator
            count = math.ceil((following - tick) / length)
            end = tick + count * length if is_last and following == end_tick else Fraction(following)
            span = _Span(self.count + 1, count, tick, end, length, numerator, denominator, sequence)
            self._spans.append(span)
            self.count += count

    def seconds(self, number, beat=1.0):
        """Time [s] of beat ``beat`` (from 1) of bar ``number``; None where there is no such bar or beat.

        The bar after the last one exists in its first beat: the end of the last bar.
        """
        if not 1 <= number <= self.count + 1 or not self._spans:
            return None
        span = self._spans[bisect.bisect_right(self._firsts, number) - 1]
        if number == self.count + 1:
            return span.seconds(span.end) if beat == 1.0 else None
        tick = span.start + (number - span.first) * span.length
        shift = Fraction(beat - 1.0) * span.length / span.numerator
        if not 0 <= shift < min(span.length, span.end - tick):
            return None
        return span.seconds(tick + shift)

    def beats(self, number):
        """Beats of bar ``number`` (int)."""
        return self._spans[bisect.bisect_right(self._firsts, number) - 1].numerator

    def place(self, seconds):
        """Bar (from 1) of a time [s], and how many quarter notes after its beginning it lies (float); times after the
        last bar count from its beginning."""
        span = self._spans[max(bisect.bisect_right(self._starts, seconds) - 1, 0)]
        tick = span.sequence.clock.tick(seconds - span.sequence.start_s) - span.start
        k = min(max(int(tick // span.length), 0), span.count - 1)
        return span.first + k, float(tick - k * span.length) / float(span.sequence.clock.ticks_per_quarter)

    def bar(self, number):
        """Bar ``number``, from 1 to ``count``."""
        span = self._spans[bisect.bisect_right(self._firsts, number) - 1]
        clock = span.sequence.clock
        start = span.start + (number - span.first) * span.length
        end = min(start + span.length, span.end)
        tempo = clock.tempos[bisect.bisect_right(clock.tempos, (start, math.inf)) - 1][1]
        keys = [fifths for tick, fifths in span.sequence.keys if tick <= start]
        return Bar(
            number,
            span.seconds(start),
            span.seconds(end),
            span.numerator,
            span.denominator,
            Fraction(end - start) / Fraction(clock.ticks_per_quarter),
            tempo,
            keys[-1] if keys else 0,
        )
