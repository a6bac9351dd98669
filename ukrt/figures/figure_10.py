"""Fig. 10: what the damping of one flexible contact does to the spectrum of the bridge force and to the note."""

import numpy as np

from ..experiment.result import Quantity
from .data import FigureData, Number
from .decay import decay_rate, envelope_ripple, time_to_fall
from .spectra import amplitude_spectrum, db, highest_near
from .stopped_string import (
    CHOSEN,
    LENGTH,
    MASS,
    READINGS,
    at_reading,
    modes_for,
    oscillator,
    partials,
    recorded,
    stopped_case,
)

NUMBER = 10
TITLE = "Bridge force and motion of the string: the damping of the contact is varied (F = 1, k = 1e5 N/m)"
STIFFNESS = 1e5  # N/m
DAMPINGS = (1.0, 10.0)  # N s/m
SHOWN_HZ = 5000.0
PICK_UP = 0.9  # L: the paper does not say where; at the plucked point 5 N fills its axis, -2 to 4 mm
DECAY_DB = 10.0  # 90 % of the energy: within the five seconds for every c
PAPER_WIDER = "the frequency region affected becomes wider (Sec. IV B 2)"
PAPER_LOWER = "the amplitude of the coupled modes close to the oscillator's resonance decreases (Sec. IV B 2)"
PAPER_SHORT = "the envelope becomes smoother and has a shorter decay (Sec. IV B 2)"
PAPER_AXIS = "axis of Fig. 10, -2 to 4 mm"


def make(run):
    numbers, arrays, cases = [], {}, []
    for reading, place in READINGS.items():
        runs = [run(_case(c, place, reading)) for c in DAMPINGS]
        modes = [modes_for(run, _case(c, place, reading)) for c in (0.0, *DAMPINGS)]
        spectra = [amplitude_spectrum(one["bridge_force"][:, 0], one.rate_hz, "fade") for one in runs]
        numbers += _numbers(runs, spectra, modes, at_reading(reading))
        cases += [one.case for one in runs]
        if reading == CHOSEN:
            arrays = _arrays(runs, spectra)
    return FigureData(arrays, tuple(numbers), cases=tuple(cases))


def draw(data, figure):
    from .style import BLUE, ORANGE

    figure.set_size_inches(6.3, 5.4)
    upper, lower = figure.subplots(2)
    for n, (c, colour) in enumerate(zip(DAMPINGS, (BLUE, ORANGE), strict=True)):
        upper.semilogy(
            data.arrays["frequency"].values,
            data.arrays["spectra"].values[:, n],
            color=colour,
            label=f"$c_f$ = {c:g} N s/m",
        )
        lower.plot(data.arrays["time"].values, 1e3 * data.arrays["displacement"].values[:, n], color=colour, lw=0.4)
    upper.set(xlim=(0.0, SHOWN_HZ), ylim=(1e-6, 5.0), xlabel="Frequency [Hz]", ylabel="$|F_{SB}(f)|$ [N]")
    upper.legend(loc="upper right")
    lower.set(xlim=(0.0, 5.0), ylim=(-2.0, 4.0), xlabel="Time [s]", ylabel="$Y(t)$ at 0.9 $L$ [mm]")


def _case(damping, place, reading):
    name = f"one contact of {damping:g} N s/m at {reading}"
    return stopped_case(name, [oscillator(STIFFNESS, damping)], place, record=recorded([PICK_UP]))


def _arrays(runs, spectra):
    shown, columns = spectra[0][0] <= SHOWN_HZ, tuple(f"c = {c:g} N s/m" for c in DAMPINGS)
    motion = np.concatenate([one["displacement"] for one in runs], axis=1)
    return {
        "frequency": Quantity(spectra[0][0][shown], "Hz"),
        "spectra": Quantity(np.array([one[shown] for _, one in spectra]).T, "N", columns),
        "time": Quantity(runs[0].times, "s"),
        "displacement": Quantity(motion, "m", columns),
    }


def _numbers(runs, spectra, modes, at):
    """What the text says about Fig. 10, for one reading of x_F; ``modes`` without the contact's damping come first."""
    place, numbers = runs[0].case.held[0].place, []
    undamped, *damped = modes
    for one, c in zip(damped, DAMPINGS, strict=True):
        numbers += [_width(one, c, at), _added(one, undamped, c, place, at)]
    bands = [_band(one, undamped) for one in damped]
    for n, (c, (low, high)) in enumerate(zip(DAMPINGS, bands, strict=True)):
        what = f"{at}width of the band in which modes decay at least twice as fast as with c = 0, c = {c:g} N s/m"
        wider = high - low > bands[0][1] - bands[0][0] if n else None
        numbers.append(Number(what, high - low, "Hz", PAPER_WIDER, wider, f"{low:.0f} to {high:.0f} Hz"))
    numbers += [_measured(*pair, c, at) for *pair, c in zip(runs, damped, DAMPINGS, strict=True)]
    numbers += _levels(spectra, runs[0].case.instrument.strings[0].wave_speed, place, at)
    return numbers + _note(runs, at)


