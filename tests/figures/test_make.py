"""Figures from case to data, with shortened cases: what they must show whatever is drawn."""

import pathlib
from dataclasses import replace

import numpy as np
import pytest

from ukrt.errors import ParameterError
from ukrt.figures import figure_05, figure_06, figure_07, figure_08
from ukrt.figures.registry import NUMBERS, load_figure
from ukrt.figures.runs import Run

OURS = (2, 3, 5, 6, 7, 8)


class Short(Run):
    """Runs at most so many seconds of each case."""

    def __init__(self, seconds, progress=None):
        super().__init__("reference", progress)
        self.seconds = seconds

    def __call__(self, case):
        return super().__call__(replace(case, duration=min(case.duration, self.seconds)))


def number(data, words):
    (found,) = [one for one in data.numbers if one.what == words]
    return found


@pytest.mark.parametrize("wanted", OURS)
def test_modules_are_what_the_registry_promises(wanted):
    module = load_figure(wanted)
    assert module.NUMBER == wanted and module.TITLE


@pytest.mark.parametrize("wanted", [1, 4, 14, "6"])
def test_other_figures_are_refused(wanted):
    with pytest.raises(ParameterError, match="the figures there are: 2, 3, 5"):
        load_figure(wanted)


def test_every_figure_has_a_page():
    folder = pathlib.Path(figure_05.__file__).parent
    index = (folder / "README.md").read_text(encoding="utf-8")
    for wanted in NUMBERS:
        assert f"pages/figure_{wanted:02d}.md" in index
    for wanted in OURS:
        assert (folder / "pages" / f"figure_{wanted:02d}.md").read_text(encoding="utf-8").startswith("# Figure")


def test_figure_2_has_its_modes_as_peaks_and_shapes_of_3_are_normalised():
    data = load_figure(2).make(Run())
    level, at = np.abs(data.arrays["transfer_function"].values), data.arrays["frequency"].values
    for hz in data.arrays["modal_frequencies"].values:
        near = np.abs(at - hz) < 6.0
        assert 0 < np.argmax(level[near]) < np.count_nonzero(near) - 1
    for guitar in load_figure(3).choices().values():
        ends = np.abs([guitar.body.shapes_bass, guitar.body.shapes_treble])
        assert np.allclose(np.max(ends, axis=0), 1.0)


@pytest.fixture(scope="module")
def bridge():
    return figure_05.make(Short(1.5))


def test_figure_5_shows_what_the_paper_says(bridge):
    assert number(bridge, "rigid bridge: its spectrum re that of one string").agrees
    assert number(bridge, "one string: first partial").agrees
    assert number(bridge, "one string: peaks at body modes, of 10").value >= 5
    frequencies, spectra = bridge.arrays["frequency"].values, bridge.arrays["spectra"].values
    at, _ = figure_05.new_peaks((frequencies, spectra[:, 1]), (frequencies, spectra[:, 2]))
    for fundamental in (110.1, 147.0):  # A2 and D3, which no partial of E2 hides
        assert np.min(np.abs(at - fundamental)) < 1.5


def test_the_same_spectrum_has_no_new_peaks(bridge):
    one = bridge.arrays["frequency"].values, bridge.arrays["spectra"].values[:, 1]
    assert len(figure_05.new_peaks(one, one)[0]) == 0


def test_a_peak_is_found_where_it_is_put(bridge):
    frequencies, amplitudes = bridge.arrays["frequency"].values, bridge.arrays["spectra"].values[:, 1].copy()
    added = amplitudes + 1e-8 * np.exp(-(((frequencies - 1200.0) / 0.7) ** 2))
    at, levels = figure_05.new_peaks((frequencies, amplitudes), (frequencies, added))
    assert at == pytest.approx([1200.0], abs=0.5)
    assert levels == pytest.approx([20.0 * np.log10(1e-8 / np.max(amplitudes))], abs=0.5)


def test_figures_6_and_7_keep_and_lose_energy():
    kept, lost = figure_06.make(Short(0.3)), figure_07.make(Short(0.4))
    assert all(one.agrees for one in kept.numbers if one.agrees is not None)
    total = lost.arrays["energies"].values[:, -1]
    free = lost.arrays["time"].values > 0.0101
    assert np.all(np.diff(total[free][::100]) < 0.0)
    assert number(lost, "strings: Y falls in 0.25 s by").agrees


def test_figure_8_falls_to_the_frequency_of_small_amplitudes():
    data = figure_08.make(Short(1.5))
    rise = number(data, "tension: largest rise at 5 N")
    assert rise.agrees and not number(data, "tension: largest rise at 5 N, ES of 32 kN").agrees
    assert number(data, "tension oscillates at so many times the fundamental").agrees
    parts = [one.value for one in data.numbers if one.what.startswith(("- of a flexible", "- more from"))]
    weak = data.arrays["frequency_1N"].values
    assert weak[-1] == pytest.approx(sum(parts), abs=0.01)  # 1 N is nearly small
    strong = data.arrays["frequency_5N"].values
    assert np.all(np.diff(strong[5:-5:10]) < 0.0) and strong[-1] > weak[-1]


def test_progress_names_the_case():
    told = []
    Run("reference", lambda name, share: told.append((name, share)))(
        figure_06.oblique_case("short", False, duration=0.02)
    )
    assert told[-1] == ("short", 1.0) and {name for name, _ in told} == {"short"}
