"""Poles of the coupled guitar in continuous time: strings, body, contacts enter, poles leave (Eqs. 19, 21-49).

Every subsystem is a receptance at its ports: a string the sum of sin(p_n x) sin(p_n x') / (m (s^2 + 2 zeta omega s +
omega^2)) over ALL its modes up to `cut_hz`, a contact 1/(m s^2 + c s + k), the body its modes at the strings' places on
the bridge. The constraints (string = body at the bridge, string = finger at the contacts) hold for port forces
lambda with D(s) lambda = 0. det D times the denominators of all modes and oscillators is the characteristic
polynomial of the constrained system: it has no poles at all, and only its logarithmic derivative is ever computed,

    N(s) = tr(D^-1 D') + sum den'/den,

so that Newton is s - 1/N(s), and the integral of N round a contour counts the poles inside.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

CUT_HZ = 400e3


@dataclass(frozen=True)
class System:
    """Chosen strings with chosen contacts, on a body or (body None, or no modes) on a rigid bridge.

    `contacts` is one tuple of contacts per string; `bridge_compliance` scales what the bridge yields (0: rigid), for
    the homotopies of `partials`; so does `tail` what the modes above `basis_hz` yield. `n_modes`, where given, cuts
    every string there instead of at `cut_hz`. `step` [s] looks at the system through the differences of a
    velocity-Verlet scheme (see `differences`); 0 is continuous time.
    """

    strings: tuple
    contacts: tuple
    body: object = None
    cut_hz: float = CUT_HZ
    n_modes: int | None = None
    bridge_compliance: float = 1.0
    basis_hz: float = np.inf
    tail: float = 1.0
    step: float = 0.0

    def __post_init__(self):
        for string, contacts in zip(self.strings, self.contacts, strict=True):
            places = [c.place for c in contacts]
            if len(set(places)) != len(places) or any(not 0.0 < x < string.length for x in places):
                raise ValueError(f"contacts at {places} m: places must differ and lie within 0 to {string.length} m")


def make_system(guitar, contacts=None, strings=None, polarization="Y", **options):
    """The system of a guitar (anything with `strings` and `body`).

    contacts : dict {string index: contacts with absolute `place` [m]}; strings : indices (default all). Polarization Z
    has a rigid bridge (Eqs. 25-30). Indices of the result count within `strings`.
    """
    if polarization not in ("Y", "Z"):
        raise ValueError(f"polarization is {polarization!r}, legal are 'Y' and 'Z'")
    indices = range(len(guitar.strings)) if strings is None else strings
    contacts = contacts or {}
    body = guitar.body if polarization == "Y" else None
    chosen = tuple(guitar.strings[s] for s in indices)
    return System(chosen, tuple(tuple(contacts.get(s, ())) for s in indices), body, **options)


def frequency(pole):
    """Frequency [Hz] of a pole: its imaginary part over 2 pi."""
    return np.imag(pole) / (2.0 * np.pi)


def decay(pole):
    """Decay rate [1/s] of a pole."""
    return -np.real(pole)


@lru_cache(maxsize=256)
def string_modes(string, cut_hz, n_modes=None):
    """p [1/m], omega [rad/s] and 2 zeta omega [1/s] of a string's modes (Eqs. 19, 48, 49), and their mass [kg]."""
    speed = np.sqrt(string.tension / string.linear_density)
    ratio = string.bending_stiffness / string.tension
    if n_modes is None:
        n_modes = int(2.0 * string.length * cut_hz * 2.0 / speed) + 1  # without stiffness: the most there can be
    p = (2.0 * np.arange(1, n_modes + 1) - 1.0) * np.pi / (2.0 * string.length)
    omega = speed * p * (1.0 + 0.5 * ratio * p**2)
    keep = omega <= 2.0 * np.pi * cut_hz
    p, omega = p[keep], omega[keep]
    bending = string.bending_stiffness * p**2
    zeta = 0.5 * (string.tension * (string.loss_internal + string.loss_air / omega) + string.loss_bending * bending) / (
        string.tension + bending)
    return p, omega, 2.0 * zeta * omega, 0.5 * string.linear_density * string.length


def ports(string, contacts):
    """Places [m] where a string meets something: its bridge end, then its contacts."""
    return (string.length, *(c.place for c in contacts))


@lru_cache(maxsize=256)
def string_weights(string, places, cut_hz, n_modes):
    """omega^2, 2 zeta omega, and shape times shape over mass for all pairs of ports, complex: (modes, ports^2)."""
    p, omega, loss, mass = string_modes(string, cut_hz, n_modes)
    shapes = np.array([np.sin(p * x) for x in places])
    pairs = shapes[:, None, :] * shapes[None, :, :] / mass
    return omega**2, loss, np.ascontiguousarray(pairs.reshape(-1, p.size).T.astype(complex))


@lru_cache(maxsize=256)
def in_basis(string, basis_hz, cut_hz, n_modes):
    """1 for the modes of `string_modes` up to `basis_hz`, 0 for those above: (modes,)."""
    return (string_modes(string, cut_hz, n_modes)[1] <= 2.0 * np.pi * basis_hz).astype(float)


def differences(s, step):
    """What stands for d2/dt2 and d/dt of exp(s t), and both derivatives with respect to s: four of the shape of s.

    Continuous time (step 0): s^2 and s. Velocity-Verlet with the velocity of the losses predicted one step ahead:
    eliminate v and a from q+ = q + h v + h^2 a / 2, v+ = v + h (a + a+) / 2 and a+ = f(q+, v + h a), with everything
    times z = exp(s h) a step: a = (z - 1)^2 / (z h^2) q, and (v + h a) / z = (3 - 4 / z + 1 / z^2) / (2 h) q: the
    central second difference, and the backward first difference of second order.
    """
    if step == 0.0:
        return s**2, s, 2.0 * s, np.ones_like(s)
    half, back = 0.5 * step * s, np.exp(-step * s)
    second, second_slope = (2.0 / step * np.sinh(half)) ** 2, 2.0 / step * np.sinh(2.0 * half)
    return second, (3.0 - 4.0 * back + back**2) / (2.0 * step), second_slope, 2.0 * back - back**2


