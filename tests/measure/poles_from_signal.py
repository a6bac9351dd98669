"""Frequency and decay of a partial, pitch of a note: an audio or state signal enters, hertz, 1/s and cents leave.

A sub-band of the signal is written as a sum of decaying exponentials (see `pencil`), so that a neighbour, a body mode
or a doublet is a component of its own instead of a bias.
"""

from typing import NamedTuple

import numpy as np

from .pencil import pencil, subband


class Component(NamedTuple):
    """One partial a exp(-d t) cos(2 pi f t + ..): f [Hz], d [1/s], a at t0 [u], energy over the window [u^2 s]."""

    frequency_hz: float
    decay_rate: float
    amplitude: float
    energy: float


def _window(signal, sample_rate, t0, t1):
    signal = np.asarray(signal, float)
    first, last = round(t0 * sample_rate), signal.shape[0] if t1 is None else round(t1 * sample_rate)
    if not 0 <= first < last <= signal.shape[0]:
        raise ValueError(f"window {t0} to {t1} s does not lie in a signal of {signal.shape[0] / sample_rate} s")
    return signal[first:last]


def fit_poles(signal, sample_rate, f_guess, bandwidth, t0=0.0, t1=None, order=None):
    """All components within f_guess +- bandwidth [Hz] over t0 to t1 [s], the one with the most energy first.

    signal : (k,) or (k, channels), channels sharing the poles. order : number of exponents in about twice that band;
    None lets the singular values decide (noise is recognised as such).
    """
    part = _window(signal, sample_rate, t0, t1)
    part = part if part.ndim == 2 else part[:, None]
    band, rate, gain = subband(part, sample_rate, f_guess, bandwidth)
    z, amplitudes = pencil(band, order)
    roots = np.log(z) * rate
    frequencies, decays = f_guess + roots.imag / (2.0 * np.pi), -roots.real
    size = 2.0 * np.linalg.norm(amplitudes, axis=1) / np.abs(gain(roots + 2j * np.pi * f_guess))
    time = (np.arange(256) + 0.5) / 256 * (part.shape[0] / sample_rate)
    energy = 0.5 * size**2 * np.mean(np.exp(-2.0 * decays * time[:, None]), axis=0) * (part.shape[0] / sample_rate)
    keep = np.abs(frequencies - f_guess) <= bandwidth
    rows = np.stack([frequencies, decays, size, energy], axis=1)[keep]
    return sorted((Component(*map(float, row)) for row in rows), key=lambda component: -component.energy)


def fit_pole(signal, sample_rate, f_guess, bandwidth, t0=0.0, t1=None, order=None):
    """(frequency_hz, decay_rate) of the component with the most energy; see `fit_poles` for all of them."""
    found = fit_poles(signal, sample_rate, f_guess, bandwidth, t0, t1, order)
    if not found:
        raise ValueError(f"nothing found within {f_guess} +- {bandwidth} Hz")
    return found[0].frequency_hz, found[0].decay_rate


def note_components(signal, sample_rate, f_target, t0=0.6, t1=3.2, reach_cents=100.0):
    """What is heard of a note's partial 1: components within reach_cents of f_target, the one with most energy first.

    Sample 0 of the signal is the string's release. Components below 1e-7 of the whole signal's energy between t0 and t1
    are left out: round-off or noise posing as a component.
    """
    found = fit_poles(signal, sample_rate, f_target, max(0.2 * f_target, 16.0), t0, t1)
    part = _window(signal, sample_rate, t0, t1)
    audible = 1e-7 * np.sum(part**2) / sample_rate
    near = [c for c in found if c.energy > audible and abs(cents_above(c, f_target)) <= reach_cents]
    if not near:
        raise ValueError(f"no component within {reach_cents:g} cents of {f_target:g} Hz between {t0} and {t1} s")
    return near


def cents_above(component, f_target):
    """How far a component lies above f_target [Hz], in cents."""
    return float(1200.0 * np.log2(component.frequency_hz / f_target))


def note_pitch_cents(signal, sample_rate, f_target, t0=0.6, t1=3.2, reach_cents=100.0):
    """Pitch of a note's partial 1 in cents above f_target; sample 0 of the signal is the string's release.

    Where several components lie within reach_cents (two polarizations, a body mode, another string in unison: what is
    heard as beating) it is the pitch of the one with the most energy between t0 and t1; their mean frequency would
    depend on the window.
    """
    return cents_above(note_components(signal, sample_rate, f_target, t0, t1, reach_cents)[0], f_target)
