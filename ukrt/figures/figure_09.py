"""Fig. 9: what the stiffness of one flexible contact does to the spectrum of the bridge force."""

from dataclasses import dataclass, replace

import numpy as np

from ..experiment.result import Quantity
from ..model.parameters import Basis, Contact
from ..model.strings import residual_compliance
from ..units import ratio_to_cents
from .coupled_modes import coupled_modes
from .data import FigureData, Number
from .spectra import amplitude_spectrum, db, highest_near
from .stopped_string import CHOSEN, LENGTH, MASS, READINGS, at_reading, modes_for, oscillator, partials, stopped_case

NUMBER = 9
TITLE = "Spectra of the bridge force: the stiffness of the contact is varied (F = 1, c = 0)"
STIFFNESSES = (1e4, 1e5, 1e6)  # N/m
SHOWN_HZ = 5000.0
NEAR_HZ, NEAR = 0.5, 1.5e-3  # Hz and share: within both a peak is that mode's; Verlet at 1e-5 s raises 2.25 kHz by 8e-4
PARTIALS = 8  # whose tuning is compared
CLEAR = 1.5  # times the oscillator's resonance: from here on its skirts are gone
BASIS_HZ, WIDER_HZ = 10e3, 20e3  # the paper's, and the widest that is legal
PAPER_PEAK = "the oscillator's resonance is seen as a peak and moves with k (Fig. 9)"
PAPER_BELOW = "spectra are affected much more below the oscillator's resonance (Sec. IV B 2)"
PAPER_UNWANTED = "less stiffness raises the undesirable modes, more lowers them (Sec. IV B 2)"
PAPER_TUNING = "with more stiffness the partials are disturbed less and tuning improves (Sec. IV B 2)"


@dataclass(frozen=True)
class Spectrum:
    """The bridge force of one case over frequency [Hz], [N], and the modes of its system."""

    case: object
    frequencies: np.ndarray
    amplitudes: np.ndarray
    modes: object

    @property
    def own(self):
        """Number of the mode of which the finger has the most."""
        return int(np.argmax(self.modes.finger_share))

    def peak(self, mode):
        """Frequency [Hz] and amplitude [N] found where mode number ``mode`` should be."""
        hz = self.modes.frequencies[mode]
        within = max(NEAR_HZ + NEAR * hz, 1.01 * self.frequencies[1])
        return highest_near(self.frequencies, self.amplitudes, hz, within)


def make(run):
    spectra = {reading: [_spectrum(run, k, READINGS[reading]) for k in (*STIFFNESSES, None)] for reading in READINGS}
    numbers = []
    for reading, group in spectra.items():
        numbers += _numbers(group, reading)
    wider = [_spectrum(run, k, READINGS[CHOSEN], WIDER_HZ) for k in (STIFFNESSES[-1], None)]
    for one, contact in zip(wider, (f"k = {STIFFNESSES[-1]:g} N/m", "rigid contact"), strict=True):
        _, level = _unwanted_level(one, READINGS[CHOSEN])
        what = f"the same with a basis up to {WIDER_HZ / 1e3:g} kHz, {contact}"
        numbers.append(Number(what, level, "dB", "modes up to 10 kHz", None, "less leaks through a wider basis"))
    numbers += [_peak_at_fret(fret) for fret in (3, 4)]
    shown = spectra[CHOSEN][0].frequencies <= SHOWN_HZ
    arrays = {"frequency": Quantity(spectra[CHOSEN][0].frequencies[shown], "Hz")}
    columns = (*(f"k = {k:g} N/m" for k in STIFFNESSES), "rigid")
    for reading, group in spectra.items():
        name = "spectra" if reading == CHOSEN else "spectra_other_reading"
        arrays[name] = Quantity(np.array([one.amplitudes[shown] for one in group]).T, "N", columns)
    peaks = np.array([one.peak(one.own) for one in spectra[CHOSEN][:-1]])
    arrays["finger_frequency"], arrays["finger_amplitude"] = Quantity(peaks[:, 0], "Hz"), Quantity(peaks[:, 1], "N")
    return FigureData(arrays, tuple(numbers), cases=tuple(one.case for group in spectra.values() for one in group))


