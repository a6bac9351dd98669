"""The hammer measurement: records of force and response enter, transfer functions, coherence and an impulse response
leave.

Hits are found by the peaks of the force. Each is cut out with its response, the force after its pulse is set to zero
(it is noise), both may be weighted by the same falling exponential, which is taken out of the result again (if
p = h * f, then exp(-at) p = (exp(-at) h) * (exp(-at) f), exactly). Over the hits the spectra are summed to the H1
estimate S_fp / S_ff, which noise in the response does not bias, and to the coherence |S_fp|^2 / (S_ff S_pp)
(J. S. Bendat, A. G. Piersol, Random Data, ch. 6). Beyond the band in which the force has energy H1 is noise over
nothing: there it is weighted by S_ff / (S_ff + eps) and let go to zero.
"""

import dataclasses

import numpy as np

from ..errors import MeasurementError
from .measurement import check_signal

HIT = 0.2  # of the largest force: what counts as a hit
REBOUND = 0.05  # of the hit's force: another peak of this size in its record is a second contact of the hammer
PULSE_END = 0.01  # of the hit's force
BEFORE = 0.002  # s that a record begins before its force does
LONGEST_PULSE = 0.02  # s from a hit's beginning to its peak
SOFT_END = 0.1  # of a response, faded out
BAND_DB = -30.0  # of the force's energy spectrum, to which it reaches: there 40 dB of dynamic leave 10 dB
EPSILON_DB = -45.0  # of its maximum: noise is kept from growing where the force has less
RINGING_PERIODS = 20  # of the band's edge, that a response cut off there rings on before time zero
OCTAVES = 0.5  # beyond the band's edge in which the response is let go to zero


@dataclasses.dataclass(frozen=True)
class Response:
    """An impulse response from one place of the hammer.

    Attributes
    ----------
    taps : ndarray (n, k)
        Response to a force of 1 N during one sample, in the response's unit per N.
    sample_rate : float [Hz]
    frequencies : ndarray (m,) [Hz]
    transfer : ndarray (m, k) complex [unit per N]
        H1, as estimated, not yet limited to the band.
    coherence : ndarray (m, k)
        NaN with one hit, which cannot tell noise from response.
    band_hz : float [Hz]
        To which the force has energy.
    force_db : ndarray (m,)
        The force's energy spectrum, over its maximum.
    hits : int
    left_out : int
        Peaks of the force that were not used: with a rebound, itself a rebound, too near to the next or to the end.
    """

    taps: np.ndarray
    sample_rate: float
    frequencies: np.ndarray
    transfer: np.ndarray
    coherence: np.ndarray
    band_hz: float
    force_db: np.ndarray
    hits: int
    left_out: int


def hammer_response(records, sample_rate, seconds, decay=None):
    """Impulse responses from records of hammer hits at one place.

    Parameters
    ----------
    records : list of (ndarray (n,) [N], ndarray (n, k), str)
        Force, responses and what the record is called.
    sample_rate : float [Hz]
    seconds : float [s]
        Of the impulse response.
    decay : float, optional [s]
        Time constant of the exponential window.

    Returns
    -------
    Response

    Raises
    ------
    MeasurementError
        Silence, overload, lengths that differ, no hit that can be used.
    """
    count = int(round(seconds * sample_rate))
    window = np.ones(count) if decay is None else np.exp(-np.arange(count) / (decay * sample_rate))
    forces, responses, left_out = [], [], 0
    for force, response, name in records:
        _check(force, response, name, count)
        begins, dropped = find_hits(force, sample_rate, count)
        left_out += dropped
        for begin in begins:
            forces.append(_force_alone(force[begin : begin + count], sample_rate) * window)
            responses.append((response[begin : begin + count] - _level(response, begin, sample_rate)) * window[:, None])
    if not forces:
        found = f"{left_out} hits that cannot be used" if left_out else "no force that stands out of its noise"
        raise MeasurementError(
            f"{records[0][2]} has {found}, but a hit needs {1e3 * BEFORE:g} ms before and {seconds:g} s after its "
            "beginning, without another or a rebound"
        )
    return _estimate(np.array(forces), np.array(responses), sample_rate, window, left_out)


def find_hits(force, sample_rate, count):
    """Where records of single hits begin.

    Parameters
    ----------
    force : ndarray (n,) [N]
    sample_rate : float [Hz]
    count : int
        Samples of a record.

    Returns
    -------
    begins : list of int
    left_out : int
        Hits with another one in their record, a rebound, or no room for it.
    """
    size = np.abs(force - np.median(force))
    noise = 6.0 * np.median(size) / 0.6745  # six standard deviations of the noise between hits
    gap, before = int(LONGEST_PULSE * sample_rate), int(BEFORE * sample_rate)
    begins, left_out, at = [], 0, 0
    for peak in _peaks(size, max(HIT * size.max(), noise), gap):
        pulse = np.flatnonzero(size[max(peak - gap, 0) : peak] < max(PULSE_END * size[peak], noise))
        begin = max(peak - gap, 0) + (pulse[-1] if len(pulse) else 0) - before
        after = size[_end_of_pulse(size, peak, noise) : max(begin, 0) + count]
        alone = not len(after) or after.max() < max(REBOUND * size[peak], noise)
        if begin < at or begin + count > len(force) or not alone:
            left_out += 1
        else:
            begins.append(int(begin))
        at = begin + count  # until then the response to this hit, used or not, rings
    return begins, left_out


