"""The fit as a picture: measured and reconstructed responses over time and frequency, as Fig. 2 of the paper, and the
stabilisation diagram."""

import io

import numpy as np

from .measurement import UNITS

SHOWN_SECONDS = 0.15  # of the impulse responses, as in the paper's Fig. 2
MEASURED, MADE = "tab:green", "tab:red"  # as there


def draw_fit(found, quantity):
    """The fit of an identification.

    Parameters
    ----------
    found : ukrt.identify.Identification
    quantity : str
        For the axes' units.

    Returns
    -------
    bytes
        A PNG file.
    """
    from matplotlib.figure import Figure

    rows = len(found.paths)
    figure = Figure(figsize=(12.0, 2.6 * rows + 4.0), layout="constrained")
    grid = figure.add_gridspec(rows + 1, 2, height_ratios=[2.6] * rows + [4.0], width_ratios=[1.0, 1.6])
    made = found.responses()
    for n, path in enumerate(found.paths):
        time, frequency = figure.add_subplot(grid[n, 0]), figure.add_subplot(grid[n, 1])
        _draw_path(time, frequency, found, n, made)
        time.set(title=f"{path}, in the band", ylabel=f"h / ({UNITS[quantity]} / N s)")
        frequency.set(
            title=f"{path}: {found.fits[path]:.1f} dB left unexplained", ylabel=f"|H| / ({UNITS[quantity]} / N)"
        )
    frequency.legend(loc="lower right", fontsize="small")
    _draw_stability(figure.add_subplot(grid[rows, :]), found)
    return as_png(figure)


def as_png(figure):
    """A matplotlib figure as the bytes of a PNG file, the same for the same figure."""
    file = io.BytesIO()
    figure.savefig(file, format="png", metadata={"Software": None})
    return file.getvalue()


def _draw_path(time, frequency, found, n, made):
    band = found.band
    for values, color, width, words in (
        (band.values, MEASURED, 2.0, "measured"),
        (made, MADE, 1.0, "reconstructed from the modes"),
    ):
        times, response = _impulse_response(band.frequencies, values[:, n])
        shown = times <= SHOWN_SECONDS
        time.plot(times[shown], response[shown], color=color, lw=width)
        frequency.semilogy(band.frequencies, np.abs(values[:, n]), color=color, lw=width, label=words)
    for hertz in found.frequencies_hz:
        frequency.axvline(hertz, color="gray", ls=":", lw=1.0)
    time.set(xlabel="time / s", xlim=(0.0, SHOWN_SECONDS))
    frequency.set(xlabel="frequency / Hz", xlim=(0.0, band.frequencies[-1]))
    for panel in (time, frequency):
        panel.grid(alpha=0.3)


def _draw_stability(panel, found):
    """Every pole of every order, those of the modes marked, over the sum of the responses' size."""
    high = found.band.frequencies[-1]
    for poles in found.sweep:
        seen = (poles.frequencies_hz <= high) & (poles.damping_ratios > 0.0)
        panel.plot(poles.frequencies_hz[seen], np.full(seen.sum(), poles.order), "+", color="0.75", ms=5)
    for track in found.modes:
        orders = [found.sweep[index].order for index in track.orders]
        panel.plot(np.abs(track.poles) / (2.0 * np.pi), orders, "o", color=MADE, ms=2.5)
        panel.axvline(track.frequency_hz, color="gray", ls=":", lw=1.0)
    behind = panel.twinx()
    behind.semilogy(found.band.frequencies, np.sum(np.abs(found.band.values), axis=1), color=MEASURED, alpha=0.5)
    behind.set_yticks([])
    panel.set(
        title="stabilisation: poles of each model order (+), those that repeat and were taken as modes (o)",
        xlabel="frequency / Hz",
        ylabel="model order",
        xlim=(0.0, high),
    )


def _impulse_response(frequencies, values):
    """The band's part of an impulse response: times (n,) [s] and values (n,) [unit per N s]."""
    step = (frequencies[-1] - frequencies[0]) / (len(frequencies) - 1)
    whole = np.zeros(int(round(frequencies[-1] / step)) + 2, complex)
    whole[np.rint(frequencies / step).astype(int)] = values
    count = 2 * (len(whole) - 1)
    return np.arange(count) / (count * step), np.fft.irfft(whole, count) * count * step
