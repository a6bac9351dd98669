"""Waveforms of both solvers side by side: the same case at several rates, all looked at at the same instants.

The reference is taken to the limit of its step (Richardson, its order being 2), so that what is left is the engine's.
Forces have a jump at the release and with it all of the basis up to its edge; seen through a window of 1 ms (Hann:
-6 dB at 1 kHz) they compare as they are heard.
"""

from dataclasses import dataclass, replace

import numpy as np

from ukrt.reference.solver import simulate as reference
from ukrt.simulate.on_engine import simulate as engine

COMMON_HZ = 48000.0  # the instants that all rates share
WINDOW_S = 1e-3


@dataclass(frozen=True)
class Waveforms:
    """Quantities at the common instants: dict of str to ndarray (n, columns); smoothed ones are called so."""

    arrays: dict
    rest: dict

    @classmethod
    def of(cls, result):
        rate = result.rate_hz
        every = int(round(rate / COMMON_HZ))
        arrays = {name: quantity.values[::every] for name, quantity in result.quantities.items() if name != "drift"}
        arrays |= {
            f"{name}, smoothed": smooth(result[name], rate)[::every]
            for name in ("bridge_force", "displacement")
            if name in arrays
        }
        rest = {name: result["tension"][0] if name == "tension" else 0.0 for name in arrays}
        return cls(arrays, rest)

    def difference(self, other):
        """Relative rms over time and columns of what differs from ``other``: dict of str to float.

        Of tensions it is relative to what they rise by.
        """
        out = {}
        for name, theirs in other.arrays.items():
            ours = self.arrays[name]
            n = min(len(ours), len(theirs))
            size = np.sqrt(np.mean(np.square(theirs[:n] - other.rest[name])))
            moves = size > 1e-12 * np.abs(theirs).max()
            out[name] = float(np.sqrt(np.mean(np.square(ours[:n] - theirs[:n]))) / size) if moves else 0.0
        return out


def smooth(values, rate):
    """Columns through a Hann window of `WINDOW_S`, only where it lies within the record."""
    window = np.hanning(int(round(WINDOW_S * rate)) + 1)
    return np.stack([np.convolve(column, window / window.sum(), "valid") for column in values.T], axis=1)


def reference_at(case, rate):
    """`Waveforms` of the reference at a step of 1 / rate."""
    return Waveforms.of(reference(replace(case, step=1.0 / rate)))


def engine_at(case, rate, residual=False):
    """`Waveforms` of the engine."""
    return Waveforms.of(engine(replace(case, sample_rate=rate), residual=residual))


def limit_of(coarse, fine):
    """What the reference tends to, from two runs of which one has half the step of the other."""
    arrays = {name: (4.0 * values - coarse.arrays[name]) / 3.0 for name, values in fine.arrays.items()}
    return Waveforms(arrays, fine.rest)


def orders(differences):
    """How differences (a list of dicts) fall from each to the next, the step being halved: dict of str to list."""
    names = differences[0]
    pairs = list(zip(differences[:-1], differences[1:], strict=True))
    return {name: [float(np.log2(a[name] / b[name])) if b[name] else np.inf for a, b in pairs] for name in names}
