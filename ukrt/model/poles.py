"""Poles of one string on the whole guitar in continuous time: a guitar, tensions and a finger's place enter, complex
frequencies s = -sigma + i omega of its partials in Y leave (zeros of Y + Z, see `coupling`)."""

from dataclasses import replace

import numpy as np

from .contacts import held_by_finger
from .coupling import SPLIT_HZ, Bridge, Characteristic, HeldString
from .strings import REFERENCE_HZ

LARGEST_STEP = 40.0  # 1/s in one Newton step: about half the distance between neighbouring body modes
NEARNESS_CENTS = 250.0  # poles this near to a partial can share it
OWN = 0.72  # a pole with more than this of the string's motion is the partial's own, and no other can be meant
SHARED = 0.4  # of the largest participation; with less it is the body's or that of the dead length behind a finger
SEARCH_STEPS = 15
BESIDE = (-25.0, 25.0)  # cents: further starts of the search for poles that share a partial


def with_tensions(guitar, tensions):
    """The guitar with other tensions [N] at rest."""
    strings = tuple(replace(one, tension=float(t)) for one, t in zip(guitar.strings, tensions, strict=True))
    return replace(guitar, strings=strings)


def stopped(guitar, string, places, split_hz=SPLIT_HZ, reference_hz=REFERENCE_HZ):
    """String number ``string`` stopped by the guitar's finger at ``places`` (n,) [m], as a `HeldString`."""
    holders = held_by_finger(guitar.finger, 0.0)
    points = np.asarray(places, float)[:, None] + np.array([point.place for point in holders])
    return HeldString(guitar.strings[string], holders, points, None, split_hz, reference_hz)


def newton(function, s, known=(), steps=30):
    """Zeros of an analytic function by Newton's method, from many starts at once.

    Parameters
    ----------
    function : ukrt.model.coupling.Characteristic
    s : ndarray (n,) complex
        Starts.
    known : sequence of ndarray (n,) complex
        Zeros to keep away from: each is divided out.
    steps : int

    Returns
    -------
    s : ndarray (n,) complex
    found : ndarray (n,) bool
        Where it converged.
    """
    s, active = np.array(s, complex), np.ones(len(s), bool)
    for _ in range(steps):
        part, at = function.at(active), s[active]
        h = 1e-7j * np.abs(at)
        value, beside = part.several(at, at + h)
        with np.errstate(all="ignore"):
            slope = (beside - value) / h / value - sum(1.0 / (at - zero[active]) for zero in known)
            step = np.nan_to_num(1.0 / slope, nan=0.0, posinf=0.0, neginf=0.0)
            size = np.abs(step)
            step = np.where(size > LARGEST_STEP, step * LARGEST_STEP / size, step)
        s[active] -= step
        active[active] = np.abs(step) >= 1e-9 * np.abs(at)
        if not active.any():
            break
    return s, ~active


def participation(function, s, string, free_length):
    """How much of a pole is the string's own partial, about 1 for a string alone: l / (T omega |F'|).

    Between rigid ends Y = tanh(s l / c) / (s sqrt(T mu)), whose slope at a zero has the modulus l / (T omega).

    Parameters
    ----------
    function : ukrt.model.coupling.Characteristic
    s : ndarray (n,) complex
        Zeros of it.
    string : ukrt.model.parameters.String
    free_length : float or ndarray (n,) [m]

    Returns
    -------
    ndarray (n,) [1]
    """
    h = 1e-5j * np.abs(s)
    above, below = function.several(s + h, s - h)
    slope = (above - below) / (2.0 * h)
    return free_length / (string.tension * np.abs(s.imag) * np.abs(slope))


def slowest_pole(function, first, string, free_length):
    """The slowest-decaying of the poles that share a partial, be it with a body mode.

    Parameters
    ----------
    function : ukrt.model.coupling.Characteristic
    first : ndarray (n,) complex
        Starts, near the partials.
    string : ukrt.model.parameters.String
    free_length : ndarray (n,) [m]

    Returns
    -------
    ndarray (n,) complex
    """
    first = np.asarray(first, complex)
    pole, found = newton(function, first)
    near = np.abs(_cents(pole, first)) < NEARNESS_CENTS
    unsure = np.flatnonzero(~(found & near & (participation(function, pole, string, free_length) > OWN)))
    if len(unsure):
        part = function.at(unsure)
        pole[unsure] = _slowest_of_several(part, first[unsure], pole[unsure], string, free_length[unsure])
    return pole


def _slowest_of_several(function, partial, pole, string, free_length):
    """Search from several starts, each time keeping away from the pole that is known, and compare what was found."""
    modes = function.bridge.body_poles
    starts = [partial.real + 1j * partial.imag * 2.0 ** (cents / 1200.0) for cents in BESIDE]
    if len(modes):
        order = np.argsort(np.abs(np.log(modes.imag / partial.imag[:, None])), axis=1)
        starts += [modes[order[:, rank]] + (0.5 + 0.5j) for rank in range(min(2, len(modes)))]
    poles, usable = [pole], [np.ones(len(pole), bool)]
    for start in starts:  # beside the body's own poles, where Z is infinite
        other, found = newton(function, start, known=[pole], steps=SEARCH_STEPS)
        poles.append(other)
        usable.append(found)
    poles = np.array(poles)
    usable = np.array(usable) & (np.abs(_cents(poles, partial)) < NEARNESS_CENTS) & (poles.imag > 0)
    shares = np.array([participation(function, other, string, free_length) for other in poles])
    shares = np.where(usable & np.isfinite(shares), shares, 0.0)
    rates = np.where(shares > SHARED * np.max(shares, axis=0), -poles.real, np.inf)
    return np.take_along_axis(poles, np.argmin(rates, axis=0)[None], axis=0)[0]


def string_poles(guitar, tensions, string, place, n_partials, others="damped"):
    """Poles of the first partials of one string on the whole guitar, motion in Y, small amplitude.

    Each partial is followed from the rigid bridge to the coupled body; where a body mode shares it, the slower-decaying
    of the two poles is given.

    Parameters
    ----------
    guitar : ukrt.model.parameters.Guitar
    tensions : ndarray (n_strings,) [N]
    string : int
    place : float [m] or None
        Of the stopping finger; None for the open string.
    n_partials : int
    others : str
        What the other strings do: ``damped`` by the guitar's damper, ``open`` or ``absent``.

    Returns
    -------
    ndarray (n_partials,) complex [1/s]
        -sigma + i omega.
    """
    guitar = with_tensions(guitar, tensions)
    one = guitar.strings[string]
    free = np.full(n_partials, one.length - (place or 0.0))
    p = np.arange(1, n_partials + 1) * np.pi / free
    s = -1.0 + 1j * one.wave_speed * p * (1.0 + one.bending_stiffness * p**2 / (2.0 * one.tension))
    split = max(SPLIT_HZ, 5.0 * np.max(s.imag) / (2.0 * np.pi))
    bridge = Bridge(guitar, others, split)
    if place is None:
        held = HeldString(one, split_hz=split)
    else:
        held = stopped(guitar, string, np.full(n_partials, place), split)
    for share in np.linspace(0.0, 1.0, 6):
        s, _ = newton(Characteristic(bridge, string, held, share), s)
    return slowest_pole(Characteristic(bridge, string, held), s, one, free)


def _cents(pole, reference):
    with np.errstate(all="ignore"):
        return 1200.0 * np.log2(np.abs(pole.imag) / np.abs(reference.imag))
