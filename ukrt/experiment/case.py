"""A numerical experiment: a guitar, what is taken away from it, fingers and plucks with their times, what is recorded.
It enters as checked data and leaves as the guitar that is really there and the held points at any time."""

# ruff: noqa: RUF009 - the defaults are field declarations, not values

import functools
from dataclasses import dataclass, replace

from ..errors import ParameterError
from ..model import fields as f
from ..model.contacts import held_by_finger
from ..model.fingerboard import fingerboard
from ..model.parameters import Body, Guitar

FOREVER = 86400.0  # s: the end of a finger that stays


@dataclass(frozen=True)
class HeldString(f.Checked):
    """The guitar's finger on one string for a while."""

    string: str = f.text("name of the string")
    place: float = f.number("L", 0.001, 0.98, "place of the finger's first contact, as a fraction of L from the nut")
    start: float = f.number("s", 0.0, FOREVER, "when it lands; 0: it is there from the beginning, at rest", 0.0)
    end: float = f.number("s", 0.0, FOREVER, "when it lets go", FOREVER)

    def cross_check(self):
        if self.end <= self.start:
            raise ParameterError("end", self.end, f"it must be later than start, {self.start:g} s")


@dataclass(frozen=True)
class ForceRamp(f.Checked):
    """A pluck: a force at a point that rises linearly and then vanishes."""

    string: str = f.text("name of the string")
    place: float = f.number("L", 0.01, 0.99, "as a fraction of L from the nut", 0.9)
    start: float = f.number("s", 0.0, FOREVER, "when the force begins to rise", 0.0)
    duration: float = f.number("s", 1e-4, 1.0, "time of the ramp", 0.010)
    force_y: float = f.number("N", -100.0, 100.0, "peak force normal to the soundboard", 0.0)
    force_z: float = f.number("N", -100.0, 100.0, "peak force parallel to the soundboard", 0.0)


@dataclass(frozen=True)
class Point(f.Checked):
    """A place on a string whose displacement is recorded."""

    string: str = f.text("name of the string")
    place: float = f.number("L", 0.0, 1.0, "as a fraction of L from the nut; 1 is the bridge")
    direction: str = f.choice(("Y", "Z"), "normal (Y) or parallel (Z) to the soundboard", "Y")


@dataclass(frozen=True)
class Record(f.Checked):
    """What is kept of a run. The constraint drift of the reference solver is always kept."""

    rate_hz: float = f.number("Hz", 1.0, 1e7, "at most so many samples a second; unfiltered", 1e7)
    displacement: tuple = f.parts(Point, (0, 2000), "displacement at these places", ())
    bridge_force: bool = f.flag("force of each string on the body, in Y", True)
    energies: bool = f.flag("energy of each subsystem (Eq. 50)", False)
    tension: bool = f.flag("tension of each string (Eq. 17)", False)
    amplitudes: bool = f.flag("amplitude of every mode: large", False)


@dataclass(frozen=True)
class Case(f.Checked):
    """One numerical experiment."""

    name: str = f.text("name of the experiment")
    duration: float = f.number("s", 1e-4, 3600.0, "how long")
    guitar: Guitar = f.part(Guitar, "the instrument; in a file: a preset's name, or a table with base")
    description: str = f.text("one line about it", "")
    strings: tuple = f.texts_list((0, 12), "names of the strings that are there; none: all", ())
    bridge: str = f.choice(("body", "rigid"), "what the strings end on", "body")
    losses: bool = f.flag("false: strings, body and fingers lose nothing (pure dampers stay what they are)", True)
    tension_modulation: bool = f.flag("false: linear strings (ES = 0)", True)
    held: tuple = f.parts(HeldString, (0, 64), "strings that the guitar's finger holds", ())
    plucks: tuple = f.parts(ForceRamp, (0, 1000), "plucks", ())
    record: Record = f.part(Record, "what is kept", Record())
    step: float = f.number("s", 1e-8, 1e-4, "time step of the reference solver; the paper's is 1e-5", 1e-5)
    sample_rate: float = f.number("Hz", 44100.0, 192000.0, "sample rate of the engine", 48000.0)

    def cross_check(self):
        names = [string.name for string in self.guitar.strings]
        _refuse_unknown("strings", self.strings, names)
        names = [name for name in names if not self.strings or name in self.strings]
        rows_of = {"held": self.held, "plucks": self.plucks, "record.displacement": self.record.displacement}
        for key, rows in rows_of.items():
            for n, row in enumerate(rows):
                _refuse_unknown(f"{key}.{n}.string", [row.string], names)
        lengths = {string.name: string.length for string in fingerboard(self.guitar).guitar.strings}
        reach = min(contact.offset for contact in self.guitar.finger.contacts)
        for n, one in enumerate(self.held):
            if one.place * lengths[one.string] + reach <= 0.0:
                raise ParameterError(f"held.{n}.place", one.place, "it brings a contact of the finger behind the nut")
            for other in self.held[:n]:
                if one.string == other.string and one.start < other.end and other.start < one.end:
                    words = f"the finger holds {one.string} already from {other.start:g} to {other.end:g} s"
                    raise ParameterError(f"held.{n}.start", one.start, words)

    @functools.cached_property
    def instrument(self):
        """The guitar that is really there (Guitar): strings, bridge, losses and stretching as the case has them."""
        guitar = fingerboard(self.guitar).guitar
        strings = [string for string in guitar.strings if not self.strings or string.name in self.strings]
        body, finger = guitar.body, guitar.finger
        if self.bridge == "rigid":
            body = Body((), (), (), (), ())
        if not self.tension_modulation:
            strings = [replace(string, axial_stiffness=0.0) for string in strings]
        if not self.losses:
            strings = [replace(one, loss_internal=0.0, loss_air=0.0, loss_bending=0.0) for one in strings]
            body = replace(body, damping_ratios=(0.0,) * len(body.damping_ratios))
            finger = replace(finger, contacts=tuple(_lossless(contact) for contact in finger.contacts))
        return replace(guitar, strings=tuple(strings), body=body, finger=finger)

    def string_number(self, name):
        """Number of the string called ``name`` in `instrument` (int)."""
        return [string.name for string in self.instrument.strings].index(name)

    def held_points(self, time):
        """What holds each string just after ``time`` [s]: tuple (n_strings,) of tuples of HeldPoint."""
        instrument = self.instrument
        rows = [() for _ in instrument.strings]
        for one in self.held:
            if one.start <= time < one.end:
                number = self.string_number(one.string)
                rows[number] = held_by_finger(instrument.finger, one.place * instrument.strings[number].length)
        return tuple(rows)


def _lossless(contact):
    return contact if contact.kind == "damper" else replace(contact, damping=0.0)


def _refuse_unknown(key, found, names):
    for name in found:
        if name not in names:
            raise ParameterError(key, name, f"the strings there are called {', '.join(names)}")