def draw(data, figure):
    from .style import BLUE, RED

    figure.set_size_inches(6.3, 6.6)
    frequency, spectra = data.arrays["frequency"].values, data.arrays["spectra"].values
    found, height = data.arrays["finger_frequency"].values, data.arrays["finger_amplitude"].values
    panels = figure.subplots(len(STIFFNESSES), sharex=True, sharey=True)
    for n, (panel, stiffness) in enumerate(zip(panels, STIFFNESSES, strict=True)):
        panel.semilogy(frequency, spectra[:, n], color=BLUE)
        label = f"the finger's own peak, {found[n]:.0f} Hz"
        panel.plot(found[n], 1.8 * height[n], "v", color=RED, markersize=5, label=label)
        panel.set_ylabel("$|F_{SB}(f)|$ [N]")
        panel.legend(loc="upper right", title=f"$k_f = 10^{int(np.log10(stiffness))}$ N/m", title_fontsize=8.0)
    panels[0].set_xlim(0.0, SHOWN_HZ)
    panels[0].set_ylim(1e-8, 5.0)
    panels[-1].set_xlabel("Frequency [Hz]")


def _case(stiffness, place, duration=5.0):
    contact = Contact(0.0, rigid=True) if stiffness is None else oscillator(stiffness, 0.0)
    words = "rigid contact" if stiffness is None else f"one contact of {stiffness:g} N/m"
    return stopped_case(f"{words} at {place:.4f} L", [contact], place, duration)


def _spectrum(run, stiffness, place, bandwidth_hz=BASIS_HZ):
    """Run one case and transform its bridge force; ``stiffness`` None is a rigid contact."""
    case = _case(stiffness, place)
    case = replace(case, guitar=replace(case.guitar, basis=Basis(bandwidth_hz)))
    result = run(case)
    spectrum = amplitude_spectrum(result["bridge_force"][:, 0], result.rate_hz)
    return Spectrum(case, *spectrum, modes_for(run, case))


def _numbers(group, reading):
    """What the text says about Fig. 9, for one reading of x_F: the flexible contacts, then the rigid one."""
    *flexible, rigid = group
    at = at_reading(reading)
    numbers = [_peak(one, k, at) for one, k in zip(flexible, STIFFNESSES, strict=True)]
    for k, softer, stiffer in zip(STIFFNESSES, flexible, flexible[1:], strict=False):
        numbers.append(_change(softer, stiffer, k, at))
    numbers += _unwanted(group, READINGS[reading], at)
    detuned = [_detuning(one, rigid) for one in flexible]
    for n, (k, cents) in enumerate(zip(STIFFNESSES, detuned, strict=True)):
        what, spread = f"{at}rms detuning of partials 1-{PARTIALS} against a rigid contact, k = {k:g} N/m", _rms(cents)
        note = f"partial 1: {cents[0]:+.2f} cents; largest {cents[np.argmax(np.abs(cents))]:+.1f} cents"
        agrees = spread < _rms(detuned[n - 1]) if n else None
        numbers.append(Number(what, spread, "cents", PAPER_TUNING, agrees, note))
    return numbers


def _peak(one, stiffness, at):
    """The finger's own peak beside the frequency of the coupled mode and sqrt(k/m)."""
    found, _ = one.peak(one.own)
    expected, alone = one.modes.frequencies[one.own], np.sqrt(stiffness / MASS) / (2.0 * np.pi)
    share = one.modes.finger_share[one.own]
    note = f"coupled mode {expected:.2f} Hz, of whose energy the finger has {share:.0%}; alone {alone:.1f} Hz"
    agrees = bool(abs(found - expected) < 0.25 + 1e-3 * expected)  # a bin, and the scheme's own error at 1e-5 s
    return Number(f"{at}the finger's own peak, k = {stiffness:g} N/m", found, "Hz", PAPER_PEAK, agrees, note)


