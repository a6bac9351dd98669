"""What a guitar is made of, as frozen SI data: one field, one unit, one legal range, one line of words. Values enter by
construction (or from a preset), are checked, and leave as plain numbers that nothing changes afterwards."""

# ruff: noqa: RUF009 - the defaults are field declarations, not values

import math
from dataclasses import dataclass

from ..errors import ParameterError
from . import fields as f
from .fingerboard import MOST_FRETS, first_fret, key_cents

MAX_CONTACTS = 5  # fingers and dampers together on one string
LEAST_GAP = 1e-4  # m between two contacts: nearer, they are one
LEAST_RIGID_GAP = 1e-3  # m: two rigid points nearer than this fix the slope as well, and the system becomes singular
LEAST_NUT_GAP = 5e-3  # m that the contact nearest to the nut keeps from it at the first fret
MIDI_MODES = ("keyboard", "guitar", "mpe", "guitar-mpe")
EQUAL_TEMPERAMENT = tuple(100.0 * n for n in range(1, 13))  # cents


@dataclass(frozen=True)
class String(f.Checked):
    """A stiff damped string with the constants of Eqs. 16-20, 48 and 49."""

    name: str = f.text("name of the open string, such as E2")
    note: int = f.integer(0, 127, "MIDI note of the open string without a capo, in equal temperament")
    length: float = f.number("m", 0.1, 2.0, "scale length L, nut to bridge")
    tension: float = f.number("N", 1.0, 500.0, "tension T0 at rest; where tuning.mode is equal only a first guess")
    linear_density: float = f.number("kg/m", 1e-5, 0.1, "mass per length rho S")
    bending_stiffness: float = f.number("N m^2", 0.0, 0.01, "B = E I")
    axial_stiffness: float = f.number("N", 0.0, 1e6, "E S, behind tension modulation (Eq. 20); 0 is a linear string")
    loss_internal: float = f.number("", 0.0, 0.1, "loss coefficient eta_F (Eq. 49)")
    loss_air: float = f.number("1/s", 0.0, 100.0, "loss coefficient eta_A (Eq. 49)")
    loss_bending: float = f.number("", 0.0, 1.0, "loss coefficient eta_B (Eq. 49)")
    bridge_position: float = f.number("", 0.0, 1.0, "where it crosses the bridge: 0 bass end, 1 treble end")
    fine_tune: float = f.number("cents", -100.0, 100.0, "how far it is tuned beside its note, frets and all", 0.0)

    @property
    def wave_speed(self):
        """Speed of transverse waves c_T [m/s]."""
        return math.sqrt(self.tension / self.linear_density)

    @property
    def wave_impedance(self):
        """Characteristic impedance sqrt(T0 rho S) [N s/m]."""
        return math.sqrt(self.tension * self.linear_density)


@dataclass(frozen=True)
class Body(f.Checked):
    """Modes of the body at the bridge, normal to the soundboard (Eqs. 21-30, Table I); no mode is a rigid bridge."""

    frequencies_hz: tuple = f.numbers_list("Hz", 10.0, 20000.0, (0, 64), "natural frequencies")
    damping_ratios: tuple = f.numbers_list("", 0.0, 0.5, (0, 64), "damping ratios zeta")
    modal_masses: tuple = f.numbers_list("kg", 1e-4, 1e4, (0, 64), "modal masses, for the shapes below")
    shapes_bass: tuple = f.numbers_list("", -10.0, 10.0, (0, 64), "mode shapes at the bass end of the bridge")
    shapes_treble: tuple = f.numbers_list("", -10.0, 10.0, (0, 64), "mode shapes at the treble end of the bridge")

    def cross_check(self):
        count = len(self.frequencies_hz)
        for name in ("damping_ratios", "modal_masses", "shapes_bass", "shapes_treble"):
            values = getattr(self, name)
            if len(values) != count:
                words = f"it must have {count} numbers, one for each of frequencies_hz"
                raise ParameterError(name, list(values), words)


