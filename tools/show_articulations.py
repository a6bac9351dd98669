"""Draw and measure every articulation of the bundled demonstration against the plain note: pictures and a table leave.

    python tools/show_articulations.py FOLDER [--only NAME,..] [--preset NAME|FILE]

A picture for each section of tools/make_demonstration.py: spectrograms and levels of the sound, plain on the left,
played as the section says on the right. The table says, for each, the last note's level in its first 0.5 s, the centre
of its spectrum (of the energy, there), how fast it decays from 0.1 to 0.6 s, and its pitch from 0.15 s on, beside the
key.
"""

import argparse
import pathlib
import sys
from dataclasses import dataclass

import numpy as np
from rich.console import Console
from rich.table import Table

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "tests"))

from make_demonstration import SECTIONS, make_demonstration, starts
from measure.pitch_track import note_track

import ukrt
from ukrt.errors import UkrtError
from ukrt.figures.spectrogram import draw_spectrogram, spectrogram, top_of
from ukrt.figures.style import BLUE, SETTINGS, mark

RATE = 48000
LEVEL_SECONDS, HOP_SECONDS = 0.02, 0.005
PULL_SECONDS = 0.03  # and more, before a release


@dataclass(frozen=True)
class Measured:
    """A half of a section.

    Attributes
    ----------
    sound : ndarray (n,)
        Left ear [1 is full scale].
    level_db, centroid_hz, decay_db_s, cents : float
        Of its last note: see the tool's words.
    """

    sound: np.ndarray
    level_db: float
    centroid_hz: float
    decay_db_s: float
    cents: float


def measure(sound, note):
    """Measure the last note of a half; ``note`` is (start [s], key)."""
    start, key = note
    part = sound[round(start * RATE) : round((start + 0.5) * RATE)]
    spectrum = np.abs(np.fft.rfft(part * np.hanning(len(part)))) ** 2
    centroid = np.sum(np.fft.rfftfreq(len(part), 1.0 / RATE) * spectrum) / np.sum(spectrum)
    times, levels = level(sound[round(start * RATE) :])
    fit = (times > 0.1) & (times < 0.6)
    after = sound[round((start + 0.15) * RATE) :]
    _, off, weight = note_track(after, RATE, 440.0 * 2.0 ** ((key - 69) / 12), np.zeros(len(after)))
    loud = weight > 0.03 * weight.max()
    cents = np.average(off[loud], weights=weight[loud] ** 2)
    level_db = 10.0 * np.log10(np.mean(part**2))
    return Measured(sound, level_db, centroid, -np.polyfit(times[fit], levels[fit], 1)[0], cents)


def level(sound):
    """Level over time: seconds and dB re full scale."""
    n, hop = round(LEVEL_SECONDS * RATE), round(HOP_SECONDS * RATE)
    frames = np.lib.stride_tricks.sliding_window_view(sound, n)[::hop]
    return np.arange(len(frames)) * hop / RATE, 10.0 * np.log10(np.mean(frames**2, axis=1) + 1e-12)


def last_note(messages):
    """When the last note of a half begins [s], and its key."""
    return max((time, rest[0]) for time, kind, *rest in messages if kind == "on")


def draw(path, section, halves):
    """Spectrograms above, levels below."""
    import matplotlib
    from matplotlib.figure import Figure

    with matplotlib.rc_context(SETTINGS):
        figure = Figure(figsize=(11.0, 6.5))
        panels = figure.subplots(2, 2, sharex=True, height_ratios=[3, 1])
        drawn = [spectrogram(half.sound, RATE, window_s=0.04, hop_s=0.005) for half in halves]
        top = top_of(*(levels for _, _, levels in drawn))
        for column, half, one, words in zip(panels.T, halves, drawn, ("plain", section.name), strict=True):
            image = draw_spectrogram(column[0], *one, top)
            column[0].set_title(words)
            column[1].plot(*level(half.sound), color=BLUE)
            column[1].set(ylim=(-90.0, 0.0), ylabel="Level [dB]", xlabel="Time [s]")
            mark(column[1], f"{half.level_db:.1f} dB, {half.centroid_hz:.0f} Hz, decay {half.decay_db_s:.0f} dB/s")
        figure.colorbar(image, ax=panels[0].tolist(), label="Level [dB]")
        figure.savefig(path, dpi=90)


def show(results, console):
    table = Table("section", "level", "changes", "centre", "plain", "decay", "plain", "pitch", "plain")
    for name, (plain, played) in results.items():
        table.add_row(
            *(name, f"{played.level_db:.1f} dB", f"{played.level_db - plain.level_db:+.1f} dB"),
            *(f"{played.centroid_hz:.0f} Hz", f"{plain.centroid_hz:.0f} Hz"),
            *(f"{played.decay_db_s:.0f} dB/s", f"{plain.decay_db_s:.0f} dB/s"),
            *(f"{played.cents:+.1f} cents", f"{plain.cents:+.1f} cents"),
        )
    console.print(table)


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("folder", type=pathlib.Path, help="where the pictures go")
    parser.add_argument("--only", help="sections, with commas between them (default: all)")
    parser.add_argument("--preset", default="classical", help="a preset's name or a TOML file (default: classical)")
    options = parser.parse_args(arguments)
    wanted = options.only.split(",") if options.only else [section.name for section in SECTIONS]
    try:
        options.folder.mkdir(parents=True, exist_ok=True)
        make_demonstration().save(options.folder / "demonstration.mid")
        samples, _ = ukrt.render(options.folder / "demonstration.mid", options.preset, sample_rate=RATE)
    except (UkrtError, OSError) as error:
        sys.exit(f"show_articulations: {error}")
    results = {}
    for k, section in enumerate(SECTIONS):
        if section.name in wanted:
            edges = [round(time * RATE) for time in starts(k)]
            before = round(PULL_SECONDS * RATE)  # the next note's pull
            sounds = (samples[a : b - before, 0] for a, b in zip(edges, edges[1:], strict=False))
            notes = (last_note(half) for half in (section.plain, section.played))
            results[section.name] = [measure(*half) for half in zip(sounds, notes, strict=True)]
            draw(options.folder / f"{section.name.replace(' ', '_')}.png", section, results[section.name])
    show(results, Console(width=None if sys.stdout.isatty() else 140))


if __name__ == "__main__":
    main()
