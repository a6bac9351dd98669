"""What the poles of a note should be: the oracle's, in continuous time with modes to 400 kHz; and what a basis cut at
some frequency and a scheme with some step must make of them, mode by mode, without running it."""

import contextlib
from dataclasses import replace

import numpy as np
from oracle import (
    ContactData,
    bridge_residues,
    frequency,
    loudest_near,
    make_system,
    poles,
    rigid_guess,
    span_share,
    string_partials,
)
from oracle.partials import COARSE_CUT_HZ, follow

from .notes import PARTIALS

HOME = 0.25  # of partial 1: how far from the rigidly stopped string's partial the note's own can be
DEAD = 0.2  # share of a pole's energy in the sounding span below which it is the dead length's
HEARD_AT = 0.15  # of the string from the bridge: the pluck that decides which of two mixed poles is the note's


def fretted_contacts(guitar, place):
    """The guitar's finger at ``place`` [m], as the oracle's records."""
    return tuple(ContactData(place + c.offset, c.mass, c.damping, c.stiffness, c.rigid) for c in guitar.finger.contacts)


def oracle_system(guitar, intonation, held, polarization="Y", only=None):
    """The oracle's system of ``guitar`` at its intonation; held : {string: fret}; only : one string alone, or all."""
    strings = tuple(replace(one, tension=float(t)) for one, t in zip(guitar.strings, intonation.tensions, strict=True))
    contacts = {s: fretted_contacts(guitar, float(intonation.places[s, fret])) for s, fret in held.items() if fret}
    tuned = replace(guitar, strings=strings)
    return make_system(tuned, contacts, None if only is None else [only], polarization)


def oracle_poles(guitar, intonation, string, fret, polarization="Y"):
    """Poles [rad/s] of partials 1 to 8 of one note, the other strings open: ndarray (8,).

    Another string in unison may take a label on the way; of the labelled pole and the one that Newton reaches from
    the string alone on the body, the one is meant that a pluck makes louder at the bridge. Behind a soft finger the
    dead length may take one too, and carry it off: a pole that is not where the partial must be is no candidate.
    """
    count = max(PARTIALS)
    alone = oracle_system(guitar, intonation, {string: fret}, polarization, string)
    place = (1.0 - HEARD_AT) * guitar.strings[string].length
    if fret:
        place = max(place, 0.5 * (guitar.strings[string].length + float(intonation.places[string, fret])))
    expected = frequency(rigid_guess(alone.strings[0], alone.contacts[0], count))
    found = _at_home(alone, string_partials(alone, 0, count, distinct=False), expected, place)
    if polarization == "Z":  # on a rigid bridge no string knows of another
        return found
    whole = oracle_system(guitar, intonation, {string: fret})
    candidates = np.array([string_partials(whole, string, count, distinct=False), poles(whole, found)])
    loud = np.array([np.abs(bridge_residues(whole, row, string, place) / row) for row in candidates])
    loud[0, np.abs(frequency(candidates[0]) - expected) > HOME * expected[0]] = 0.0
    return candidates[np.argmax(loud, axis=0), np.arange(count)]


def _at_home(alone, labelled, expected, place):
    """Labelled poles of a string, but the loudest near where a partial must be [Hz] for those that went elsewhere.

    Where two poles there are too close for the oracle's search, they are the same to any measurement: the label stays.
    """
    found, home = labelled.copy(), HOME * expected[0]
    for n, pole in enumerate(labelled):
        astray = abs(frequency(pole) - expected[n]) > home
        if astray or (alone.contacts[0] and span_share(alone, pole, 0) < DEAD):
            with contextlib.suppress(RuntimeError):
                found[n] = loudest_near(alone, expected[n], home, 0, place)
    return found


def cut_poles(system, found, basis_hz, step=0.0):
    """Where poles of ``system`` go when its strings' modes above ``basis_hz`` fade away, and time goes in steps.

    Parameters
    ----------
    system : oracle.System
        With all its modes, in continuous time.
    found : ndarray (k,) [rad/s]
        Its poles.
    basis_hz : float [Hz]
    step : float [s]
        Of velocity-Verlet as `oracle.continuous.differences` has it; 0: continuous time.

    Returns
    -------
    ndarray (k,) [rad/s]
        In the same order: each is followed on the way.
    """
    coarse = replace(system, cut_hz=max(COARSE_CUT_HZ, basis_hz), basis_hz=basis_hz)
    seeds = poles(coarse, found)
    seeds = follow(lambda t: replace(coarse, tail=1.0 - t, step=t * step), 0.0, 1.0, seeds)
    return poles(replace(system, cut_hz=basis_hz, step=step), seeds)
