"""From physics to numbers that a machine can step: here, and only here, the sample rate enters.

Enter a guitar, its intonation (tensions, fret places) and a sample rate; leave the flat arrays of an instance at rest:
exact modal flow of strings, body and fingers (Gautschi's trigonometric integrator), tables of what the basis cuts,
solver lanes.
"""

from dataclasses import replace

import numpy as np

from ukrt.engine import layout as at
from ukrt.engine.compiled import flow, refit_string, tune_string
from ukrt.errors import ParameterError
from ukrt.model.body import body_modes, bridge_ends
from ukrt.model.strings import REFERENCE_HZ, string_modes, string_modes_range

LINEAR = 1e200  # 4 L / ES of a string without tension modulation
MATCH = (0.33, 0.75)  # shares of the bandwidth where pseudo-modes are matched (chosen by measurement, see the README)
RATES = (44100.0, 192000.0)


def make_arrays():
    """The two arrays of an instance, zero: d float64 (D_SIZE,) and i int64 (I_SIZE,), on 64-byte boundaries."""
    return aligned(at.D_SIZE, np.float64), aligned(at.I_SIZE, np.int64)


def aligned(size, kind):
    """Zeros of ``size`` eight-byte numbers that start on a 64-byte boundary."""
    raw = np.zeros(size + 8, kind)
    skip = (-raw.ctypes.data % 64) // 8
    return raw[skip : skip + size]


def modal_flow(omega, zeta, dt):
    """Coefficients of the exact free motion q[k+1] = a q[k] + b q[k-1].

    Parameters
    ----------
    omega, zeta : ndarray (n,) [rad/s], [1]
    dt : float [s]

    Returns
    -------
    a, b : ndarray (n,) [1]
    """
    pairs = [flow(w, z, dt) for w, z in zip(omega, zeta, strict=True)]
    return tuple(np.array(pairs, float).reshape(-1, 2).T)


def check_rate(sample_rate, guitar):
    """Refuse a sample rate that the engine cannot run at, or that does not carry the basis."""
    low, high = RATES
    if not np.isfinite(sample_rate) or not low <= sample_rate <= high:
        raise ParameterError("sample_rate", sample_rate, f"it must be from {low:g} to {high:g} Hz")
    most = 0.46 * sample_rate
    if guitar.basis.bandwidth_hz > most:
        words = f"it must be at most {most:g} Hz (0.46 of the sample rate)"
        raise ParameterError("basis.bandwidth_hz", guitar.basis.bandwidth_hz, words)


def fill_instance(d, i, guitar, intonation, sample_rate, residual=1.0):
    """Write an instance at rest.

    Parameters
    ----------
    d, i : ndarray
        From `make_arrays`.
    guitar : ukrt.model.parameters.Guitar
    intonation : ukrt.model.intonation.Intonation
    sample_rate : float [Hz]
    residual : float [1]
        How much of the cut modes' receptance the pseudo-modes carry: 1, or, to compare with a solver that has the basis
        and no more, a number so small that it does not show. Above 0: the residual compliance is factored.

    Raises
    ------
    ParameterError
        A sample rate out of range, or more modes than an instance holds.
    """
    check_rate(sample_rate, guitar)
    d[:], i[:] = 0.0, 0
    i[at.H_STRINGS] = len(guitar.strings)

    i[at.H_FINGER], i[at.H_DAMPER] = len(guitar.finger.contacts), len(guitar.damper.places)
    i[at.H_SMOOTH] = guitar.pluck.shape == "smooth"
    i[at.H_PORTS] = 1
    d[at.METER + at.M_RATE] = sample_rate
    d[at.SIGMA : at.SIGMA + at.LANES] = 1.0
    _fill_contacts(d, guitar, 1.0 / sample_rate)
    _fill_body(d, i, guitar.body, 1.0 / sample_rate)
    tile = 0
    for s, string in enumerate(guitar.strings):
        string = replace(string, tension=float(intonation.tensions[s]))
        tile = _fill_string(d, i, s, string, guitar.basis.bandwidth_hz, tile)
        start = at.TABLES_AT + s * at.TABLES * at.TABLE
        d[start : start + at.TABLES * at.TABLE] *= residual
        tune_string(d, i, s)
        refit_string(d, i, s)


