"""How loud a pole is and where on the string it lives: a system and its poles enter, residues and shares leave."""

import numpy as np

from .continuous import frequency, ports, receptances, string_modes, string_weights
from .contour import poles_between
from .partials import rigid_guess, sounding_span, string_partials


def null_vector(system, pole):
    """Port forces lambda with D(pole) lambda = 0, and lambda^T D' lambda (D is symmetric)."""
    matrix, slope, _ = receptances(system, pole)
    vector = np.linalg.svd(matrix[0])[2][-1].conj()
    return vector, vector @ slope[0] @ vector


def bridge_residues(system, found, string, pluck_place):
    """How much each pole sounds: residues of the transfer from a point force on a string to that string's bridge force.

    found : poles (k,); pluck_place [m]. Returns complex (k,) [1/s]: the part exp(s t) times residue of the impulse
    response of the force on the string at its bridge, per newton second. A force that is held and released at t = 0
    leaves residue/(-s) times its strength.
    """
    first = sum(1 + len(c) for c in system.contacts[:string])
    size = 1 + len(system.contacts[string])
    p, _, _, mass = string_modes(system.strings[string], system.cut_hz, system.n_modes)
    places = ports(system.strings[string], system.contacts[string])
    shapes = np.array([np.sin(p * x) for x in places]) * np.sin(p * pluck_place) / mass
    omega2, loss, _ = string_weights(system.strings[string], places, system.cut_hz, system.n_modes)
    result = []
    for pole in np.atleast_1d(found):
        vector, scale = null_vector(system, pole)
        drive = shapes @ (1.0 / (pole**2 + loss * pole + omega2))
        result.append(-vector[first] * (vector[first : first + size] @ drive) / scale)
    return np.array(result)


def span_share(system, pole, string):
    """Share of a string's potential energy (of tension) in the sounding span, on the bridge side of the finger.

    Near 1: a partial of the note; near 0: of the string between nut and finger; between: the two spans share it.
    """
    data, contacts = system.strings[string], system.contacts[string]
    span, _ = sounding_span(data, contacts)
    first = sum(1 + len(c) for c in system.contacts[:string])
    vector, _ = null_vector(system, pole)
    p, omega, loss, _ = string_modes(data, min(system.cut_hz, 20e3), system.n_modes)
    places = np.array(ports(data, contacts))
    drive = vector[first : first + places.size] @ np.sin(places[:, None] * p)
    amplitudes = drive / (pole**2 + loss * pole + omega**2)
    x = np.linspace(0.0, data.length, 1301)
    slopes = np.abs(np.cos(x[:, None] * p) @ (p * amplitudes)) ** 2
    return float(slopes[x > data.length - span].sum() / slopes.sum())


def loudest_partials(system, string, n_partials, pluck_place, reach=0.2):
    """For each labelled partial the pole that sounds loudest at the bridge after a pluck [m], within reach * f1 of it.

    Where the string between nut and finger, a finger's own resonance or another string nearly agrees with a partial,
    the label of `string_partials` is a matter of history, this one of hearing. Returns (n_partials,) [rad/s].
    """
    labelled = string_partials(system, string, n_partials)
    spacing = frequency(rigid_guess(system.strings[string], system.contacts[string], 1))[0]
    place = {"string": string, "pluck_place": pluck_place}
    return np.array([loudest_near(system, frequency(pole), reach * spacing, **place) for pole in labelled])


def loudest_near(system, centre_hz, half_hz, string, pluck_place):
    """The pole [rad/s] within about centre +- half [Hz] that sounds loudest at the bridge after a pluck [m]."""
    for widen in (1.0, 1.07, 0.93, 1.13, 0.87):  # an edge may touch a pole
        try:
            near = poles_between(system, centre_hz - widen * half_hz, centre_hz + widen * half_hz, 200.0)
            break
        except RuntimeError:
            continue
    else:
        raise RuntimeError(f"no clean window round {centre_hz} Hz")
    heard = np.abs(bridge_residues(system, near, string, pluck_place) / near)
    return near[np.argmax(heard)]
