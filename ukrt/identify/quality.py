"""How well identified modes explain the measurement, and what looks wrong: misfits, phases, a late beginning."""

import numpy as np

from .measurement import PATHS
from .residues import mode_responses

NOTED_PHASE = 10.0  # degrees that a late beginning turns the highest mode by, before it is mentioned


def body_responses(band, poles, shapes, paths):
    """Transfer functions of a body with these modes alone.

    Parameters
    ----------
    band : ukrt.identify.residues.Band
    poles : ndarray (n,) complex [1/s]
    shapes : ukrt.identify.shapes.Shapes
    paths : tuple of str

    Returns
    -------
    ndarray (m, k) complex
    """
    ends = np.array([PATHS[name] for name in paths])
    products = shapes.ends[:, ends[:, 0]] * shapes.ends[:, ends[:, 1]] / shapes.masses[:, None]
    return mode_responses(band, poles) @ products


def misfits(band, made, paths):
    """Per path the part of the measured energy in the band that ``made`` (m, k) leaves: dict of str to float [dB]."""
    left = np.sum(np.abs(band.values - made) ** 2, axis=0) / np.sum(np.abs(band.values) ** 2, axis=0)
    return {name: float(10.0 * np.log10(one)) for name, one in zip(paths, left, strict=True)}


def phase_deviation(strengths):
    """Mean distance of complex strengths (n, k) from the real axis, weighted by size: ndarray (n,) [degrees]."""
    size = np.abs(strengths)
    angles = np.degrees(np.arctan2(np.abs(strengths.imag), np.abs(strengths.real)))
    return np.sum(size * angles, axis=1) / np.sum(size, axis=1)


def late_words(strengths, poles, paths):
    """A sentence where the responses seem to come late, judged by the driving points, whose strengths are positive in
    real modes and turn in proportion to frequency by a delay; None where that is not worth mentioning.

    Parameters
    ----------
    strengths : ndarray (n, k) complex [1/kg]
    poles : ndarray (n,) complex [1/s]
    paths : tuple of str

    Returns
    -------
    str or None
    """
    driving = [n for n, name in enumerate(paths) if len(set(PATHS[name])) == 1]
    own, omega = strengths[:, driving], np.abs(poles)[:, None]
    weight = np.abs(own)
    late = -1e3 * float(np.sum(weight * omega * np.angle(own)) / np.sum(weight * omega**2))
    if np.degrees(1e-3 * late * omega.max()) < NOTED_PHASE:
        return None
    return f"the responses seem to come {late:.3g} ms late; if so, repeat with --delay {late:.3g}"
