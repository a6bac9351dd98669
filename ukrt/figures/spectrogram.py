"""Spectrograms: samples enter; levels over time and frequency leave, and are drawn."""

import numpy as np

SPAN_DB = 80.0  # of the colours, below the strongest point


def spectrogram(values, rate_hz, window_s=0.08, hop_s=0.01, highest_hz=5000.0):
    """Amplitude over time and frequency: a lasting sinusoid of amplitude a has level 20 log10 a at its frequency.

    Parameters
    ----------
    values : ndarray (n,)
    rate_hz : float [Hz]
    window_s, hop_s : float [s]
        Length of the Hann windows and the time between them.
    highest_hz : float [Hz]
        What lies above is left out.

    Returns
    -------
    times : ndarray (n_times,) [s]
        Centres of the windows, from 0 to where they reach the record's end; what they lack before it counts as nil.
    frequencies : ndarray (n_bins,) [Hz]
    levels : ndarray (n_times, n_bins) [dB re 1 unit of ``values``]
    """
    n, hop = int(round(window_s * rate_hz)) // 2 * 2, int(round(hop_s * rate_hz))
    padded = np.concatenate([np.zeros(n // 2), values])
    frames = np.lib.stride_tricks.sliding_window_view(padded, n)[::hop]
    window = 0.5 - 0.5 * np.cos(2.0 * np.pi * np.arange(n) / n)
    frequencies = np.fft.rfftfreq(n, 1.0 / rate_hz)
    shown = frequencies <= highest_hz
    amplitudes = np.array([np.abs(np.fft.rfft(frame * window))[shown] for frame in frames]) * 2.0 / np.sum(window)
    levels = 20.0 * np.log10(np.maximum(amplitudes, np.finfo(float).tiny))
    return np.arange(len(frames)) * hop / rate_hz, frequencies[shown], levels


def top_of(*levels):
    """Where a scale of colours begins for these levels [dB]: a multiple of 5."""
    return 5.0 * np.ceil(max(np.max(one) for one in levels) / 5.0)


def draw_spectrogram(panel, times, frequencies, levels, top_db):
    """Draw levels (n_times, n_bins) as colours, `SPAN_DB` down from ``top_db``; returns what a colour bar needs."""
    image = panel.imshow(
        levels.T,
        origin="lower",
        aspect="auto",
        extent=(times[0], times[-1], frequencies[0] / 1e3, frequencies[-1] / 1e3),
        vmin=top_db - SPAN_DB,
        vmax=top_db,
        cmap="magma",
        interpolation="nearest",
    )
    panel.grid(False)
    panel.set_ylabel("Frequency [kHz]")
    return image
