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


def lateness(strengths, poles, paths):
    """By how much the responses come late, judged by the driving points, whose strengths are positive in real modes.

    Parameters
    ----------
    strengths : ndarray (n, k) complex [1/kg]
    poles : ndarray (n,) complex [1/s]
    paths : tuple of str

    Returns
    -------
    float [s]
        0 where the phase it makes is not worth mentioning.
    """
    driving = [n for n, name in enumerate(paths) if len(set(PATHS[name])) == 1]
    own, omega = strengths[:, driving], np.abs(poles)[:, None]
    weight = np.abs(own)
    late = -np.sum(weight * omega * np.angle(own)) / np.sum(weight * omega**2)
    return float(late) if np.degrees(abs(late) * omega.max()) >= NOTED_PHASE else 0.0