@dataclass(frozen=True)
class Contact(f.Checked):
    """One point where a finger holds a string, the same in Y and Z: rigid (Eqs. 31-35), an oscillator (Eqs. 36-41) or,
    with neither mass nor stiffness, a pure damper."""

    offset: float = f.number("m", -0.1, 0.0, "distance from the finger's place, negative towards the nut")
    mass: float = f.number("kg", 0.0, 1.0, "mass m_F; 0 only for a pure damper", 0.0)
    damping: float = f.number("N s/m", 0.0, 1e4, "damping c_F", 0.0)
    stiffness: float = f.number("N/m", 0.0, 1e8, "stiffness k_F", 0.0)
    rigid: bool = f.flag("true: the string cannot move here; mass, damping and stiffness do not count", False)

    def cross_check(self):
        if self.rigid:
            return
        if self.mass == 0.0 and self.stiffness > 0.0:
            raise ParameterError("mass", self.mass, "a contact with stiffness needs a mass above 0 kg, from 1e-05 to 1")
        if 0.0 < self.mass < 1e-5:
            raise ParameterError("mass", self.mass, "it must be 0 or a number from 1e-05 to 1 kg")
        if self.mass == 0.0 and self.damping == 0.0:
            raise ParameterError("damping", self.damping, "a contact without mass or stiffness needs a damping above 0")

    @property
    def kind(self):
        """``rigid``, ``oscillator`` or ``damper``."""
        return "rigid" if self.rigid else "oscillator" if self.mass > 0.0 else "damper"


@dataclass(frozen=True)
class Finger(f.Checked):
    """The finger that stops a string: contact points that move together."""

    contacts: tuple = f.parts(Contact, (1, MAX_CONTACTS), "contact points, the one at the note's place first")
    landing_time: float = f.number("s", 5e-4, 0.1, "time in which a landing finger brings the string down", 0.005)

    def cross_check(self):
        for n, one in enumerate(self.contacts):
            for other in self.contacts[:n]:
                gap = LEAST_RIGID_GAP if one.rigid and other.rigid else LEAST_GAP
                if abs(one.offset - other.offset) < gap * (1 - 1e-9):
                    words = f"it must differ from every other contact's by at least {gap:g} m"
                    raise ParameterError(f"contacts.{n}.offset", one.offset, words)


@dataclass(frozen=True)
class Damper(f.Checked):
    """The right hand that ends a note: pure dampers at fixed places on the whole string."""

    places: tuple = f.numbers_list("L", 0.01, 0.99, (0, MAX_CONTACTS - 1), "places as fractions of L from the nut")
    damping_ratio: float = f.number("sqrt(T0 rho S)", 0.01, 100.0, "damping of each place over the wave impedance", 2.0)
    attack_time: float = f.number("s", 5e-4, 0.5, "time in which the damper comes down", 0.008)
    release_time: float = f.number("s", 5e-4, 0.5, "time in which the damper is lifted", 0.005)

    def cross_check(self):
        for n, place in enumerate(self.places):
            if any(abs(place - other) < 1e-3 for other in self.places[:n]):
                raise ParameterError(f"places.{n}", place, "it must differ from every other place by at least 0.001 L")


@dataclass(frozen=True)
class Pluck(f.Checked):
    """The plucking finger: a force that rises and then vanishes."""

    place: float = f.number("L", 0.01, 0.99, "plucking place as a fraction of L from the nut")
    angle: float = f.number("rad", -math.pi, math.pi, "direction: 0 normal to the soundboard (Y), pi/2 parallel (Z)")
    duration: float = f.number("s", 1e-4, 0.1, "time of the ramp; also the constant delay of live playing")
    force_soft: float = f.number("N", 1e-3, 1.0, "peak force at MIDI velocity 20")
    force_strong: float = f.number("N", 1e-3, 100.0, "peak force at MIDI velocity 127")
    attack: float = f.number("", 0.01, 1.0, "share of duration for which it pulls, unless CC 22 changes it", 1.0)
    shape: str = f.choice(("linear", "smooth"), "how the force rises: evenly, or along half a cosine", "linear")

    def cross_check(self):
        if self.force_strong < self.force_soft:
            raise ParameterError("force_strong", self.force_strong, "it must not be less than force_soft")


@dataclass(frozen=True)
class Radiation(f.Checked):
    """How bridge force becomes sound (Eq. 51)."""

    impulse_response: str = f.text("name of a shipped impulse response, or the path of a WAV file")
    gain_db: float = f.number("dB", -200.0, 200.0, "gain from 1 Pa (or 1 N) to full scale 1.0", 0.0)