@lru_cache(maxsize=64)
def body_modes(body, positions):
    """omega^2, 2 zeta omega and masses of the body's modes, and their shapes at the strings: (strings, modes)."""
    omega = 2.0 * np.pi * np.asarray(body.frequencies_hz, float)
    r = np.asarray(positions, float)[:, None]
    shapes = (1.0 - r) * np.asarray(body.shapes_bass, float) + r * np.asarray(body.shapes_treble, float)
    return omega**2, 2.0 * np.asarray(body.damping_ratios, float) * omega, np.asarray(body.modal_masses, float), shapes


def receptances(system, s):
    """D(s), its derivative, and the sum of den'/den over the denominators of every mode and oscillator.

    s : ndarray (k,) [rad/s]; returns (k, ports, ports) [m/N], the same per rad/s, and (k,) [s]. Ports: for each string
    its bridge end, then its contacts.
    """
    s = np.atleast_1d(np.asarray(s, complex))
    sizes = [1 + len(c) for c in system.contacts]
    starts = np.cumsum([0, *sizes])
    matrix = np.zeros((s.size, starts[-1], starts[-1]), complex)
    slope = np.zeros_like(matrix)
    trace = np.zeros(s.size, complex)
    second, first, second_slope, first_slope = (part[:, None] for part in differences(s, system.step))
    for string, contacts, start, size in zip(system.strings, system.contacts, starts, sizes, strict=False):
        omega2, loss, weights = string_weights(string, ports(string, contacts), system.cut_hz, system.n_modes)
        inverse = 1.0 / (second + loss * first + omega2)
        log_slope = (second_slope + loss * first_slope) * inverse
        trace += log_slope.sum(axis=1)
        if system.tail != 1.0:
            inside = in_basis(string, system.basis_hz, system.cut_hz, system.n_modes)
            inverse = inverse * (inside + system.tail * (1.0 - inside))
        block = slice(start, start + size)
        matrix[:, block, block] = (inverse @ weights).reshape(-1, size, size)
        slope[:, block, block] = -((log_slope * inverse) @ weights).reshape(-1, size, size)
        for port, contact in enumerate(contacts, start + 1):
            if contact.rigid:
                continue
            den = (contact.mass * second + contact.damping * first)[:, 0] + contact.stiffness
            den_slope = (contact.mass * second_slope + contact.damping * first_slope)[:, 0]
            matrix[:, port, port] += 1.0 / den
            slope[:, port, port] -= den_slope / den**2
            trace += den_slope / den
    if system.body is not None and len(system.body.frequencies_hz):
        positions = tuple(string.bridge_position for string in system.strings)
        omega2, loss, mass, shapes = body_modes(system.body, positions)
        inverse = 1.0 / (second + loss * first + omega2)
        log_slope = (second_slope + loss * first_slope) * inverse
        trace += log_slope.sum(axis=1)
        bridge = np.ix_(np.arange(s.size), starts[:-1], starts[:-1])
        scale = system.bridge_compliance / mass
        matrix[bridge] += np.einsum("an,kn,bn->kab", shapes, inverse * scale, shapes)
        slope[bridge] -= np.einsum("an,kn,bn->kab", shapes, log_slope * inverse * scale, shapes)
    return matrix, slope, trace


def characteristic(system, s):
    """N(s), the logarithmic derivative of the characteristic polynomial: (k,) [s] for s (k,) [rad/s]."""
    matrix, slope, trace = receptances(system, s)
    return trace + np.trace(np.linalg.solve(matrix, slope), axis1=1, axis2=2)


def newton(system, guesses, max_steps=30, tolerance=1e-13):
    """Newton on the characteristic polynomial: (poles, converged, steps taken).

    The tolerance is relative to |s|, plus round-off: a step that no longer shrinks below 1e-10 |s| has arrived too.
    """
    s = np.array(guesses, complex).reshape(-1)
    converged = np.zeros(s.size, bool)
    last = np.full(s.size, np.inf)
    count = 0
    while count < max_steps and not converged.all():
        count += 1
        todo = np.flatnonzero(~converged)
        try:
            step = 1.0 / characteristic(system, s[todo])
        except np.linalg.LinAlgError:  # D singular to the last bit: one of them sits on its pole
            s[todo] *= 1.0 + 3e-15
            continue
        size = np.abs(step) / np.abs(s[todo])
        s[todo] -= step
        converged[todo] = (size < tolerance) | ((size < 1e-10) & (size >= last[todo]))
        last[todo] = size
    return s, converged, count


def poles(system, guesses, max_steps=60):
    """The poles [rad/s] that Newton reaches from the guesses [rad/s]; RuntimeError where it does not settle.

    Each is reached twice, the second time from beside it: on a pole of D itself (a free body or string mode) N(s) is
    a difference of huge numbers, and a guess that sits there could pass for a solution.
    """
    first, converged, _ = newton(system, guesses, max_steps)
    found, again, _ = newton(system, first * (1.0 + 1e-6 * (1.0 + 1.0j)), max_steps)
    converged &= again & (np.abs(found - first) < 1e-9 * np.abs(first))
    if not converged.all():
        raise RuntimeError(f"no pole reached from guesses {np.asarray(guesses).reshape(-1)[~converged]} rad/s")
    return found