def _width(modes, damping, at):
    """How wide the oscillator's own peak is, from its pole."""
    own = int(np.argmax(modes.finger_share))
    width, share, alone = -modes.poles[own].real / np.pi, modes.finger_share[own], damping / MASS / (2.0 * np.pi)
    what = f"{at}half-power width of the oscillator's mode, c = {damping:g} N s/m"
    note = f"eigenvalue problem; alone c / m = {alone:.1f} Hz, and the finger has {share:.0%} of its energy"
    return Number(what, width, "Hz", PAPER_WIDER, bool(abs(width / (share * alone) - 1.0) < 0.1), note)


def _added(damped, undamped, damping, place, at):
    """The decay that the contact adds to all modes together: half the trace of M^-1 C, whatever the coupling."""
    added, string = float(np.sum(undamped.poles.real) - np.sum(damped.poles.real)), damped.first_string
    moving = 1.0 / np.sum(string.shape(place * LENGTH) ** 2 / string.mass)
    closed = damping / (2.0 * (MASS + moving))
    what = f"{at}decay rate that the contact adds to all modes together, c = {damping:g} N s/m"
    note = f"c / 2(m + m_s) = {closed:.2f} 1/s; m_s = {1e6 * moving:.0f} mg of string go with the contact"
    return Number(what, added, "1/s", "(closed form)", bool(abs(added / closed - 1.0) < 5e-3), note)


def _band(damped, undamped):
    """Lowest and highest frequency [Hz] of the modes whose decay at least doubles."""
    same = np.argmax(damped.likeness(undamped), axis=0)
    doubled = undamped.frequencies[damped.poles.real[same] <= 2.0 * undamped.poles.real]
    return float(doubled.min()), float(doubled.max())


def _measured(result, modes, damping, at):
    """Decay of partial 4, below the oscillator's resonance, in the record and in the eigenvalue problem."""
    partial = partials(result.case, modes, 4)[-1]
    settled = result.times > 0.05
    found = decay_rate(result["bridge_force"][settled, 0], result.rate_hz, modes.frequencies[partial])
    expected = -modes.poles[partial].real
    what = f"{at}decay rate of partial 4, c = {damping:g} N s/m"
    note = f"from the record; eigenvalue problem {expected:.4f} 1/s"
    return Number(what, found, "1/s", "(eigenvalue problem)", bool(abs(found / expected - 1.0) < 0.01), note)


def _levels(spectra, wave_speed, place, at):
    """How the partials near the resonance change from the lesser to the greater damping [dB]."""
    hz = wave_speed / (2.0 * (1.0 - place) * LENGTH)
    centre = np.sqrt(STIFFNESS / MASS) / (2.0 * np.pi)
    nearest = int(round(centre / hz))
    change = {}
    for n in range(nearest - 2, nearest + 3):
        less, more = (highest_near(*one, n * hz, 0.3 * hz)[1] for one in spectra)
        change[n] = float(db(more / less))
    at_centre = change.pop(nearest)
    others = ", ".join(f"{n}: {value:+.1f}" for n, value in change.items())
    what = f"{at}change of level of partial {nearest}, at the resonance, from c = 1 to 10 N s/m"
    note = "at resonance the contact is c alone: 1 is near the string's 2 sqrt(T mu) = 1.34 N s/m and takes the most"
    numbers = [Number(what, at_centre, "dB", PAPER_LOWER, bool(at_centre < 0.0), note)]
    what = f"{at}mean change of level of the two partials on either side"
    mean = float(np.mean(list(change.values())))
    return [*numbers, Number(what, mean, "dB", PAPER_LOWER, bool(mean < 0.0), others)]


def _note(runs, at):
    """Decay and smoothness of the string's motion, and whether it fills the paper's axis."""
    numbers, motions = [], [one["displacement"][:, 0] for one in runs]
    decays = [time_to_fall(y, one.rate_hz, DECAY_DB) for y, one in zip(motions, runs, strict=True)]
    ripple = [envelope_ripple(y, one.rate_hz) for y, one in zip(motions, runs, strict=True)]
    for values, unit, words, note in (
        (decays, "s", "time until Y has spent 90 % of its energy", ""),
        (ripple, "dB", "ripple of the envelope of Y", "rms about a smooth curve, 0.1 to 3 s"),
    ):
        for n, c in enumerate(DAMPINGS):
            agrees = values[1] < values[0] if n else None
            numbers.append(Number(f"{at}{words}, c = {c:g} N s/m", values[n], unit, PAPER_SHORT, agrees, note))
    for words, value in (("largest", np.max(motions[0])), ("smallest", np.min(motions[0]))):
        inside = bool(-2e-3 <= value <= 4e-3)
        numbers.append(Number(f"{at}{words} Y at the plucked point", 1e3 * float(value), "mm", PAPER_AXIS, inside))
    return numbers
