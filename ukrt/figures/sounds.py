"""Records as sounds: forces and pressures at a solver's rate enter, samples at a sound card's rate leave."""

import numpy as np
import soxr

from ..units import db_to_gain

SOUND_HZ = 48000
PEAK_DB = -1.0  # dB re full scale: the loudest sample


def resampled(values, rate_hz):
    """Samples (n,) or (n, channels) at `SOUND_HZ`; ``rate_hz`` is a whole number of hertz."""
    return soxr.resample(np.asarray(values, float), round(rate_hz), SOUND_HZ, quality="VHQ")


def normal_gain(*sounds):
    """The one gain that brings the loudest of several sounds to `PEAK_DB` [1 over their unit]."""
    return float(db_to_gain(PEAK_DB) / max(np.max(np.abs(one)) for one in sounds))


def convolved(ends, response):
    """Sound pressure from the force at the two ends of the bridge (Eq. 51).

    Parameters
    ----------
    ends : ndarray (n, 2) [N]
        Bass and treble end.
    response : ndarray (m, 2, n_outputs) [Pa/N per sample]

    Returns
    -------
    ndarray (n + m - 1, n_outputs) [Pa]
    """
    length = len(ends) + len(response) - 1
    size = 2 ** int(np.ceil(np.log2(length)))
    spectra = np.fft.rfft(ends, size, axis=0)[:, :, None] * np.fft.rfft(response, size, axis=0)
    return np.fft.irfft(spectra.sum(axis=1), size, axis=0)[:length]
