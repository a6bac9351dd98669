"""Fig. 13: a G major arpeggio on the whole guitar, as the bridge feels it and as it is heard."""

import numpy as np

from ..experiment.case import Case, ForceRamp, HeldString, Record
from ..experiment.result import Quantity
from ..model.body import end_weights
from ..radiation.impulse_response import load_impulse_response
from ..units import midi_to_hz, ratio_to_cents
from .cases import paper_guitar, with_contacts
from .data import FigureData, Number
from .figure_12 import stiff_and_soft
from .sounds import SOUND_HZ, convolved, normal_gain, resampled
from .spectra import amplitude_spectrum, db, highest_near
from .spectrogram import draw_spectrogram, spectrogram, top_of

NUMBER = 13
TITLE = "Spectrograms of the bridge force and of the sound pressure: a G major arpeggio"
FRETS = {"E2": 3, "A2": 2, "D3": 0, "G3": 0, "B3": 0, "E4": 3}  # G2 B2 D3 G3 B3 G4
APART = 0.25  # s between notes: quavers at 120 a minute; the paper gives neither tempo nor forces
PLUCK = 2.0  # N, in Y: of Fig. 6
CONTACTS = 5
DURATION = 4.0  # s
BANDS_HZ = 1000.0 * 2.0 ** (np.arange(-11, 8) / 3.0)  # third octaves, IEC 61260: 79 Hz to 5 kHz
NAMES = ("bridge force", "sound pressure")
PAPER_CHORD = "a G major chord, the two lowest and the top string stopped (Sec. IV C)"
PAPER_FILTER = "the pressure clearly shows the spectral filtering of the vibration signal (Sec. IV C)"


def make(run, duration=DURATION):
    case = _case(duration)
    result = run(case)
    forces = resampled(result["bridge_force"], result.rate_hz)
    response = load_impulse_response(case.guitar.radiation.impulse_response, SOUND_HZ).samples
    ends = forces @ end_weights([string.bridge_position for string in case.guitar.strings])
    pressure, force = convolved(ends, response)[: len(ends)], ends.sum(axis=1)
    times, frequencies, felt = spectrogram(force, SOUND_HZ)
    heard = spectrogram(pressure[:, 0], SOUND_HZ)[2]
    force_gain, pressure_gain = normal_gain(force), normal_gain(pressure)
    sounds = {
        "figure_13_bridge_force": (float(SOUND_HZ), force_gain * force),
        "figure_13_pressure": (float(SOUND_HZ), pressure_gain * pressure),
    }
    levels = _band_levels(force, pressure[:, 0], response[:, :, 0])
    numbers = [*_chord(result), *_filtering(*levels), *_gains(force_gain, pressure_gain)]
    arrays = {
        "time": Quantity(times, "s"),
        "frequency": Quantity(frequencies, "Hz"),
        "force_level": Quantity(felt, "dB re 1 N"),
        "pressure_level": Quantity(heard, "dB re 1 Pa"),
        "band": Quantity(BANDS_HZ, "Hz"),
        "band_level": Quantity(np.array(levels).T, "dB", ("pressure over force", "|H| at the partials", "|H| evenly")),
    }
    return FigureData(arrays, tuple(numbers), sounds, (case,))


def draw(data, figure):
    from .style import mark

    figure.set_size_inches(6.3, 6.0)
    panels = figure.subplots(2, sharex=True, sharey=True)
    for panel, name, key in zip(panels, NAMES, ("force_level", "pressure_level"), strict=True):
        quantity = data.arrays[key]
        axes = data.arrays["time"].values, data.arrays["frequency"].values
        image = draw_spectrogram(panel, *axes, quantity.values, top_of(quantity.values))
        figure.colorbar(image, ax=panel, label=f"{name} [{quantity.unit}]", pad=0.02)
        mark(panel, name)
    panels[-1].set_xlabel("Time [s]")


