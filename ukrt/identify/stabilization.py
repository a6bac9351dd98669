"""Which poles are modes: those of many model orders enter, tracks of poles that repeat from order to order leave.

A pole belongs to the track whose last pole it repeats, in frequency, damping and shape (MAC), within the tolerances
below. A track is stable when it has a pole in at least half of the orders after its first, and in at least a quarter of
all. What the noise or a filter puts into a model moves with the order and makes only short tracks.
"""

import dataclasses

import numpy as np

FREQUENCY_TOLERANCE = 0.005
DAMPING_TOLERANCE = 0.15  # larger than customary (0.05): with many modes damping settles late, long tracks decide
LEAST_MAC = 0.9
GAP = 3  # orders after which a track that was not continued ends
SHARE_OF_LIFE, SHARE_OF_ALL = 0.5, 0.25
MOST_DAMPING = (
    0.1  # guitars' body modes have 0.3 to 5 % (estimate from published tables); beyond this lie filters' poles
)
SAME_MODE = 0.25  # of the half-power bandwidth: two tracks nearer than this are one mode


@dataclasses.dataclass
class Track:
    """A pole through the orders: ``orders`` (indices into the sweep), ``poles`` [1/s] and ``shapes``, one each."""

    orders: list
    poles: list
    shapes: list

    def at(self, order):
        """The pole at an index of the sweep, else the median one."""
        return self.poles[self.orders.index(order)] if order in self.orders else self.median

    @property
    def median(self):
        """Median over orders (complex) [1/s]."""
        return complex(np.median(np.real(self.poles)), np.median(np.imag(self.poles)))

    @property
    def frequency_hz(self):
        """Undamped natural frequency, median [Hz]."""
        return abs(self.median) / (2.0 * np.pi)

    @property
    def damping_ratio(self):
        """Damping ratio, median [1]."""
        return -self.median.real / abs(self.median)


def mac(one, other):
    """Modal assurance criterion between shapes (..., n) and (..., n): |a* b|^2 / (a* a)(b* b), 0 to 1."""
    product = np.abs(np.sum(np.conj(one) * other, axis=-1)) ** 2
    return product / (np.sum(np.abs(one) ** 2, axis=-1) * np.sum(np.abs(other) ** 2, axis=-1))


def track_poles(sweep):
    """Follow poles from order to order.

    Parameters
    ----------
    sweep : list of Poles
        By rising order.

    Returns
    -------
    list of Track
        All, by frequency.
    """
    tracks = []
    for index, found in enumerate(sweep):
        legal = (found.damping_ratios > 0.0) & (found.damping_ratios < MOST_DAMPING)
        poles, shapes = found.values[legal], found.shapes[legal]
        open_tracks = [track for track in tracks if index - track.orders[-1] <= GAP]
        taken = set()
        for track, n in _pairs(open_tracks, poles, shapes):
            track.orders.append(index)
            track.poles.append(poles[n])
            track.shapes.append(shapes[n])
            taken.add(n)
        tracks += [Track([index], [poles[n]], [shapes[n]]) for n in range(len(poles)) if n not in taken]
    return sorted(tracks, key=lambda track: track.frequency_hz)


def stable_tracks(tracks, count):
    """The tracks that are stable over ``count`` orders, each mode once."""
    long = [
        track
        for track in tracks
        if len(track.orders) >= max(SHARE_OF_LIFE * (count - track.orders[0]), SHARE_OF_ALL * count)
    ]
    return distinct(long)


def distinct(tracks):
    """Of tracks that follow the same mode the longest only, by frequency."""
    kept = []
    for track in sorted(tracks, key=lambda one: -len(one.orders)):
        if not any(_same_mode(track, other) for other in kept):
            kept.append(track)
    return sorted(kept, key=lambda one: one.frequency_hz)


def _same_mode(one, other):
    near = 2.0 * SAME_MODE * max(one.damping_ratio * one.frequency_hz, other.damping_ratio * other.frequency_hz)
    return abs(one.frequency_hz - other.frequency_hz) < near and mac(one.shapes[-1], other.shapes[-1]) > LEAST_MAC


def _pairs(tracks, poles, shapes):
    """Pairs (track, index of its next pole), the nearest first, each once."""
    if not tracks or not len(poles):
        return []
    last = np.array([track.poles[-1] for track in tracks])[:, None]
    size, damping = np.abs(last), -last.real / np.abs(last)
    off_frequency = np.abs(np.abs(poles) / size - 1.0) / FREQUENCY_TOLERANCE
    off_damping = np.abs(-poles.real / np.abs(poles) / damping - 1.0) / DAMPING_TOLERANCE
    alike = mac(np.array([track.shapes[-1] for track in tracks])[:, None], shapes[None])
    repeats = np.argwhere((off_frequency < 1.0) & (off_damping < 1.0) & (alike > LEAST_MAC))
    distance = off_frequency + off_damping
    pairs, used = [], (set(), set())
    for t, n in sorted(repeats.tolist(), key=lambda pair: distance[tuple(pair)]):
        if t not in used[0] and n not in used[1]:
            pairs.append((tracks[t], n))
            used[0].add(t)
            used[1].add(n)
    return pairs