@dataclass(frozen=True)
class Playing(f.Checked):
    """The player and the fingerboard."""

    frets: int = f.integer(0, MOST_FRETS, "frets that can be stopped")
    idle_strings: str = f.choice(("open", "damped"), "strings without a note: free, or held by the damper", "open")
    bend_range_semitones: float = f.number("semitones", 0.0, 24.0, "full pitch bend, unless an RPN changes it", 2.0)
    hand_span_frets: int = f.integer(1, 24, "frets that the left hand spans without moving", 4)
    capo: int = f.integer(0, 12, "fret at which a capo holds all strings, 0: none; frets are counted from there", 0)
    midi_mode: str = f.choice(MIDI_MODES, "what MIDI channels stand for: keys, strings, or notes", "keyboard")
    base_channel: int = f.integer(1, 16, "MIDI channel of the highest string in mode guitar, others follow", 1)
    keyswitches: str = f.choice(("off", "on"), "keys outside the range that say how notes are played", "off")
    keyswitch_key: int = f.integer(0, 127, "the first of them; all must lie outside the guitar's keys", 21)

    def cross_check(self):
        if self.capo > self.frets:
            raise ParameterError("capo", self.capo, f"it must be one of the {self.frets} frets, or 0")


@dataclass(frozen=True)
class Scale(f.Checked):
    """Which pitches there are, as in Scala's ``.scl``: above degree 0, whose 0 cents are not listed."""

    name: str = f.text("what it is called", "12 equal steps")
    cents: tuple = f.numbers_list(
        "cents", -12000.0, 12000.0, (1, 1024), "degrees 1, 2, ...; after the last it repeats", EQUAL_TEMPERAMENT
    )


@dataclass(frozen=True)
class Keyboard(f.Checked):
    """Which key (MIDI note) plays which degree of the scale, and how high, as in Scala's ``.kbm``."""

    degrees: tuple = f.texts_list((0, 128), "degree on each key from middle_key up, or x; none: one degree a key", ())
    first_key: int = f.integer(0, 127, "keys below play nothing", 0)
    last_key: int = f.integer(0, 127, "keys above play nothing", 127)
    middle_key: int = f.integer(0, 127, "key of degree 0", 60)
    reference_key: int = f.integer(0, 127, "key whose frequency is given", 69)
    reference_hz: float = f.number("Hz", 1.0, 20000.0, "that frequency where tuning.a4_hz is 440", 440.0)
    octave_degree: int = f.integer(0, 1024, "degree at which degrees repeats; 0: the scale's last", 0)

    def cross_check(self):
        for n, degree in enumerate(self.degrees):
            if degree != "x" and not (degree.isascii() and degree.isdigit() and len(degree) < 5):
                raise ParameterError(f"degrees.{n}", degree, 'it must be a degree such as "7", or "x"')


