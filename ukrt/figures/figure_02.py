"""Fig. 2: impulse response and transfer function of the body at the bass end of the bridge, from its modes."""

import numpy as np

from ..experiment.result import Quantity
from ..model.body import body_modes
from ..model.modes import receptance
from .cases import paper_guitar
from .data import FigureData, Number
from .spectra import highest_near

NUMBER = 2
TITLE = "Velocity at the bass end of the bridge: impulse response and transfer function"
_RELIABLE_HZ = 700.0  # the paper: up to here its identification is generally reliable


def make(run):
    """In closed form: no case is run."""
    body = paper_guitar().body
    times, frequencies = np.arange(0.0, 0.15, 1e-5), np.arange(50.0, 950.0, 0.1)
    response, transfer = impulse_response(body, times), transfer_function(body, frequencies)
    arrays = {
        "time": Quantity(times, "s"),
        "impulse_response": Quantity(response, "(m/s)/(N s)"),
        "frequency": Quantity(frequencies, "Hz"),
        "transfer_function": Quantity(transfer, "(m/s)/N"),
        "modal_frequencies": Quantity(np.array(body.frequencies_hz), "Hz"),
    }
    return FigureData(arrays, tuple(_numbers(body, response, frequencies, np.abs(transfer))))


def impulse_response(body, times):
    """Velocity at the bass end after a unit impulse there: sum of (phi^2 / m) d/dt [exp(-zeta w t) sin(w' t) / w'].

    Parameters
    ----------
    body : ukrt.model.parameters.Body
    times : ndarray (n,) [s]
        Not negative.

    Returns
    -------
    ndarray (n,) [(m/s)/(N s)]
    """
    modes, phi = body_modes(body), np.array(body.shapes_bass)
    decay = modes.zeta * modes.omega
    damped = np.sqrt(modes.omega**2 - decay**2)
    t = np.asarray(times)[:, None]
    waves = np.exp(-decay * t) * (np.cos(damped * t) - decay / damped * np.sin(damped * t))
    return waves @ (phi**2 / modes.mass)


def transfer_function(body, frequencies):
    """Mobility at the bass end: i w sum phi^2 / (m (w_n^2 + 2 i zeta w_n w - w^2)), ndarray complex [(m/s)/N]."""
    s = 2j * np.pi * np.asarray(frequencies)
    phi = np.array(body.shapes_bass)[None, :]
    return s * receptance(body_modes(body), phi, s)[..., 0, 0]


def _numbers(body, response, frequencies, level):
    start, top = float(response[0]), float(np.max(level))
    paper, note = "the axis has -20 to 20 and room beyond", "sum of phi^2 / m of Table I; the shapes phi are estimates"
    yield Number("impulse response: value at 0", start, "(m/s)/(N s)", paper, 20.0 <= start < 40.0, note)
    yield Number("transfer function: highest", top, "(m/s)/N", "within 0.01 to 1 (the axis)", 0.01 < top < 1.0)
    peaks = [highest_near(frequencies, level, hz, 0.02 * hz)[0] for hz in body.frequencies_hz]
    off = max(abs(peak / hz - 1.0) for peak, hz in zip(peaks, body.frequencies_hz, strict=True))
    what, note = "peaks: the farthest from its modal frequency", "neighbours and antiresonances pull them"
    yield Number(what, 100.0 * off, "%", "dotted lines at the peaks", off < 0.01, note)


def draw(data, figure):
    """Impulse response above, transfer function below."""
    from .style import GREY, RED, mark

    figure.set_size_inches(6.6, 4.6)
    values = {name: one.values for name, one in data.arrays.items()}
    upper, lower = figure.subplots(2, 1)
    upper.plot(values["time"], values["impulse_response"], color=RED, lw=0.9)
    upper.set(xlabel="Time  [s]", ylabel="h(t)  [(m/s)/(N s)]", xlim=(0, 0.15), ylim=(-30, 30))
    upper.set(xticks=(0, 0.05, 0.1, 0.15), yticks=(-20, 0, 20))
    mark(upper, "from Table I; shapes estimated")
    for hz in values["modal_frequencies"]:
        lower.axvline(hz, color=GREY, lw=0.7, ls=":")
    lower.semilogy(values["frequency"], np.abs(values["transfer_function"]), color=RED, lw=1.1)
    lower.axvspan(_RELIABLE_HZ, 950, color=GREY, alpha=0.12, lw=0)
    lower.text(_RELIABLE_HZ + 8, 1.2, "estimation less reliable", fontsize=7.5, color="0.35", va="center")
    lower.set(xlabel="Frequency  [Hz]", ylabel="| H(f) |  [(m/s)/N]", xlim=(50, 950), ylim=(1e-3, 2))
    lower.set_xticks(range(100, 1000, 100))