def _case(duration=DURATION):
    held = [HeldString(name, 1.0 - 2.0 ** (-fret / 12.0)) for name, fret in FRETS.items() if fret]
    return Case(
        "G major arpeggio",
        duration,
        with_contacts(paper_guitar(), *stiff_and_soft(CONTACTS)),
        held=tuple(held),
        plucks=tuple(ForceRamp(name, start=n * APART, force_y=PLUCK) for n, name in enumerate(FRETS)),
        record=Record(rate_hz=50e3),
    )


def _chord(result):
    """The pitch of each note in its own string's force, against equal temperament."""
    numbers = []
    for n, (name, fret) in enumerate(FRETS.items()):
        note = result.case.guitar.strings[n].note + fret
        ringing = result.times >= n * APART + 0.05
        spectrum = amplitude_spectrum(result["bridge_force"][ringing, n], result.rate_hz, "fade", pad=4)
        hz, _ = highest_near(*spectrum, midi_to_hz(note), 0.028 * midi_to_hz(note))
        cents = float(ratio_to_cents(hz / midi_to_hz(note)))
        where = f"fret {fret}" if fret else "open"
        remark = f"{cents:+.1f} cents from equal temperament: published tensions and geometric frets, nothing tuned"
        what = f"fundamental of {name} {where}"
        numbers.append(Number(what, hz, "Hz", PAPER_CHORD, bool(abs(cents) < 50.0), remark))
    return numbers


def _band_levels(force, pressure, response):
    """Levels in third octaves [dB]: pressure over force, the impulse response at the force's frequencies, and evenly.

    The last two know nothing of the pressure: |H|^2 is the mean over both ends of the bridge, for the second weighted
    with the spectrum of the whole force.
    """
    size = 2 ** int(np.ceil(np.log2(len(force) + len(response))))
    hz = np.fft.rfftfreq(size, 1.0 / SOUND_HZ)
    felt, heard = (np.abs(np.fft.rfft(one, size)) ** 2 for one in (force, pressure))
    through = np.mean(np.abs(np.fft.rfft(response, size, axis=0)) ** 2, axis=1)
    levels = []
    for centre in BANDS_HZ:
        on = (hz >= centre * 2.0 ** (-1.0 / 6.0)) & (hz < centre * 2.0 ** (1.0 / 6.0))
        whole = np.sum(felt[on])
        levels.append((np.sum(heard[on]) / whole, np.sum(through[on] * felt[on]) / whole, np.mean(through[on])))
    return tuple(0.5 * db(np.array(levels)).T)


def _filtering(measured, weighted, even):
    """How much pressure and force differ in colour, and whether the impulse response says so."""
    spread = float(np.ptp(measured))
    strongest, weakest = BANDS_HZ[np.argmax(measured)], BANDS_HZ[np.argmin(measured)]
    what = "pressure over force: strongest less weakest third octave, 79 Hz to 5 kHz"
    note = f"strongest at {strongest:.0f} Hz, weakest at {weakest:.0f} Hz"
    numbers = [Number(what, spread, "dB", PAPER_FILTER, bool(spread > 10.0), note)]
    for expected, words, bound in (
        (weighted, "|H| at the partials", 2.0),
        (even, "|H| averaged evenly over each band", None),
    ):
        off = measured - expected
        most = int(np.argmax(np.abs(off)))
        rms, note = float(np.sqrt(np.mean(off**2))), f"largest {off[most]:+.1f} dB at {BANDS_HZ[most]:.0f} Hz"
        agrees = None if bound is None else rms < bound
        what = f"pressure over force against {words}: rms over the bands"
        numbers.append(Number(what, rms, "dB", PAPER_FILTER, agrees, note))
    return numbers


def _gains(force_gain, pressure_gain):
    said = "(sound files available)"
    return [
        Number("gain of the force as a sound", force_gain, "1/N", said, None, f"full scale is {1 / force_gain:.2f} N"),
        Number("gain of the pressure", pressure_gain, "1/Pa", said, None, f"full scale is {1 / pressure_gain:.3f} Pa"),
    ]