@dataclass(frozen=True)
class Articulation(f.Checked):
    """Slurs, slides, vibrato, touches, strums; speeds and forces hold at velocity 127 and go with the pluck's force.

    The defaults are estimates: hammer-ons come out 9 to 17 dB below a pluck of the same velocity, pull-offs 6 to 11.
    """

    hammer_speed: float = f.number("m/s", 0.0, 10.0, "speed of a finger that hammers on", 4.0)
    hammer_time: float = f.number("s", 5e-4, 0.05, "time in which it comes to rest", 0.002)
    pull_force: float = f.number("N", 0.0, 20.0, "force with which a finger pulls off", 6.0)
    pull_angle: float = f.number("rad", -math.pi, math.pi, "its direction: as pluck.angle", 1.1)
    slide_time: float = f.number("s", 0.005, 5.0, "time of a slide, unless CC 5 changes it", 0.1)
    vibrato_depth: float = f.number("cents", 0.0, 100.0, "deviation either way at full wheel or pressure", 25.0)
    # Laurson et al., ICMC 2000: the vibrato of a guitar is mostly at 5 to 6 Hz
    vibrato_rate: float = f.number("Hz", 0.1, 12.0, "vibrato: swings in a second", 5.0)
    touch_resistance: float = f.number("sqrt(T0 rho S)", 0.01, 100.0, "of a finger that touches a node", 1.0)
    touch_time: float = f.number("s", 0.001, 1.0, "time for which it stays after the release", 0.06)
    flesh_time: float = f.number("s", 1e-4, 0.05, "time in which a soft fingertip lets a string slip (CC 18)", 0.003)
    mute_resistance: float = f.number("sqrt(T0 rho S)", 0.01, 100.0, "of the hand that mutes near the bridge", 4.0)
    plant_resistance: float = f.number("sqrt(T0 rho S)", 0.01, 100.0, "of a finger firmly planted on the string", 2.0)
    # What controllers begin with, as shares of their range
    flesh: float = f.number("", 0.0, 1.0, "how softly plucks let go, unless CC 18 changes it", 0.0)
    muting: float = f.number("", 0.0, 1.0, "how much the hand mutes, unless CC 19 changes it", 0.0)
    planting: float = f.number("", 0.0, 1.0, "how firmly fingers are planted, unless CC 26 changes it", 0.0)
    variation: float = f.number("", 0.0, 1.0, "how much plucks differ, unless CC 25 changes it", 0.0)
    seed: int = f.integer(0, 2**31 - 1, "what the chance in these variations begins with", 1)
    strum_time: float = f.number("s", 0.0, 0.4, "of a sweep over all strings, unless CC 23 changes it; 0: none", 0.0)
    strum_direction: str = f.choice(("down", "up", "alternate"), "down begins on the bass side; CC 24", "down")


@dataclass(frozen=True)
class Tuning(f.Checked):
    """What tensions and fret places are made from: see `fingerboard`."""

    a4_hz: float = f.number("Hz", 220.0, 880.0, "frequency of A4; all else moves with it", 440.0)
    mode: str = f.choice(
        ("published", "equal"),
        "published: tensions as given, frets where flexible strings want them; equal: both solved for notes in tune",
        "equal",
    )
    scale: Scale = f.part(Scale, "the scale", Scale())
    keyboard: Keyboard = f.part(Keyboard, "its notes on the keys", Keyboard())

    def cross_check(self):
        key_cents(self)


@dataclass(frozen=True)
class Basis(f.Checked):
    """The modal basis of the strings."""

    bandwidth_hz: float = f.number("Hz", 1000.0, 20000.0, "modes of the strings up to this frequency", 10000.0)


@dataclass(frozen=True)
class Guitar(f.Checked):
    """The whole instrument; string 0 is the one on the bass side, as a rule the lowest."""

    name: str = f.text("name of the preset")
    description: str = f.text("one line about it")
    strings: tuple = f.parts(String, (1, 12), "strings, that on the bass side first")
    body: Body = f.part(Body, "body modes at the bridge")
    finger: Finger = f.part(Finger, "the stopping finger")
    damper: Damper = f.part(Damper, "the damping hand")
    pluck: Pluck = f.part(Pluck, "the plucking finger")
    radiation: Radiation = f.part(Radiation, "from bridge force to sound")
    playing: Playing = f.part(Playing, "player and fingerboard")
    articulation: Articulation = f.part(Articulation, "slurs, slides, vibrato, touches, strums", Articulation())
    tuning: Tuning = f.part(Tuning, "intonation", Tuning())
    basis: Basis = f.part(Basis, "modal basis", Basis())

    def cross_check(self):
        places, contacts = self.damper.places, self.finger.contacts
        if len(contacts) + len(places) > MAX_CONTACTS:
            words = f"it may have at most {MAX_CONTACTS - len(contacts)} beside the finger's {len(contacts)} contacts"
            raise ParameterError("damper.places", list(places), words)
        last = 17 - len(self.strings)
        if self.playing.midi_mode == "guitar" and self.playing.base_channel > last:
            words = f"it must be from 1 to {last}: the channels of {len(self.strings)} strings end at 16"
            raise ParameterError("playing.base_channel", self.playing.base_channel, words)
        limit = LEAST_NUT_GAP - first_fret(self)
        for n, contact in enumerate(contacts):
            if contact.offset < limit:
                words = f"it must be from {limit:.4f} to 0 m, {LEAST_NUT_GAP:g} m off nut or capo at the first fret"
                raise ParameterError(f"finger.contacts.{n}.offset", contact.offset, words)