def _peaks(size, least, gap):
    """Indices of peaks above ``least`` that are further apart than ``gap`` samples."""
    above = np.flatnonzero(size >= least)
    if not len(above):
        return []
    groups = np.split(above, np.flatnonzero(np.diff(above) > gap) + 1)
    return [group[np.argmax(size[group])] for group in groups]


def _end_of_pulse(size, peak, noise):
    """The first sample after ``peak`` at which the force has ended."""
    low = np.flatnonzero(size[peak:] < max(PULSE_END * size[peak], noise))
    return peak + (low[0] if len(low) else len(size) - peak)


def _check(force, response, name, count):
    for signal in (force[:, None], response):
        check_signal(signal, name)
    if len(force) != len(response):
        raise MeasurementError(
            f"{name}: the force has {len(force)} samples and the pressure {len(response)}, both must be equally long"
        )
    if len(force) < count:
        raise MeasurementError(
            f"{name} has {len(force)} samples, but the response alone needs {count}: record longer, lower --seconds"
        )


def _force_alone(force, sample_rate):
    """A record's force with its level before the hit taken out, and set softly to zero after its pulse."""
    before = int(BEFORE * sample_rate)
    force = force - np.mean(force[: max(before // 2, 1)])
    size = np.abs(force)
    peak = int(np.argmax(size))
    noise = 3.0 * np.std(force[: max(before // 2, 1)])
    end = _end_of_pulse(size, peak, noise)
    length = max(end - before, 8)  # of the pulse; the window is 1 for half as long again, falls for as long
    window = np.zeros(len(force))
    window[: end + length // 2] = 1.0
    fall = 0.5 + 0.5 * np.cos(np.pi * (np.arange(length) + 1) / (length + 1))
    room = window[end + length // 2 : end + length // 2 + length]
    room[:] = fall[: len(room)]
    return force * window


def _level(response, begin, sample_rate):
    """Mean of a response before the hit (k,): the microphone's offset."""
    first = max(begin - int(0.05 * sample_rate), 0)
    quiet = response[first : begin + int(BEFORE * sample_rate) // 2]
    return quiet.mean(axis=0) if len(quiet) else np.zeros(response.shape[1])


def _estimate(forces, responses, sample_rate, window, left_out):
    """H1, coherence and the limited impulse response of cut-out hits (hits, n) and (hits, n, k)."""
    count = forces.shape[1]
    force, response = np.fft.rfft(forces, 2 * count), np.fft.rfft(responses, 2 * count, axis=1)
    of_force = np.sum(np.abs(force) ** 2, axis=0)
    cross = np.sum(np.conj(force)[:, :, None] * response, axis=0)
    of_response = np.sum(np.abs(response) ** 2, axis=0)
    frequencies = np.fft.rfftfreq(2 * count, 1.0 / sample_rate)
    with np.errstate(divide="ignore", invalid="ignore"):
        transfer = np.where(of_force[:, None] > 0.0, cross / of_force[:, None], 0.0)
        coherence = np.abs(cross) ** 2 / (of_force[:, None] * of_response)
        force_db = 10.0 * np.log10(of_force / of_force.max())
    if len(forces) == 1:
        coherence = np.full_like(coherence, np.nan)
    below = np.flatnonzero(force_db < BAND_DB)
    band_hz = float(frequencies[below[0]] if len(below) else frequencies[-1])
    weight = of_force / (of_force + of_force.max() * 10.0 ** (EPSILON_DB / 10.0))
    limited = transfer * (weight * _let_go(frequencies, band_hz))[:, None]
    ringing = int(RINGING_PERIODS * sample_rate / band_hz)
    taps = _causal(np.fft.irfft(limited, 2 * count, axis=0), count, ringing) / window[:, None]
    fade = max(int(SOFT_END * count), 1)
    taps[-fade:] *= (0.5 + 0.5 * np.cos(np.pi * (np.arange(fade) + 1) / fade))[:, None]
    return Response(taps, sample_rate, frequencies, transfer, coherence, band_hz, force_db, len(forces), left_out)


def _let_go(frequencies, band_hz):
    """1 in the band, 0 from `OCTAVES` above it on, half a cosine over the logarithm of frequency between."""
    with np.errstate(divide="ignore"):
        octaves = np.log2(frequencies / band_hz)
    return 0.5 + 0.5 * np.cos(np.pi * np.clip(octaves / OCTAVES, 0.0, 1.0))


def _causal(circular, count, ringing):
    """The first ``count`` samples, with what rings before time zero folded behind it: as where impulse responses are
    resampled, this adds no delay and keeps the real part of the transfer function."""
    taps = circular[:count].copy()
    before = circular[-1 : -min(ringing, count) : -1]
    taps[1 : 1 + len(before)] += before
    return taps
