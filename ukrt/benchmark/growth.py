"""How the cost of a sample grows with what there is to compute: a guitar enters, costs and a straight line leave."""

import dataclasses
import time
from dataclasses import dataclass

import numpy as np

from ..engine.engine import Engine
from ..radiation.impulse_response import load_impulse_response
from .cases import G_MAJOR, OPEN, VELOCITY, chord_keys

RATE, BLOCK = 48000, 128
CONTACT_STEP = 0.004  # m between the contacts of a finger, as in the preset classical
SECONDS, REPETITIONS = 0.25, 9  # of sound in one measurement; the quickest of so many counts


@dataclass(frozen=True)
class Growth:
    """Cost against one quantity.

    Attributes
    ----------
    name, unit : str
        Of the quantity.
    amounts : ndarray (n,)
    cost_ns : ndarray (n,) [ns]
        For each sample.
    """

    name: str
    unit: str
    amounts: np.ndarray
    cost_ns: np.ndarray

    @property
    def line(self):
        """Slope and start [ns] of the line with the least squared distance."""
        return tuple(float(value) for value in np.polyfit(self.amounts, self.cost_ns, 1))

    @property
    def deviation(self):
        """Largest distance from that line, over the cost there."""
        slope, start = self.line
        return float(np.max(np.abs(slope * self.amounts + start - self.cost_ns) / self.cost_ns))


def measure_growth(guitar, progress=lambda: None):
    """Cost against each quantity, the others being as the guitar, 48 kHz and blocks of 128 frames have them.

    Parameters
    ----------
    guitar : ukrt.model.parameters.Guitar
    progress : callable
        Called after each measurement, of which there are `MEASUREMENTS`.

    Returns
    -------
    list of Growth
    """
    out = []
    for name, unit, amounts, engine_of in QUANTITIES:
        costs, counted = [], []
        for amount in amounts:
            engine, block, counts = engine_of(guitar, amount)
            costs.append(_cost(engine, block, OPEN if name == "strings" else G_MAJOR))
            counted.append(counts)
            engine.close()
            progress()
        out.append(Growth(name, unit, np.array(counted, dtype=float), np.array(costs)))
    return out


def _cost(engine, block, chord):
    """Least time of a sample [ns] while a chord rings, of which half the strings are stopped, or none."""
    out = np.zeros((block, engine.channels))
    n_blocks = max(1, int(SECONDS * RATE / block))
    least = np.inf
    for _ in range(REPETITIONS):
        for key in chord_keys(chord, engine.guitar):
            engine.send(engine.frame, 0x90, key, VELOCITY)
        start = time.perf_counter_ns()
        for _ in range(n_blocks):
            engine.process_into(out)
        least = min(least, time.perf_counter_ns() - start)
    return least / (n_blocks * block)


def _with_modes(guitar, bandwidth):
    basis = dataclasses.replace(guitar.basis, bandwidth_hz=float(bandwidth))
    engine = Engine(dataclasses.replace(guitar, basis=basis), float(RATE))
    return engine, BLOCK, engine.n_modes


def _with_strings(guitar, count):
    """All alike, so that one more is always as much more."""
    strings = (guitar.strings[len(guitar.strings) // 2],) * count
    return Engine(dataclasses.replace(guitar, strings=strings), float(RATE)), BLOCK, count


def _with_contacts(guitar, count):
    contacts = guitar.finger.contacts[:1] + tuple(
        dataclasses.replace(guitar.finger.contacts[0], offset=-CONTACT_STEP * n, rigid=False) for n in range(1, count)
    )
    finger = dataclasses.replace(guitar.finger, contacts=contacts)
    damper = dataclasses.replace(guitar.damper, places=guitar.damper.places[:1])
    return Engine(dataclasses.replace(guitar, finger=finger, damper=damper), float(RATE)), BLOCK, count


def _with_block(guitar, block):
    return Engine(guitar, float(RATE)), block, 1.0 / block


def _with_rate(guitar, rate):
    return Engine(guitar, float(rate)), BLOCK, rate / 1000.0


def _with_response(guitar, seconds):
    response = load_impulse_response(guitar.radiation.impulse_response, RATE)
    samples = np.zeros((int(round(seconds * RATE)), 2, 2))
    taps = min(len(samples), len(response.samples))
    samples[:taps] = response.samples[:taps]
    samples[-1] = 1e-9  # so that nothing at the end can be left out
    response = dataclasses.replace(response, samples=samples)
    return Engine(guitar, float(RATE), impulse_response=response), BLOCK, seconds


QUANTITIES = (
    ("modes", "", (2500, 5000, 7500, 10000, 15000, 20000), _with_modes),
    ("strings", "", tuple(range(1, 13)), _with_strings),
    ("contacts of a finger", "", (1, 2, 3, 4), _with_contacts),
    ("blocks, 1 / frames", "", (16, 32, 64, 128, 256, 1024), _with_block),
    ("sample rate", "kHz", (44100, 48000, 88200, 96000, 192000), _with_rate),
    ("impulse response", "s", (0.1, 0.25, 0.5, 1.0, 2.0, 4.0), _with_response),
)
MEASUREMENTS = sum(len(amounts) for _, _, amounts, _ in QUANTITIES)


def plot_growth(growths, path, words):
    """Draw each quantity's costs and line as a picture (PNG, PDF or SVG by the path's suffix).

    Parameters
    ----------
    growths : list of Growth
    path : str or os.PathLike
    words : str
        What stands above.
    """
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, panels = pyplot.subplots(2, 3, figsize=(11, 6), layout="constrained")
    for panel, growth in zip(panels.flat, growths, strict=True):
        slope, start = growth.line
        ends = np.array([0.0, growth.amounts.max()])
        panel.plot(ends, slope * ends + start, color="0.7")
        panel.plot(growth.amounts, growth.cost_ns, "o", color="tab:blue")
        panel.set_xlabel(f"{growth.name} [{growth.unit}]" if growth.unit else growth.name)
        panel.set_ylabel("ns for each sample")
        panel.set_ylim(bottom=0)
    figure.suptitle(words)
    figure.savefig(path)
    pyplot.close(figure)
