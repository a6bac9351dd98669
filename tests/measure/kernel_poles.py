"""Poles of a linear discrete system from its own motion: a step function or records enter, poles near guesses leave.

The system is disturbed, then left alone: no forcing during the record. All it does is a sum of exponentials, so the
only errors are round-off and what the band filter lets through (190 dB down): no matrix of the system is ever formed.
"""

import numpy as np

from .pencil import pencil, subband

STOP_DB = 190.0
RANK_TOLERANCE = 1e-10  # of the largest singular value: above round-off, below anything that matters
FAINT = 1e-9  # of the loudest channel or component: round-off


def poles_from_records(records, sample_rate, guesses, half_width_hz=60.0, decay_guesses=None, return_all=False):
    """The pole nearest to each guess [Hz] (and, where given, decay guess [1/s]).

    Parameters
    ----------
    records : ndarray (k, channels)
        Free motion from sample 0 on, several seconds of it, no noise. Channels are scaled to the same norm; one
        fainter than 1e-9 of the loudest is taken for round-off. Records of several runs may stand side by side.
    guesses : sequence of float [Hz]
    half_width_hz : float [Hz]
        Band analysed round a guess. Widen it (100 or more) for decay rates above half_width_hz.
    return_all : bool
        Also return, per guess, every pole in its band.

    Returns
    -------
    ndarray (guesses, 2): frequency [Hz] and decay rate [1/s] of exp(s k / sample_rate); with return_all a list of
    ndarrays (n, 2) sorted by frequency as well.
    """
    records = np.asarray(records, float)
    records = records[:, None] if records.ndim == 1 else records
    scale = np.linalg.norm(records, axis=0)
    if not scale.max() > 0.0 or not np.isfinite(scale.max()):
        raise ValueError("every channel of the record is zero, or one is not finite")
    loud = scale > FAINT * scale.max()
    records = records[:, loud] / scale[loud]
    chosen, everything = [], []
    for number, guess in enumerate(guesses):
        band, rate, _ = subband(records, sample_rate, guess, half_width_hz, STOP_DB)
        z, amplitudes = pencil(band, tolerance=RANK_TOLERANCE, largest_order=120)
        size = np.linalg.norm(amplitudes, axis=1)
        roots = np.log(z) * rate
        found = np.stack([guess + roots.imag / (2.0 * np.pi), -roots.real], axis=1)
        found = found[(np.abs(found[:, 0] - guess) <= half_width_hz) & (size > FAINT * size.max())]
        if len(found) == 0:
            raise ValueError(f"no pole within {guess} +- {half_width_hz} Hz")
        distance = np.abs(2.0 * np.pi * (found[:, 0] - guess))
        if decay_guesses is not None:
            distance = np.hypot(distance, found[:, 1] - decay_guesses[number])
        chosen.append(found[np.argmin(distance)])
        everything.append(found[np.argsort(found[:, 0])])
    return (np.array(chosen), everything) if return_all else np.array(chosen)


def poles_from_steps(step, read, n_steps, sample_rate, guesses, **options):
    """Step a system n_steps times, record read() -> (channels,) after each, and find its poles near the guesses.

    step : callable without arguments that advances the already disturbed, unforced system by one sample.
    Options are those of `poles_from_records`.
    """
    first = np.atleast_1d(np.asarray(read(), float))
    records = np.empty((n_steps, first.size))
    for k in range(n_steps):
        step()
        records[k] = read()
    return poles_from_records(records, sample_rate, guesses, **options)
