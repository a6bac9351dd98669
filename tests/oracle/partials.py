"""Which pole is which: a system and a string enter, the poles of that string's partials leave, labelled by homotopy.

The closed form of a string between two fixed ends gives the guess; the contacts' compliance, then the bridge's, are
switched on little by little while Newton follows each pole. A label is what continuity gives it: where a body mode and
a partial exchange characters, `string_like` picks the slower of the two; where the two spans of a stopped string do,
`loudness.loudest_partials` picks what is heard.
"""

from dataclasses import replace

import numpy as np

from .continuous import body_modes, newton, poles

COARSE_CUT_HZ = 40e3  # enough to follow a pole; the last Newton uses all modes


def follow(make, start, end, seeds, first_step=0.125):
    """Follow poles of make(t) from t = start to end, with as many steps as Newton needs to stay close.

    A step is kept when Newton settles fast and lands near the linear prediction, compared with the move itself.
    """
    t, step = start, first_step * (end - start)
    now, before, t_before = np.asarray(seeds, complex), None, None
    while t < end:
        step = min(step, end - t)
        guess = now if before is None else now + (now - before) * (step / (t - t_before))
        found, converged, count = newton(make(t + step), guess, max_steps=8)
        miss = np.abs(found - guess)
        allowed = np.maximum(0.3, 0.2 * np.abs(found - now))
        if converged.all() and count <= 6 and np.all(miss <= allowed):
            before, t_before, now, t = now, t, found, t + step
            step *= 1.6
        elif step < 1e-6:
            raise RuntimeError(f"lost poles near {found[miss > allowed].imag / 2 / np.pi} Hz at t = {t}")
        else:
            step *= 0.5
    return now


def sounding_span(string, contacts):
    """Length of the sounding span and its effective length with bending (clamped bridge; half clamped at a finger)."""
    stops = [c.place for c in contacts if c.rigid or c.stiffness > 0.0]
    layer = np.sqrt(string.bending_stiffness / string.tension)
    if stops:
        return string.length - max(stops), string.length - max(stops) - 1.5 * layer
    return string.length, string.length - layer


def rigid_guess(string, contacts, n_partials):
    """Closed-form poles [rad/s] of the sounding span between fixed ends: n c / 2L with bending and Eq. 49's losses."""
    _, length = sounding_span(string, contacts)
    p = np.arange(1, n_partials + 1) * np.pi / length
    bending = string.bending_stiffness * p**2
    omega = np.sqrt(string.tension / string.linear_density) * p * (1.0 + bending / (2.0 * string.tension))
    loss = string.tension * (string.loss_internal + string.loss_air / omega) + string.loss_bending * bending
    return -0.5 * omega * loss / (string.tension + bending) + 1j * omega


def string_partials(system, string, n_partials, distinct=True):
    """Poles [rad/s] of partials 1..n_partials of one string of a system, in order: ndarray (n_partials,).

    Contacts yield from 0 to 1 on a rigid bridge first (that string alone), then the bridge yields from 0 to 1 (every
    string and contact present). Two labels that end on one pole are refused (RuntimeError) unless distinct is False.
    """
    contacts = system.contacts[string]
    alone = replace(system, strings=(system.strings[string],), contacts=(contacts,), body=None)
    whole = system
    if system.n_modes is None:
        alone, whole = (replace(part, cut_hz=min(part.cut_hz, COARSE_CUT_HZ)) for part in (alone, whole))
    seeds = rigid_guess(alone.strings[0], contacts, n_partials)
    if contacts:
        seeds = poles(replace(alone, contacts=(_yielding(contacts, 0.0),)), seeds)
        seeds = follow(lambda u: replace(alone, contacts=(_yielding(contacts, u),)), 0.0, 1.0, seeds)
    else:
        seeds = poles(alone, seeds)
    if system.body is not None and len(system.body.frequencies_hz):
        seeds = follow(lambda t: replace(whole, bridge_compliance=t * system.bridge_compliance), 0.0, 1.0, seeds)
    found = poles(system, seeds)
    return _distinct(found) if distinct else found


def _yielding(contacts, u):
    """Contacts on their way: oscillators yield u times as much (0: rigid), pure dampers resist u times as much."""
    result = []
    for c in contacts:
        if c.rigid:
            result.append(c)
        elif c.stiffness == 0.0 and c.mass == 0.0:
            result.append(replace(c, damping=c.damping * max(u, 1e-6)))
        elif u == 0.0:
            result.append(replace(c, rigid=True))
        else:
            result.append(replace(c, mass=c.mass / u, damping=c.damping / u, stiffness=c.stiffness / u))
    return tuple(result)


def _distinct(found):
    gaps = np.abs(found[:, None] - found[None, :]) + np.diag(np.full(found.size, np.inf))
    if found.size > 1 and np.any(gaps < 1e-9 * np.abs(found)):
        raise RuntimeError(f"two labels followed the same pole: {found}")
    return found


def body_poles(system):
    """Poles [rad/s] that grow out of the free body's modes as the strings are attached, in the body's order."""
    if system.body is None:
        return np.zeros(0, complex)
    omega2, loss, _, _ = body_modes(system.body, tuple(s.bridge_position for s in system.strings))
    seeds = -0.5 * loss + 1j * np.sqrt(omega2 - 0.25 * loss**2)
    seeds += 0.05 + 0.05j  # rad/s: beside the free mode, not on it, where N(s) would be a difference of huge numbers
    coarse = system if system.n_modes else replace(system, cut_hz=min(system.cut_hz, COARSE_CUT_HZ))
    seeds = follow(lambda t: replace(coarse, bridge_compliance=t * system.bridge_compliance), 0.0, 1.0, seeds)
    return _distinct(poles(system, seeds))


def string_like(system, string, n_partials, reach_hz=10.0):
    """Partials as heard after the attack: where a body pole lies within reach_hz of a partial, the slower pole.

    Returns (poles, labels): ndarray (n_partials,) [rad/s] and bool array, True where the body's label was the slower.
    """
    found = string_partials(system, string, n_partials)
    others = body_poles(system)
    swapped = np.zeros(found.size, bool)
    for n, pole in enumerate(found):
        near = [b for b in others if abs(b.imag - pole.imag) < 2 * np.pi * reach_hz and b.real > pole.real]
        if near:
            found[n], swapped[n] = max(near, key=lambda b: b.real), True
    return found, swapped
