"""From responses of the bridge to the modes of the body: a `Measurement` enters, an `Identification` leaves.

Realization over rising order, tracks of stable poles, strengths by least squares, real shapes: `README.md` says why.
"""

import dataclasses

import numpy as np

from ..errors import MeasurementError
from ..model.fields import legal
from ..model.parameters import Body
from .quality import body_responses, late_words, misfits, phase_deviation
from .realization import LEAST_OVERSAMPLING, free_decays, markov_parameters, realize
from .residues import Band, fit_complex_strengths, fit_strengths, make_band
from .shapes import Shapes, real_shapes, what_is_assumed
from .stabilization import distinct, stable_tracks, track_poles
from .uncertainty import uncertainties

LEAST_PERIODS = 8  # of the lowest frequency that a record must hold
ORDERS = 40  # in the sweep
MODES_PER_HZ = 1.0 / 25.0  # of the largest order: twice what a guitar has below 1 kHz
LEAST_MODES, MOST_MODES = 40, 150  # of the largest order
SAMPLES_PER_MODE = 8  # of a record, lest the Hankel matrix is hardly larger than the order
FEWEST_MODES = 10  # of the largest order in a short record
SIGNIFICANCE = 5.0  # standard errors that a mode's strength must reach in one path at least
LIMIT = 64  # modes of a Body


@dataclasses.dataclass(frozen=True)
class Identification:
    """Modes of the body and how far they can be trusted.

    Attributes
    ----------
    frequencies_hz, damping_ratios, modal_masses : ndarray (n,) [Hz, 1, kg]
    shapes : ndarray (n, 2) [1]
        At the bass and at the treble end.
    uncertainties : dict of str to ndarray
        Standard uncertainties of these four, under their names.
    complexity_deg : ndarray (n,) [degrees]
        Mean phase deviation from a real mode, weighted by strength.
    fits : dict of str to float
        Per path the part of the band's response that the body's modes alone leave unexplained, in dB.
    fits_with_rest : dict of str to float
        The same when what lies outside the band is fitted, too.
    notes : tuple of str
        Sentences on what was assumed or looks wrong.
    sweep : list of Poles
        By rising order.
    modes : list of Track
        How each mode went through the orders.
    band : Band
        What was fitted.
    paths : tuple of str
    """

    frequencies_hz: np.ndarray
    damping_ratios: np.ndarray
    modal_masses: np.ndarray
    shapes: np.ndarray
    uncertainties: dict
    complexity_deg: np.ndarray
    fits: dict
    fits_with_rest: dict
    notes: tuple
    sweep: list
    modes: list
    band: Band
    paths: tuple

    def responses(self):
        """Transfer functions in the band of a body with these modes alone: ndarray (m, k) complex."""
        omega, zeta = 2.0 * np.pi * self.frequencies_hz, self.damping_ratios
        poles = omega * (-zeta + 1j * np.sqrt(1.0 - zeta**2))
        return body_responses(self.band, poles, Shapes(self.modal_masses, self.shapes), self.paths)

    def body(self):
        """The modes as the model's `Body`, at six digits.

        Raises
        ------
        MeasurementError
            A mode is beyond what a body may have.
        """
        rule = legal(Body, "modal_masses")
        for hertz, mass in zip(self.frequencies_hz, self.modal_masses, strict=True):
            if not rule.low <= mass <= rule.high:
                raise MeasurementError(
                    f"the mode at {hertz:.4g} Hz has a mass of {mass:.3g} kg, but a body may have {rule.low:g} to "
                    f"{rule.high:g} kg: is the unit right (--scale, --quantity, --taps)?"
                )
        columns = self.frequencies_hz, self.damping_ratios, self.modal_masses, *self.shapes.T
        return Body(*(tuple(float(f"{value:.6g}") for value in column) for column in columns))


def identify(measurement, max_hz=1000.0, min_hz=40.0, modes=None, delay=0.0):
    """Identify the modes of a body.

    Parameters
    ----------
    measurement : Measurement
    max_hz, min_hz : float [Hz]
        Modes between these.
    modes : int, optional
        How many, the strongest; otherwise all that are stable and stand out of the noise.
    delay : float [s]
        By which the responses come late.

    Returns
    -------
    Identification

    Raises
    ------
    MeasurementError
        The record is too short or its rate too low, no mode is stable, fewer are than were asked for.
    """
    _check(measurement, max_hz, min_hz, delay)
    sweep = _sweep(measurement, max_hz, delay)
    tracks = track_poles(sweep)
    band = make_band(measurement, min_hz, max_hz, delay)
    stable = stable_tracks(tracks, len(sweep))
    if modes is not None and sum(min_hz <= one.frequency_hz <= max_hz for one in stable) < modes:
        stable = distinct([one for one in tracks if len(one.orders) > 1])
    chosen, beside = _choose(stable, band, measurement.paths, min_hz, max_hz, modes)
    return _result(measurement.paths, band, sweep, chosen, beside)


