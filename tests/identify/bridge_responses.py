"""Responses of a bridge in closed form: modes enter, impulse responses and admittances leave. Nothing here comes from
the package's own synthesis or identification."""

import dataclasses

import numpy as np

from ukrt.identify.measurement import PATHS, Measurement
from ukrt.model.presets import load_preset

RATE, SECONDS = 48_000, 1.0
THREE = ("bass-bass", "bass-treble", "treble-treble")


@dataclasses.dataclass(frozen=True)
class Modes:
    """Frequencies [Hz], damping ratios, masses [kg] (n,) and shapes (n, 2) at the bass and at the treble end."""

    hz: np.ndarray
    zeta: np.ndarray
    mass: np.ndarray
    shapes: np.ndarray

    @property
    def half_widths_hz(self):
        """Half of each mode's half-power bandwidth."""
        return self.zeta * self.hz

    def below(self, hz):
        return Modes(*(values[self.hz < hz] for values in (self.hz, self.zeta, self.mass, self.shapes)))


def table_i():
    """Table I of the paper, with the shapes of the preset `paper`."""
    body = load_preset("paper").body
    shapes = np.array([body.shapes_bass, body.shapes_treble]).T
    return Modes(*map(np.array, (body.frequencies_hz, body.damping_ratios, body.modal_masses)), shapes)


def sixty_modes(seed, top_hz=3000.0):
    """Table I and 50 random modes from 900 Hz to ``top_hz``, one every 42 Hz as in a guitar's board, back and air
    (neighbours keep apart a little, as coupled modes do); damping 0.5 to 2 %, masses 0.1 to 2 kg; an estimate."""
    known, rng = table_i(), np.random.default_rng(seed)
    edges = np.linspace(900.0, top_hz, 51)
    hz = edges[:-1] + rng.uniform(0.1, 0.9, 50) * np.diff(edges)
    zeta, mass = rng.uniform(0.005, 0.02, 50), np.exp(rng.uniform(np.log(0.1), np.log(2.0), 50))
    shapes = rng.standard_normal((50, 2))
    shapes /= np.take_along_axis(shapes, np.argmax(np.abs(shapes), axis=1)[:, None], axis=1)
    new = (hz, zeta, mass, shapes)
    old = (known.hz, known.zeta, known.mass, known.shapes)
    return Modes(*(np.concatenate(pair) for pair in zip(old, new, strict=True)))


def impulse_responses(modes, quantity="velocity", rate=RATE, seconds=SECONDS, phase=0.0):
    """Sampled responses to 1 N s: ndarray (samples, 2 driven ends, 2 ends), without the pulse at t = 0 that an
    acceleration has; ``phase`` [rad] turns every residue, which makes the modes complex."""
    t = np.arange(int(round(rate * seconds)))[:, None] / rate
    omega = 2.0 * np.pi * modes.hz
    sigma, damped = modes.zeta * omega, omega * np.sqrt(1.0 - modes.zeta**2)
    if quantity == "displacement":
        motion = np.sin(damped * t + phase) / damped
    elif quantity == "velocity":
        motion = np.cos(damped * t + phase) - sigma / damped * np.sin(damped * t + phase)
    else:
        motion = (sigma**2 - damped**2) / damped * np.sin(damped * t + phase) - 2 * sigma * np.cos(damped * t + phase)
    motion *= np.exp(-sigma * t) / modes.mass
    return np.einsum("tn,ni,nj->tij", motion, modes.shapes, modes.shapes)


def admittance(modes, frequencies, drive, response):
    """Velocity at one place over the force at another: ndarray (frequencies,) complex [m/s/N]; places from 0 (bass)
    to 1 (treble)."""
    s = 2j * np.pi * np.asarray(frequencies)[:, None]
    omega = 2.0 * np.pi * modes.hz
    at_drive, at_response = ((1.0 - x) * modes.shapes[:, 0] + x * modes.shapes[:, 1] for x in (drive, response))
    return np.sum(s * at_drive * at_response / modes.mass / (s**2 + 2 * modes.zeta * omega * s + omega**2), axis=1)


def add_noise(responses, rate, decibels, seed):
    """White noise, ``decibels`` below the rms of each response's first second."""
    rms = np.sqrt(np.mean(responses[:rate] ** 2, axis=0))
    return responses + np.random.default_rng(seed).standard_normal(responses.shape) * rms * 10 ** (-decibels / 20)


def measure(modes, seed=0, paths=THREE, decibels=40.0, quantity="velocity", rate=RATE, seconds=SECONDS):
    """A `Measurement` of these modes."""
    whole = add_noise(impulse_responses(modes, quantity, rate, seconds), rate, decibels, seed)
    return as_measurement(whole, paths, quantity, rate)


def as_measurement(whole, paths=THREE, quantity="velocity", rate=RATE):
    """Responses (samples, 2, 2) as a `Measurement` of some paths."""
    columns = [whole[:, drive, response] for drive, response in (PATHS[path] for path in paths)]
    return Measurement(np.stack(columns, axis=1), float(rate), tuple(paths), quantity)


def pair_modes(found_hz, modes):
    """Index of the identified mode for each true one, -1 where none lies within half its bandwidth: (n,), the nearest
    pairs first, each once."""
    distance = np.abs(found_hz - modes.hz[:, None]) / modes.half_widths_hz[:, None]
    partner = np.full(len(modes.hz), -1)
    for at in np.argsort(distance, axis=None):
        true, found = np.unravel_index(at, distance.shape)
        if distance[true, found] > 1.0:
            break
        if partner[true] < 0 and found not in partner:
            partner[true] = found
    return partner


def errors(found, modes):
    """Relative errors of frequency, damping and mass of each true mode: three (n,), NaN where none is found."""
    partner = pair_modes(found.frequencies_hz, modes)
    pairs = (
        (found.frequencies_hz, modes.hz),
        (found.damping_ratios, modes.zeta),
        (found.modal_masses, modes.mass),
    )
    return tuple(np.where(partner < 0, np.nan, own[partner] / true - 1.0) for own, true in pairs)
