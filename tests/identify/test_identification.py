"""Modes that are known come back: Table I of the paper under noise, other quantities and forms of measurement, sixty
modes as far as they can be told apart; laws that hold for any guitar."""

import dataclasses

import numpy as np
import pytest
from identify.bridge_responses import (
    THREE,
    Modes,
    add_noise,
    as_measurement,
    errors,
    impulse_responses,
    measure,
    sixty_modes,
    table_i,
)

from ukrt.errors import MeasurementError
from ukrt.identify import identify
from ukrt.identify.measurement import PATHS, Measurement

BOUNDS = np.array([0.0005, 0.03, 0.05])[:, None]  # frequency, damping, mass


@pytest.mark.parametrize("seed", range(4))
def test_table_i_under_noise(seed):
    modes = table_i()
    found = identify(measure(modes, seed, seconds=2.0))
    assert len(found.frequencies_hz) == 10
    assert np.all(np.abs(errors(found, modes)) < BOUNDS)
    assert np.abs(found.shapes - modes.shapes).max() < 0.01
    assert not found.notes


@pytest.mark.parametrize("quantity,rate", [("displacement", 44100), ("acceleration", 44100), ("velocity", 96000)])
def test_any_quantity_and_rate(quantity, rate):
    modes = table_i()
    found = identify(measure(modes, quantity=quantity, rate=rate, seconds=1.0))
    assert np.all(np.abs(errors(found, modes)) < BOUNDS)


@pytest.mark.parametrize("paths", [("bass-bass", "bass-treble"), ("treble-bass", "treble-treble"), tuple(PATHS)])
def test_any_paths_that_tell_all(paths):
    modes = table_i()
    found = identify(measure(modes, 1, paths))
    assert np.all(np.abs(errors(found, modes)) < BOUNDS)
    assert np.abs(found.shapes - modes.shapes).max() < 0.02


def test_driving_points_alone_leave_the_sign_open_and_say_so():
    modes = table_i()
    found = identify(measure(modes, 2, ("bass-bass", "treble-treble")))
    assert np.all(np.abs(errors(found, modes)) < BOUNDS)
    assert np.abs(found.shapes - np.abs(modes.shapes)).max() < 0.02
    assert len(found.notes) == 1 and "sign" in found.notes[0]


def test_one_driving_point_tells_its_own_end_and_says_so():
    modes = table_i()
    found = identify(measure(modes, 3, ("bass-bass",)))
    frequency, damping, _ = errors(found, modes)
    assert np.abs(frequency).max() < 0.0005 and np.abs(damping).max() < 0.03
    at_the_end = modes.mass / modes.shapes[:, 0] ** 2  # the mass of a mode whose shape is 1 at the bass end
    assert found.modal_masses == pytest.approx(at_the_end, rel=0.05)
    assert np.all(found.shapes == 1.0) and "treble end is taken to move alike" in found.notes[0]


def test_errors_fall_with_the_noise():
    modes = table_i()
    sizes = [
        np.sqrt(np.mean(np.square(errors(identify(measure(modes, 4, decibels=db)), modes)), axis=1)) for db in (40, 80)
    ]
    assert np.all(sizes[1] < 0.03 * sizes[0])  # a hundredth of the noise


def test_uncertainties_are_the_size_of_the_errors():
    modes, scores = table_i(), []
    for seed in range(4):
        found = identify(measure(modes, 20 + seed))
        own = found.uncertainties
        known = (own["frequencies_hz"] / modes.hz, own["damping_ratios"] / modes.zeta, own["modal_masses"] / modes.mass)
        scores.append([error / one for error, one in zip(errors(found, modes), known, strict=True)])
    rms = np.sqrt(np.mean(np.square(scores), axis=(0, 2)))
    assert np.all((rms > 0.5) & (rms < 3.0))


def test_units_scale_masses_alone():
    measurement = measure(table_i(), 5)
    one, other = (
        identify(measurement),
        identify(dataclasses.replace(measurement, responses=4.0 * measurement.responses)),
    )
    assert other.modal_masses == pytest.approx(one.modal_masses / 4.0, rel=1e-6)
    assert other.frequencies_hz == pytest.approx(one.frequencies_hz, rel=1e-9)
    assert other.shapes == pytest.approx(one.shapes, abs=1e-6)


