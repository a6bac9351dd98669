"""The 800 modes of the banks of filters: partials of six open strings each twice, as in two polarizations.

Only their number matters to what they cost; frequencies, decays and gains make them sound like plucked strings.
"""

from .piece import OPEN_KEYS, frequency

COUNT = 800
HIGHEST_HZ = 11000.0
INHARMONICITY = 2e-5  # of the order of a nylon string's; an estimate
DETUNED = 1.001  # the second polarization


def modes():
    """The 800 lowest: list of (frequency [Hz], time of decay by 60 dB [s], gain)."""
    found = []
    for key in OPEN_KEYS:
        for number in range(1, 200):
            one = number * frequency(key) * (1.0 + INHARMONICITY * number**2) ** 0.5
            for hz in (one, one * DETUNED):
                if hz < HIGHEST_HZ:
                    found.append((hz, 5.0 / (1.0 + hz / 700.0), 1.0 / number))
    return sorted(found)[:COUNT]