def _sweep(measurement, max_hz, delay):
    """Poles over rising order (list of Poles)."""
    decays, rate = free_decays(measurement, max_hz, delay)
    markov = markov_parameters(decays, measurement.paths)
    largest = int(np.clip(max_hz * MODES_PER_HZ, LEAST_MODES, MOST_MODES))
    largest = min(largest, len(markov) // SAMPLES_PER_MODE)
    if largest < FEWEST_MODES:
        raise MeasurementError(
            f"{_name(measurement)} holds {len(markov)} samples at {rate:g} Hz, as modes up to {max_hz:g} Hz need, but "
            f"{FEWEST_MODES * SAMPLES_PER_MODE} are needed: record longer"
        )
    step = -(-largest // ORDERS)
    return realize(markov, rate, [2 * n for n in range(step, largest + 1, step)])


def _check(measurement, max_hz, min_hz, delay):
    where = _name(measurement)
    rate, seconds = measurement.sample_rate, measurement.seconds - delay
    if not min_hz < max_hz:
        raise MeasurementError(f"modes from {min_hz:g} to {max_hz:g} Hz are none: the highest frequency must be larger")
    if rate < LEAST_OVERSAMPLING * max_hz:
        what = f"an admittance up to {rate / 2:g} Hz" if measurement.periodic else f"a sample rate of {rate:g} Hz"
        raise MeasurementError(
            f"{where} has {what}, which serves modes up to {rate / LEAST_OVERSAMPLING:.0f} Hz, but {max_hz:g} Hz were "
            "asked for: lower --max-hz"
        )
    if seconds * min_hz < LEAST_PERIODS:
        raise MeasurementError(
            f"{where} lasts {seconds:.3g} s after its beginning, but modes from {min_hz:g} Hz on need "
            f"{LEAST_PERIODS / min_hz:.3g} s: record longer, or raise --min-hz"
        )


def _name(measurement):
    return measurement.sources[0] if measurement.sources else "the measurement"


def _choose(tracks, band, paths, min_hz, max_hz, modes):
    """Tracks of the modes, and tracks beside them, which share in the fit but are not modes of the result."""
    inside = [one for one in tracks if min_hz <= one.frequency_hz <= max_hz]
    beside = [one for one in tracks if one.frequency_hz > max_hz]
    while inside and (weakest := _weakest(inside, beside, band, paths)) is not None:
        del inside[weakest]
    if not inside:
        raise MeasurementError(
            f"no mode from {min_hz:g} to {max_hz:g} Hz is stable over the model orders and moves with the force: it is "
            "noise, or it has the wrong sign (a negative --scale), or begins late (--delay)"
        )
    if modes is None:
        return inside, beside
    if len(inside) < modes:
        raise MeasurementError(
            f"{modes} modes were asked for, but only {len(inside)} from {min_hz:g} to {max_hz:g} Hz stand out: lower "
            "--modes"
        )
    poles = np.array([one.median for one in inside + beside])
    strengths = fit_strengths(band, poles).values[: len(inside)]
    energy = np.max(strengths**2, axis=1) / -poles[: len(inside)].real
    strongest = set(np.argsort(-energy)[:modes].tolist())
    beside += [one for n, one in enumerate(inside) if n not in strongest]
    return [one for n, one in enumerate(inside) if n in strongest], beside


def _weakest(inside, beside, band, paths):
    """Index of the track that is the least a mode, None where all are; they leave one by one, since each one's strength
    depends on the others.

    Significant a mode must also be when strengths may be complex: what is not real in true modes can look like a weak
    mode between them.
    """
    poles, n = np.array([one.median for one in inside + beside]), len(inside)
    found = fit_strengths(band, poles)
    certainty = np.max(np.abs(found.values[:n]) / found.errors[:n], axis=1)
    certainty[~np.isfinite(real_shapes(found.values[:n], paths).masses)] = 0.0
    if certainty.min() >= SIGNIFICANCE and n <= LIMIT:
        values, errors = fit_complex_strengths(band, poles)
        certainty = np.max(np.abs(values[:n]) / errors[:n], axis=1)
        if certainty.min() >= SIGNIFICANCE:
            return None
    return int(np.argmin(certainty))


def _result(paths, band, sweep, chosen, beside):
    poles = np.array([one.median for one in chosen + beside])
    n = len(chosen)
    found = fit_strengths(band, poles)
    made = real_shapes(found.values[:n], paths)
    complex_strengths = fit_complex_strengths(band, poles)[0][:n]
    alone = body_responses(band, poles[:n], made, paths)
    return Identification(
        frequencies_hz=np.abs(poles[:n]) / (2.0 * np.pi),
        damping_ratios=-poles[:n].real / np.abs(poles[:n]),
        modal_masses=made.masses,
        shapes=made.ends,
        uncertainties=uncertainties(band, sweep, chosen, beside, paths),
        complexity_deg=phase_deviation(complex_strengths),
        fits=misfits(band, alone, paths),
        fits_with_rest=misfits(band, found.fitted, paths),
        notes=tuple(filter(None, (what_is_assumed(paths), late_words(complex_strengths, poles[:n], paths)))),
        sweep=sweep,
        modes=chosen,
        band=band,
        paths=paths,
    )