def test_swapped_ends_swap_shapes():
    measurement = measure(table_i(), 6)
    swapped = dataclasses.replace(measurement, responses=measurement.responses[:, ::-1])
    one, other = identify(measurement), identify(swapped)
    assert other.frequencies_hz == pytest.approx(one.frequencies_hz, rel=1e-6)
    assert other.shapes == pytest.approx(one.shapes[:, ::-1], abs=1e-4)


def test_complexity_is_the_phase_of_the_modes():
    whole = add_noise(impulse_responses(table_i(), phase=np.radians(10.0)), 48000, 60.0, 0)
    assert identify(as_measurement(whole)).complexity_deg == pytest.approx(np.full(10, 10.0), abs=0.5)


def test_a_late_response_is_noticed_and_put_right():
    modes = table_i()
    early = impulse_responses(modes)
    late = np.concatenate([np.zeros((15, 2, 2)), early])[: len(early)]  # 0.3125 ms
    measurement = as_measurement(add_noise(late, 48000, 40.0, 7))
    (note,) = identify(measurement).notes
    assert float(note.split("--delay ")[1]) == pytest.approx(0.3125, rel=0.1)
    found = identify(measurement, delay=15 / 48000)
    assert not found.notes and np.all(np.abs(errors(found, modes)) < BOUNDS)


def test_a_response_without_noise_gives_no_ghosts():
    modes = table_i()
    found = identify(measure(modes, decibels=200.0))
    assert len(found.frequencies_hz) == 10
    assert np.abs(errors(found, modes)).max() < 1e-4


def test_the_strongest_modes_on_demand():
    modes = table_i()
    found = identify(measure(modes, 8), modes=3)
    energy = 1.0 / (modes.mass**2 * modes.zeta * modes.hz)
    assert found.frequencies_hz == pytest.approx(np.sort(modes.hz[np.argsort(-energy)[:3]]), rel=1e-4)
    assert np.all(
        np.abs(errors(found, Modes(*(v[np.argsort(-energy)[:3]] for v in dataclasses.astuple(modes))))) < BOUNDS
    )


@pytest.mark.parametrize("seed", [0])
def test_sixty_modes_as_far_as_they_can_be_trusted(seed):
    modes = sixty_modes(seed).below(1200.0)
    found = identify(measure(sixty_modes(seed), seed), max_hz=1300.0)
    off = np.abs(errors(found, modes))
    assert np.all(np.isfinite(off))
    assert np.all(np.mean(off < BOUNDS, axis=1) > 0.9)
    assert not np.any(np.min(np.abs(found.frequencies_hz[:, None] / sixty_modes(seed).hz - 1.0), axis=1) > 0.02)


def test_modes_above_the_band_do_not_disturb():
    modes = sixty_modes(3)
    found = identify(measure(modes, 3), max_hz=800.0)
    off = np.abs(errors(found, modes.below(800.0)))
    assert len(found.frequencies_hz) == 9 and np.all(off < BOUNDS)


def refusal(measurement, **options):
    with pytest.raises(MeasurementError) as caught:
        identify(measurement, **options)
    message = str(caught.value)
    assert "\n" not in message
    return message


def test_what_is_refused():
    modes = table_i()
    assert "lasts 0.1 s" in refusal(measure(modes, seconds=0.1))
    assert "record longer" in refusal(measure(modes, seconds=0.02), min_hz=800.0)
    assert "sample rate of 1600 Hz" in refusal(measure(modes, rate=1600))
    assert "stand out" in refusal(measure(modes), modes=40)
    noise = np.random.default_rng(0).standard_normal((96000, 3))
    assert "no mode" in refusal(Measurement(noise, 48000.0, THREE))
    measured = measure(modes)
    assert "wrong sign" in refusal(dataclasses.replace(measured, responses=-measured.responses))
    assert "highest frequency must be larger" in refusal(measured, min_hz=500.0, max_hz=400.0)
