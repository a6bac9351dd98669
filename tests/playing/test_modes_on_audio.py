"""Bends of single strings, measured on the force with which the strings move the bridge.

A note's pitch relative to the same note unbent is the median over its partials 1 to 6. Where a body mode lies beside
one of them it is drawn aside (partial 1 near the air mode by up to 40 cents), as on any guitar; the others say how high
the note is.
"""

import functools

import numpy as np
import pytest
from measure.poles_from_signal import fit_poles

from ukrt.engine.engine import Engine
from ukrt.model.presets import load_preset

OPEN = (64, 59, 55, 50, 45, 40)  # of channels 1 to 6
PARTIALS = np.arange(1, 7)
RANGE = 12  # semitones
FROM, TO = 0.3, 1.6  # s after the release
LIMIT, OTHERS_LIMIT = 5.0, 0.2  # cents
FAR = 50.0  # cents between partials that do not meet


@functools.lru_cache(maxsize=1)
def engine():
    settings = {"playing.midi_mode": "guitar", "playing.idle_strings": "damped"}
    return Engine(load_preset("classical", settings), signal="strings")


def hertz(channel, fret, cents=0.0):
    return 440.0 * 2.0 ** ((OPEN[channel] + fret - 69 + cents / 100.0) / 12.0)


def play(notes, bends):
    """Strings' forces [N] after the release of ``notes`` (channel, fret), with ``bends`` (channel, cents) 0.1 s later:
    the strings' forces, and the cents that were sent in truth."""
    one, sent = engine(), {}
    one.reset()
    for channel, fret in notes:
        for controller, value in ((101, 0), (100, 0), (6, RANGE)):
            one.send(0, 0xB0 | channel, controller, value)
        one.send(0, 0x90 | channel, OPEN[channel] + fret, 60)
    for channel, cents in bends:
        value = round(cents / (100.0 * RANGE) * 8192) + 8192
        one.send(round(0.1 * one.sample_rate), 0xE0 | channel, value & 127, value >> 7)
        sent[channel] = (value - 8192) / 8192 * 100.0 * RANGE
    out = np.empty((one.lead_frames + round((TO + 0.01) * one.sample_rate), one.channels))
    one.process_into(out)
    return out[one.lead_frames :], sent


def partials(force, f1):
    """Frequencies [Hz] of the strongest component near each partial of ``f1``."""
    found = [fit_poles(force, 48000.0, n * f1, max(0.1 * f1, 12.0), FROM, TO)[0] for n in PARTIALS]
    return np.array([one.frequency_hz for one in found])


@pytest.mark.parametrize(("channel", "fret"), [(0, 2), (1, 7), (2, 0), (3, 2), (4, 7), (5, 2)])
def test_the_pitch_follows_the_bends_of_its_string(channel, fret):
    """Within 5 cents (in truth 2.4, on G3 bent by three frets, where the nylon's stiffness tells), also where the
    fundamental is a wolf: F#2 beside the air mode."""
    plain = partials(play([(channel, fret)], [])[0][:, 5 - channel], hertz(channel, fret))
    for cents in (-200.0, 100.0, 300.0):
        force, sent = play([(channel, fret)], [(channel, cents)])
        bent = partials(force[:, 5 - channel], hertz(channel, fret, sent[channel]))
        heard = np.median(1200.0 * np.log2(bent / plain))
        assert abs(heard - sent[channel]) < LIMIT


@pytest.mark.parametrize(
    ("bent", "other"), [((0, 1), (4, 3)), ((4, 3), (0, 1)), ((2, 3), (5, 1)), ((5, 1), (2, 4)), ((1, 3), (3, 0))]
)
def test_a_bend_leaves_other_strings_alone(bent, other):
    """Every partial of the other string that is not near one of the bent string's, before or after."""
    both = [bent, other]
    plain, _ = play(both, [])
    moved, sent = play(both, [(bent[0], 100.0)])
    own = PARTIALS * hertz(*other)
    bends = np.outer((hertz(*bent), hertz(*bent, sent[bent[0]])), np.arange(1, 40)).ravel()
    apart = np.min(np.abs(1200.0 * np.log2(own[:, None] / bends)), axis=1) > FAR
    assert np.any(apart)
    before, after = (partials(force[:, 5 - other[0]], hertz(*other)) for force in (plain, moved))
    assert np.max(np.abs(1200.0 * np.log2(after / before))[apart]) < OTHERS_LIMIT
