"""A case's fingers and plucks as the engine's gestures: times become whole samples, what the engine cannot do is
refused."""

import math
from dataclasses import dataclass

from ..engine import gestures
from ..engine.kernels.hands import SHORTEST_PLUCK
from ..errors import ParameterError

NUT_GAP = 0.002  # m: the engine moves a contact nearer to the nut than this (kernels/ports.py, contact_place)
_ORDER = (gestures.LIFT, gestures.PRESS, gestures.PLUCK)  # at one sample: what leaves goes first


@dataclass(frozen=True)
class Gesture:
    """One call of `ukrt.engine.kernels.hands.perform`.

    Attributes
    ----------
    frame : int
        The last sample that is not yet affected.
    kind, string : int
    numbers : tuple of 4 float
        See `ukrt.engine.gestures`.
    """

    frame: int
    kind: int
    string: int
    numbers: tuple


def gestures_of(case, rate):
    """What hands do in a case, in order.

    Parameters
    ----------
    case : ukrt.experiment.case.Case
    rate : float [Hz]

    Returns
    -------
    list of Gesture

    Raises
    ------
    ParameterError
        Two plucks at once on one string; a contact on the nut.
    """
    found = _fingers(case, rate) + _plucks(case, rate)
    return sorted(found, key=lambda one: (one.frame, _ORDER.index(one.kind)))


def _fingers(case, rate):
    """PRESS and LIFT. A finger that is held at one place by two entries, one after the other, stays."""
    guitar, found, down = case.instrument, [], {}
    landing = float(max(1, round(case.instrument.finger.landing_time * rate)))
    for n, one in sorted(enumerate(case.held), key=lambda pair: pair[1].start):
        string = case.string_number(one.string)
        start, end = round(one.start * rate), round(one.end * rate)
        if start == end:
            continue
        place = one.place * guitar.strings[string].length
        _check_contacts(case, n, place)
        last = down.get(string)
        if last and (last.frame, last.numbers[0]) == (start, place):
            found.remove(last)
        else:
            found.append(Gesture(start, gestures.PRESS, string, (place, landing, 0.0, 0.0)))
        down[string] = Gesture(end, gestures.LIFT, string, (place, 1.0, 0.0, 0.0))  # LIFT does not read the place
        found.append(down[string])
    return found


def _check_contacts(case, n, place):
    nearest = place + min(contact.offset for contact in case.instrument.finger.contacts)
    if nearest < NUT_GAP:
        words = f"it brings a contact to {1e3 * nearest:.3g} mm from the nut, and the engine needs {1e3 * NUT_GAP:g} mm"
        raise ParameterError(f"held.{n}.place", case.held[n].place, words)


def _plucks(case, rate):
    found, busy = [], {}
    for n, one in sorted(enumerate(case.plucks), key=lambda pair: pair[1].start):
        string = case.string_number(one.string)
        start, ramp = round(one.start * rate), max(SHORTEST_PLUCK, round(one.duration * rate))
        if start <= busy.get(string, -1):
            words = (
                f"another pluck of {one.string} lasts until {busy[string] / rate:g} s, and the engine plucks a string "
                "with one finger at a time"
            )
            raise ParameterError(f"plucks.{n}.start", one.start, words)
        busy[string] = start + ramp  # the sample at which the force jumps still feels half of it
        force, angle = math.hypot(one.force_y, one.force_z), math.atan2(one.force_z, one.force_y)
        found.append(Gesture(start, gestures.PLUCK, string, (one.place, force, angle, float(ramp))))
    return found
