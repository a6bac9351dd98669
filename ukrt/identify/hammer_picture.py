"""A hammer measurement as a picture: impulse response, transfer function, coherence and the force's spectrum."""

import numpy as np

from .picture import as_png


def draw_response(found):
    """What hits at one or two places gave.

    Parameters
    ----------
    found : dict of str to ukrt.identify.hammer.Response
        By place.

    Returns
    -------
    bytes
        A PNG file.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.0 * len(found), 10.0), layout="constrained")
    for column, (place, one) in zip(figure.subplots(3, len(found), squeeze=False).T, found.items(), strict=True):
        _draw_place(column, one)
        column[0].set_title(f"{place}: {one.hits} hit{'s' if one.hits > 1 else ''}, force to {one.band_hz:.0f} Hz")
    return as_png(figure)


def _draw_place(panels, one):
    time, transfer, coherence = panels
    seen = one.frequencies > 10.0
    hertz = one.frequencies[seen]
    written = np.fft.rfft(one.taps, 2 * (len(one.frequencies) - 1), axis=0)[seen]
    for n in range(one.taps.shape[1]):
        time.plot(np.arange(len(one.taps)) / one.sample_rate, one.taps[:, n], lw=0.7)
        (line,) = transfer.loglog(hertz, np.abs(one.transfer[seen, n]), lw=0.7, alpha=0.5, label=f"{n + 1}: H1")
        transfer.loglog(hertz, np.abs(written[:, n]), lw=1.0, color=line.get_color(), label=f"{n + 1}: as written")
        if np.isfinite(one.coherence[seen, n]).any():
            coherence.semilogx(
                hertz, one.coherence[seen, n], lw=0.7, color=line.get_color(), label=f"coherence {n + 1}"
            )
    top = np.abs(written).max()
    transfer.set(ylim=(1e-5 * top, 3.0 * top))
    of_force = coherence.twinx()
    of_force.semilogx(hertz, one.force_db[seen], color="gray", lw=0.8)
    of_force.set(ylabel="force, energy spectrum / dB", ylim=(-80.0, 5.0))
    time.set(xlabel="time / s", ylabel="response to 1 N in one sample / (Pa/N)")
    transfer.set(xlabel="frequency / Hz", ylabel="|H| / (Pa/N)")
    coherence.set(xlabel="frequency / Hz", ylabel="coherence", ylim=(0.0, 1.02))
    for panel in (transfer, coherence):
        panel.axvline(one.band_hz, color="gray", ls=":")
    transfer.legend(fontsize="small")
