"""Fig. 5: how the bridge moves under a plucked E2: rigid bridge, one string on the body, all six strings."""

import numpy as np

from ..experiment.case import Case, ForceRamp, Point, Record
from ..experiment.result import Quantity
from ..model.strings import ideal_open_hz
from .cases import paper_guitar
from .data import FigureData, Number
from .spectra import amplitude_spectrum, db, highest_near

NUMBER = 5
TITLE = "Motion at the bridge under E2"
FORCE, DURATION, TOP_HZ = 5.0, 8.0, 1800.0  # N, s, Hz
PANELS = ("rigid bridge", "one string on the body", "six strings on the body")
_RESOLUTION_HZ = 1.0  # a Hann window of 8 s is 0.25 Hz wide at its feet; losses widen partials by less than 1 Hz
_NEW_DB = 6.0  # so far above the spectrum of one string a peak must stand to count as new
_ABOUT_DB = 15.0  # the paper reads a level from an axis of 200 dB
_BODY_DB = 1.0  # so far above the curve on both sides a body mode must stand to count as a peak


def bridge_case(name, strings=(), bridge="body", guitar=None, duration=DURATION):
    """Open E2, a Y pluck of 5 N, linear strings; the motion of its end at the bridge is kept."""
    return Case(
        name,
        duration,
        guitar or paper_guitar(),
        strings=strings,
        bridge=bridge,
        tension_modulation=False,
        plucks=[ForceRamp("E2", force_y=FORCE)],
        record=Record(rate_hz=1e4, displacement=[Point("E2", 1.0)], bridge_force=False),
    )


def bridge_spectrum(result):
    """Frequencies up to 1800 Hz and amplitudes [m] of the whole record under a Hann window, pluck included."""
    frequencies, amplitudes = amplitude_spectrum(result["displacement"][:, 0], result.rate_hz)
    heard = frequencies <= TOP_HZ
    return frequencies[heard], amplitudes[heard]


def make(run):
    """Three runs."""
    cases = (
        bridge_case(PANELS[0], ("E2",), "rigid"),
        bridge_case(PANELS[1], ("E2",)),
        bridge_case(PANELS[2]),
    )
    results = [run(case) for case in cases]
    spectra = [bridge_spectrum(result) for result in results]
    arrays = {"frequency": Quantity(spectra[0][0], "Hz")}
    arrays["spectra"] = Quantity(np.stack([amplitudes for _, amplitudes in spectra], axis=1), "m", PANELS)
    numbers = (*_rigid(results, spectra), *_one_string(cases[1], *spectra[1]), *coupling(cases[2], *spectra[1:]))
    return FigureData(arrays, numbers, cases=cases)


def _rigid(results, spectra):
    motion = np.abs(results[0]["displacement"][:, 0])
    largest = float(np.max(motion[results[0].times <= 1.0]))
    what, paper = "rigid bridge: largest motion in the first second", "nil; drift below 2.0e-13"
    note = f"rounding; {np.max(motion):.2g} m in the whole run"
    yield Number(what, largest, "m", paper, largest < 2e-13, note)
    heard = spectra[0][0] > 20.0
    level = float(db(np.max(spectra[0][1][heard]) / np.max(spectra[1][1])))
    what = "rigid bridge: its spectrum re that of one string"
    yield Number(what, level, "dB", "virtually nil", level < -200.0, "largest of each, above 20 Hz")


def _one_string(case, frequencies, amplitudes):
    partials = partial_peaks(frequencies, amplitudes)
    first = float(partials[0])
    note = "held at the bridge it would sound above 82.5 Hz; the body, a spring below its first mode, lowers it"
    yield Number("one string: first partial", first, "Hz", "82", round(first) == 82, note)
    spacing = float(np.polyfit(np.arange(1, len(partials) + 1), partials, 1)[0])
    near = abs(spacing / first - 1.0) < 0.02
    what = f"one string: spacing of its {len(partials)} partials"
    yield Number(what, spacing, "Hz", "near harmonic", near, "slope of a line through them")
    modes_hz = case.instrument.body.frequencies_hz
    found = body_peaks(frequencies, amplitudes, partials, modes_hz)
    what, note = f"one string: peaks at body modes, of {len(modes_hz)}", "Hz: " + ", ".join(f"{hz:.1f}" for hz in found)
    yield Number(what, len(found), "", "smaller peaks", len(found) >= len(modes_hz) / 2, note)


def partial_peaks(frequencies, amplitudes, spacing_hz=82.7):
    """Where a string's partials peak [Hz]: ndarray, up to the end of the spectrum."""
    count = int((frequencies[-1] - 0.3 * spacing_hz) / spacing_hz)
    return np.array(
        [highest_near(frequencies, amplitudes, n * spacing_hz, 0.15 * spacing_hz)[0] for n in range(1, count + 1)]
    )


