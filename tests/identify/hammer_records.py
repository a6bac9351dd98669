"""Records of a hammer, synthetic: half-sine pulses enter a known impulse response, noise is added."""

import numpy as np

RATE = 48_000
COUNT = 12_000  # taps of the known response, a quarter of a second


def known_response(seed=0, last_hz=6000.0, flight=0.003):
    """Taps of 30 decaying modes to ``last_hz`` that begin ``flight`` [s] late, as sound does 1 m away, and are over
    when the record ends: ndarray (COUNT,) [Pa/N]."""
    rng, t = np.random.default_rng(seed), np.arange(COUNT)[:, None] / RATE - flight
    hz = np.geomspace(90.0, last_hz, 30)
    decay = rng.uniform(40.0, 120.0, 30) + 0.05 * hz
    modes = (
        np.exp(-decay * np.maximum(t, 0.0))
        * np.sin(2 * np.pi * hz * t + rng.uniform(0, 2 * np.pi, 30))
        * rng.uniform(0.5, 1.0, 30)
    )
    return np.sum(np.where(t >= 0.0, modes, 0.0), axis=1) * 1e-3


def half_sine(t, width, peak):
    """Force of a hit at time 0 that lasts ``width`` [s], as hammer tips of felt (2 ms) to steel (0.2 ms) make it."""
    return peak * np.where((t >= 0) & (t < width), np.sin(np.pi * np.clip(t, 0, width) / width), 0.0)


def record(taps, hits=8, width=4e-4, apart=0.35, noise=0.0, force_noise=0.0, seed=0, same=False):
    """Force (n,) [N] and pressure (n,) [Pa] of several hits, unevenly in time and force unless ``same``.

    ``noise`` and ``force_noise`` are standard deviations [Pa, N] of white noise.
    """
    rng = np.random.default_rng(seed)
    n = int(RATE * (0.1 + hits * apart + 0.1))
    t, force = np.arange(n) / RATE, np.zeros(n)
    for k in range(hits):
        begin = 0.1 + k * apart + (0.0 if same else rng.uniform(0.0, 0.02))
        force += half_sine(t - begin, width, 10.0 if same else rng.uniform(5.0, 20.0))
    size = 1 << int(np.ceil(np.log2(n + len(taps))))
    pressure = np.fft.irfft(np.fft.rfft(force, size) * np.fft.rfft(taps, size), size)[:n]
    return force + force_noise * rng.standard_normal(n), pressure + noise * rng.standard_normal(n)


def error_db(found, taps, low_hz, high_hz):
    """What is wrong with a response's transfer function in a band, over what is right [dB]."""
    size = 2 * COUNT
    hz = np.fft.rfftfreq(size, 1 / RATE)
    inside = (hz >= low_hz) & (hz <= high_hz)
    one, other = np.fft.rfft(found, size)[inside], np.fft.rfft(taps, size)[inside]
    return 10 * np.log10(np.sum(np.abs(one - other) ** 2) / np.sum(np.abs(other) ** 2))