def _change(softer, stiffer, stiffness, at):
    """How much a spectrum changes with ten times the stiffness, below the upper of the two resonances and above."""
    change, hz = db(stiffer.amplitudes / softer.amplitudes), stiffer.frequencies
    edge = stiffer.modes.frequencies[stiffer.own]
    below = _rms(change[(hz > 20.0) & (hz < edge)])
    above = _rms(change[(hz > CLEAR * edge) & (hz < SHOWN_HZ)])
    what = f"{at}k from {stiffness:g} to {10 * stiffness:g} N/m: change of the spectrum below {edge:.0f} Hz over above"
    note = f"rms change of level: {below:.1f} dB below, {above:.2f} dB from {CLEAR:g} times that to {SHOWN_HZ:g} Hz"
    return Number(what, below / above, "", PAPER_BELOW, bool(below > 2.0 * above), note)


def _unwanted(group, place, at):
    """Levels of the mode that nobody wants, and why they stop falling."""
    levels, numbers = [_unwanted_level(one, place) for one in group], []
    words = f"{at}first mode of the length behind the finger over partial 1"
    for n, (hz, level) in enumerate(levels):
        contact = "rigid contact" if n == len(STIFFNESSES) else f"k = {STIFFNESSES[n]:g} N/m"
        note, agrees = f"found at {hz:.1f} Hz", level < levels[n - 1][1] if 0 < n < len(STIFFNESSES) else None
        if agrees is False:
            note += "; past so stiff a contact, bending and a cut basis let more through than its compliance does"
        numbers.append(Number(f"{words}, {contact}", level, "dB", PAPER_UNWANTED, agrees, note))
    return [*numbers, _passed_on(group[0].case.instrument.strings[0], place, at)]


def _passed_on(string, place, at):
    """What a point contact passes on whatever its stiffness, as a compliance in series with its own, negative.

    Pushed at a point a stiff string yields less than a flexible one by sqrt(B/T) / 2T; modes left out yield nothing.
    """
    bending = np.sqrt(string.bending_stiffness / string.tension) / (2.0 * string.tension)
    cut = float(residual_compliance(string, BASIS_HZ, np.array([place * LENGTH]))[0][0, 0])
    what = f"{at}compliance by which bending and the cut basis act against the contact's own"
    note = f"bending {1e6 * bending:.1f}, cut {1e6 * cut:.1f} µm/N; 1e5 N/m, 10 µm/N and more below resonance, meets it"
    return Number(what, 1e6 * (bending + cut), "µm/N", "modes up to 10 kHz", None, note)


def _unwanted_level(one, place):
    """Frequency [Hz] and level [dB over the first partial] of the first mode of the length behind the finger."""
    modes, string = one.modes, one.case.instrument.strings[0]
    behind = modes.share_between(0.0, place * LENGTH)
    near = np.abs(modes.frequencies / (string.wave_speed / (2.0 * place * LENGTH)) - 1.0) < 0.25
    hz, amplitude = one.peak(int(np.argmax(np.where(near, behind, 0.0))))
    first = int(np.argmax(np.where(modes.finger_share < 0.3, 1.0 - behind, 0.0) * (modes.frequencies < 150.0)))
    return hz, float(db(amplitude / one.peak(first)[1]))


def _detuning(one, rigid):
    """Cents by which the first partials differ from those with a rigid contact (PARTIALS,)."""
    likeness, cents = one.modes.likeness(rigid.modes), []
    for partial in partials(rigid.case, rigid.modes, PARTIALS):
        alike = int(np.argmax(likeness[:, partial]))
        cents.append(ratio_to_cents(one.peak(alike)[0] / rigid.peak(partial)[0]))
    return np.array(cents)


def _peak_at_fret(fret):
    """The coupled mode where the finger stands at a fret instead, k = 1e5 N/m: from the eigenvalue problem alone."""
    place = 1.0 - 2.0 ** (-fret / 12.0)
    modes = coupled_modes(_case(1e5, place))
    own = int(np.argmax(modes.finger_share))
    return Number(
        f"x_F = {place:.4f} L, fret {fret}: the finger's own mode, k = 1e+05 N/m",
        float(modes.frequencies[own]),
        "Hz",
        "the text's x_F lies between these frets",
        None,
        f"eigenvalue problem; the finger has {modes.finger_share[own]:.0%} of its energy",
    )


def _rms(values):
    return float(np.sqrt(np.mean(np.square(values))))