def body_peaks(frequencies, amplitudes, partials, modes_hz):
    """Peaks within 2.5 % of body modes, apart from partials [Hz]: list of float."""
    found = []
    for hz in modes_hz:
        near = (np.abs(frequencies - hz) < 0.025 * hz) & (_distance(frequencies, partials) > 4.0 * _RESOLUTION_HZ)
        levels, at = db(amplitudes[near]), frequencies[near]
        k = 1 + np.flatnonzero((levels[1:-1] > levels[:-2]) & (levels[1:-1] >= levels[2:]))
        stands = [n for n in k if min(levels[n] - levels[:n].min(), levels[n] - levels[n:].min()) > _BODY_DB]
        if stands:
            found.append(float(at[max(stands, key=lambda n: levels[n])]))
    return found


def coupling(case, one, six):
    """What the other strings add (iterator of Number); Fig. 3 asks for it with other shapes.

    ``one`` and ``six`` are the spectra (frequencies, amplitudes) with one string and with all.
    """
    at, levels = new_peaks(one, six)
    note = f"{_NEW_DB:g} dB or more above the spectrum of one string, up to {TOP_HZ:g} Hz"
    yield Number("six strings: new peaks", len(at), "", "new peaks, from the other strings", len(at) > 0, note)
    paper, highest_mode = "about -100", max(case.instrument.body.frequencies_hz)
    among = levels[at <= highest_mode]
    for words, chosen in (("", levels), (" among the body modes", among)):
        middle, note = (
            float(np.median(chosen)),
            f"re the strongest partial; lowest of {len(chosen)}: {min(chosen):.0f} dB",
        )
        near = abs(middle + 100.0) < _ABOUT_DB
        yield Number(f"six strings: median level of new peaks{words}", middle, "dB", paper, near, note)
    highest, hz = float(np.max(levels)), float(at[np.argmax(levels)])
    near, note = abs(highest + 100.0) < _ABOUT_DB, f"at {hz:.1f} Hz, a partial of {_owner(case, hz)}"
    yield Number("six strings: highest new peak", highest, "dB", paper, near, note)


def new_peaks(one, six):
    """Peaks that six strings have and one has not: frequencies [Hz] and levels re the strongest partial [dB]."""
    frequencies, levels = six[0], db(six[1])
    reach = int(_RESOLUTION_HZ / (frequencies[1] - frequencies[0]))
    summit, before = (_highest_within(reach, some) for some in (levels, db(one[1])))
    inner = slice(reach, len(levels) - reach)
    is_new = (levels[inner] == summit) & (levels[inner] > before + _NEW_DB)
    return frequencies[inner][is_new], levels[inner][is_new] - np.max(levels)


def _highest_within(reach, values):
    return np.lib.stride_tricks.sliding_window_view(values, 2 * reach + 1).max(axis=1)


def _owner(case, hz):
    """The string that has a harmonic nearest to ``hz`` (str)."""

    def off(string):
        fundamental = ideal_open_hz(string)
        return abs(hz / (fundamental * max(1, round(hz / fundamental))) - 1.0)

    return min(case.instrument.strings, key=off).name


def _distance(frequencies, others):
    return np.min(np.abs(np.asarray(frequencies)[..., None] - others), axis=-1)


def draw(data, figure):
    """Three panels on the paper's axes."""
    from .style import BLUE, GREY, RED, mark

    figure.set_size_inches(6.6, 6.6)
    frequencies, spectra = data.arrays["frequency"].values, data.arrays["spectra"].values
    panels = figure.subplots(3, 1, sharex=True)
    for k, (panel, words) in enumerate(zip(panels, PANELS, strict=True)):
        panel.semilogy(frequencies, np.maximum(spectra[:, k], 1e-40), color=(BLUE, BLUE, RED)[k], lw=0.7)
        if k == 2:
            panel.semilogy(frequencies, spectra[:, 1], color=BLUE, lw=0.7)
        low = -40 if k == 0 else -20
        panel.set(ylabel="| Y$_6$(f) |  [m]", xlim=(0, TOP_HZ), ylim=(10.0**low, 1.0))
        panel.set_yticks([1.0, 10.0 ** (low / 2), 10.0**low])
        mark(panel, words + ("  (blue: one string)" if k == 2 else ""))
    for hz in data.cases[1].instrument.body.frequencies_hz:
        panels[1].axvline(hz, color=GREY, lw=0.6, ls=":", zorder=0)
    panels[1].text(0.985, 0.06, "dotted: body modes, Table I", transform=panels[1].transAxes, ha="right", fontsize=8)
    panels[-1].set_xlabel("Frequency  [Hz]")