def _fill_string(d, i, s, string, bandwidth_hz, tile):
    """Constants, lanes and tables of one string; returns the tile after its own."""
    own, own_i = at.STRING + s * at.STRING_D_SIZE, at.STRING_I + s * at.STRING_I_SIZE
    count = string_modes(string, bandwidth_hz).count
    tiles = max(1, -(-count // 4)) + at.PSEUDO_TILES  # the sweep goes through one at least
    if tile + tiles > at.MAX_TILES:
        words = f"with these strings the engine's {4 * at.MAX_TILES} modes are too few: lower it"
        raise ParameterError("basis.bandwidth_hz", bandwidth_hz, words)
    i[own_i + at.SI_TILE], i[own_i + at.SI_TILES], i[own_i + at.SI_MODES] = tile, tiles, count
    for place, value in (
        (at.S_LENGTH, string.length),
        (at.S_TENSION, string.tension),
        (at.S_DENSITY, string.linear_density),
        (at.S_STIFFNESS, string.bending_stiffness),
        (at.S_LOSS_INTERNAL, string.loss_internal),
        (at.S_LOSS_AIR, string.loss_air),
        (at.S_LOSS_BENDING, string.loss_bending),
        (at.S_BANDWIDTH, bandwidth_hz),
        (at.S_RATIO, 1.0),
    ):
        d[own + place] = value
    d[at.XI + s] = string.bridge_position
    d[at.SIGMA + s] = 4.0 * string.length / string.axial_stiffness if string.axial_stiffness > 0.0 else LINEAR
    start = at.TABLES_AT + s * at.TABLES * at.TABLE
    rate = d[at.METER + at.M_RATE]
    matches = matching_frequencies(string_modes(string, bandwidth_hz).omega, bandwidth_hz)
    d[own + at.S_MATCH_1 : own + at.S_MATCH_1 + at.MATCHES] = matches / rate
    d[start : start + at.TABLES * at.TABLE] = residual_tables(string, bandwidth_hz, matches, rate).ravel()
    return tile + tiles


def matching_frequencies(omega, bandwidth_hz):
    """Where pseudo-modes are matched [rad/s]: midway between two modes, so that none is near its pole there."""
    wanted = 2.0 * np.pi * bandwidth_hz * np.array(MATCH)
    if len(omega) < 8:
        return wanted
    below = np.clip(np.searchsorted(omega, wanted) - 1, 0, len(omega) - 2)
    return 0.5 * (omega[below] + omega[below + 1])


def residual_tables(string, bandwidth_hz, matches, sample_rate):
    """What the cut modes lack between two places, as functions of a distance: sums of cos(p distance) times the static
    compliance, and at each matching frequency times the real part and the loss (minus the imaginary part) of the
    receptance and rho, since sin p x sin p y = [cos p(x - y) - cos p(x + y)] / 2.

    Parameters
    ----------
    string : ukrt.model.parameters.String
    bandwidth_hz : float [Hz]
    matches : ndarray (MATCHES,) [rad/s]
    sample_rate : float [Hz]

    Returns
    -------
    ndarray (TABLES, TABLE) [m/N]
        On an even grid over [0, L].
    """
    cut = string_modes_range(string, bandwidth_hz, REFERENCE_HZ)
    weights = [1.0 / (cut.mass * cut.omega**2)]
    for match in matches:
        half = 0.5 * match / sample_rate
        receptance = np.tan(half) / half * cut.mobility(1j * match)
        weights += [receptance.real, -receptance.imag]
    steps = at.TABLE - 1
    odd = np.rint(cut.p * 2.0 * string.length / np.pi).astype(int)  # 2 n - 1: cos(p x_j) = cos(2 pi odd j / (4 steps))
    out = np.empty((at.TABLES, at.TABLE))
    for row, weight in zip(out, weights, strict=True):
        bins = np.bincount(odd % (4 * steps), weight, minlength=4 * steps)
        row[:] = np.fft.fft(bins).real[: at.TABLE]
    return out


def _fill_contacts(d, guitar, dt):
    """Exact flow of the finger's contacts; rigid points and dampers are limits of it."""
    for j, contact in enumerate(guitar.finger.contacts):
        row = at.CONTACTS + j * at.CONTACT_SIZE
        d[row + at.C_OFFSET] = contact.offset
        if contact.kind == "damper":
            d[row + at.C_B], d[row + at.C_G] = 1.0, 2.0 * dt / contact.damping
        elif contact.kind == "oscillator":
            d[row + at.C_A], d[row + at.C_B], d[row + at.C_G] = contact_flow(contact, dt)
    for j, place in enumerate(guitar.damper.places):
        row = at.CONTACTS + (at.MAX_CONTACTS + j) * at.CONTACT_SIZE
        d[row + at.C_OFFSET], d[row + at.C_DAMPER] = place, guitar.damper.damping_ratio


def contact_flow(contact, dt):
    """Exact flow of an oscillator (m, c, k), with the limits for k = 0 and c = 0.

    Parameters
    ----------
    contact : ukrt.model.parameters.Contact
        With a mass above 0.
    dt : float [s]

    Returns
    -------
    a, b : float [1]
        Of q[k+1] = a q[k] + b q[k-1] + g f[k].
    g : float [m/N]
    """
    mass, damping, stiffness = contact.mass, contact.damping, contact.stiffness
    if stiffness > 0.0:
        omega = np.sqrt(stiffness / mass)
        a, b = flow(omega, damping / (2.0 * mass * omega), dt)
        return a, b, (1.0 - a - b) / stiffness
    if damping == 0.0:
        return 2.0, -1.0, dt * dt / mass
    decay = np.exp(-damping * dt / mass)
    return 1.0 + decay, -decay, float(-np.expm1(-damping * dt / mass)) * dt / damping


def _fill_body(d, i, body, dt):
    """Body modes in coordinates in which one step's compliance is 1, and the bridge's own 2 x 2 of it."""
    modes, (bass, treble) = body_modes(body), bridge_ends(body)
    n = modes.count
    a, b = modal_flow(modes.omega, modes.zeta, dt)
    root = np.sqrt((1.0 - a - b) / (modes.mass * modes.omega**2))
    i[at.H_BODY] = max(1, -(-n // 8))
    d[at.BODY_A : at.BODY_A + n], d[at.BODY_B : at.BODY_B + n] = a, b
    at_bass, at_slope = root * bass, root * (treble - bass)
    d[at.BODY_BASS : at.BODY_BASS + n], d[at.BODY_SLOPE : at.BODY_SLOPE + n] = at_bass, at_slope
    d[at.BODY_W : at.BODY_W + 3] = at_bass @ at_bass, at_bass @ at_slope, at_slope @ at_slope
