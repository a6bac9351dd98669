"""Fig. 12: a stiff contact and several soft ones behind it, seen and heard."""

import numpy as np

from ..experiment.result import Quantity
from ..model.parameters import Contact
from ..units import ratio_to_cents
from .coupled_modes import coupled_modes
from .data import FigureData, Number
from .decay import band, decay_rate, time_to_fall
from .sounds import SOUND_HZ, normal_gain, resampled
from .spectra import amplitude_spectrum, highest_near
from .spectrogram import draw_spectrogram, spectrogram, top_of
from .stopped_string import CONTINUOUS_HZ, READINGS, at_reading, modes_for, offsets, oscillator, partials, stopped_case

NUMBER = 12
TITLE = "Spectrograms of the bridge force: a stiff contact and soft ones behind it"
COUNTS = (3, 5)
FIRST = (1e6, 1.0)  # k [N/m] and c [N s/m] of the contact at x_F
SOFT = (1e4, 10.0)  # of the others
DURATION = 4.0  # s
FALL_DB = 20.0  # 99 % of the energy is spent
PARTIALS = (1, 7)  # whose decay is measured
BANDS_HZ = ((0.0, 600.0), (600.0, 1500.0), (1500.0, 5000.0))
PAPER_PRECISE = "a first stiff contact ensures a precise tuning (Sec. IV B 2)"
PAPER_CONTROL = "soft contacts control waveform and spectral content of the decaying response (Sec. IV B 2)"


def stiff_and_soft(count):
    """A stiff contact at the finger's place and soft ones over its width, for Figs. 12 and 13 (tuple of Contact)."""
    return tuple(oscillator(*(SOFT if n else FIRST), offset) for n, offset in enumerate(offsets(count)))


def make(run):
    numbers, cases, shown = [], [], None
    for reading, place in READINGS.items():
        results = [run(_case(count, place)) for count in (1, *COUNTS)]
        forces = [resampled(one["bridge_force"][:, 0], one.rate_hz) for one in results]
        modes = [modes_for(run, one.case) for one in results]
        numbers += [*_tuning(results, modes, at_reading(reading)), *_decays(results, modes, at_reading(reading))]
        numbers += [*_continuous(results, at_reading(reading)), *_band_times(forces, at_reading(reading))]
        cases += [one.case for one in results]
        shown = shown or forces[1:]
    pictures = [spectrogram(force, SOUND_HZ) for force in shown]
    gain = normal_gain(*shown)
    what = "gain of both sound files, the same for both"
    numbers.append(Number(what, gain, "1/N", "(sound files available)", None, f"full scale is {1 / gain:.2f} N"))
    arrays = {"time": Quantity(pictures[0][0], "s"), "frequency": Quantity(pictures[0][1], "Hz")}
    for count, (_, _, levels) in zip(COUNTS, pictures, strict=True):
        arrays[f"level_{count}_contacts"] = Quantity(levels, "dB re 1 N")
    pairs = zip(COUNTS, shown, strict=True)
    sounds = {f"figure_12_{count}_contacts": (float(SOUND_HZ), gain * force) for count, force in pairs}
    return FigureData(arrays, tuple(numbers), sounds, tuple(cases))


def draw(data, figure):
    from .style import mark

    figure.set_size_inches(6.3, 6.0)
    panels = figure.subplots(2, sharex=True, sharey=True)
    levels = [data.arrays[f"level_{count}_contacts"].values for count in COUNTS]
    axes, top = (data.arrays["time"].values, data.arrays["frequency"].values), top_of(*levels)
    for panel, count, one in zip(panels, COUNTS, levels, strict=True):
        image = draw_spectrogram(panel, *axes, one, top)
        mark(panel, f"$F$ = {count}")
    panels[-1].set_xlabel("Time [s]")
    figure.colorbar(image, ax=panels, label="bridge force [dB re 1 N]", pad=0.02)


def _case(count, place):
    """``count`` contacts; 1 is a rigid one, which the others are compared with."""
    if count == 1:
        return stopped_case(f"one rigid contact at {place:.4f} L", [Contact(0.0, rigid=True)], place, DURATION)
    return stopped_case(f"{count} contacts, one stiff, at {place:.4f} L", stiff_and_soft(count), place, DURATION)


def _tuning(results, modes, at):
    """Partial 1 against a rigid contact, whose result comes first, from the records' spectra."""
    found, numbers = [], []
    for one, mode in zip(results, modes, strict=True):
        spectrum = amplitude_spectrum(one["bridge_force"][:, 0], one.rate_hz)
        found.append(highest_near(*spectrum, mode.frequencies[partials(one.case, mode, 1)[0]], 1.0)[0])
    for count, hz in zip(COUNTS, found[1:], strict=True):
        cents = float(ratio_to_cents(hz / found[0]))
        what = f"{at}tuning of partial 1 against a rigid contact, F = {count}"
        numbers.append(Number(what, cents, "cents", PAPER_PRECISE, bool(abs(cents) < 1.0), f"{hz:.2f} Hz"))
    return numbers


def _decays(results, modes, at):
    """Decay rates of a low and of a middle partial, in the record and in the eigenvalue problem."""
    numbers, settled = [], results[0].times > 0.05
    for partial in PARTIALS:
        for count, one, mode in zip((1, *COUNTS), results, modes, strict=True):
            pole = mode.poles[partials(one.case, mode, partial)[-1]]
            hz, expected = pole.imag / (2.0 * np.pi), -pole.real
            found = decay_rate(one["bridge_force"][settled, 0], one.rate_hz, hz)
            what = f"{at}decay rate of partial {partial}, " + ("rigid contact" if count == 1 else f"F = {count}")
            note = f"at {hz:.0f} Hz; eigenvalue problem {expected:.3f} 1/s"
            agrees = None if count == 1 else bool(found > numbers[-1].value)
            numbers.append(Number(what, found, "1/s", PAPER_CONTROL, agrees, note))
    return numbers


def _continuous(results, at):
    """The middle partial's decay with next to nothing left out of the basis."""
    numbers = []
    for count, one in zip(COUNTS, results[1:], strict=True):
        modes = coupled_modes(one.case, CONTINUOUS_HZ)
        rate = -modes.poles[partials(one.case, modes, PARTIALS[-1])[-1]].real
        what = f"{at}decay rate of partial {PARTIALS[-1]}, basis up to {CONTINUOUS_HZ / 1e3:g} kHz, F = {count}"
        numbers.append(Number(what, rate, "1/s", "modes up to 10 kHz (Sec. IV A)", None, "eigenvalue problem"))
    return numbers


def _band_times(forces, at):
    """How long low and high parts of the sound last."""
    numbers = []
    for low, high in BANDS_HZ:
        times = [time_to_fall(band(force, SOUND_HZ, low, high), SOUND_HZ, FALL_DB) for force in forces]
        for count, seconds in zip(COUNTS, times[1:], strict=True):
            what = f"{at}{low:g}-{high:g} Hz: time until 99 % of the energy is spent, F = {count}"
            note = f"rigid contact {times[0]:.2f} s"
            numbers.append(Number(what, seconds, "s", PAPER_CONTROL, bool(seconds < times[0]), note))
    return numbers
