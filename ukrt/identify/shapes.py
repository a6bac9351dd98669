"""Real normalised shapes: strengths phi_drive phi_response / m of modes enter, their masses and shapes at the two ends
of the bridge leave. Between the ends a shape is linear: its largest value over the bridge, which is 1, is at an end."""

import dataclasses

import numpy as np

from .measurement import ENDS, PATHS


@dataclasses.dataclass(frozen=True)
class Shapes:
    """Masses and shapes; a mode that no mass fits (its driving points move the wrong way) has NaN.

    Attributes
    ----------
    masses : ndarray (n,) [kg]
    ends : ndarray (n, 2) [1]
        At the bass and at the treble end; the larger one is 1.
    """

    masses: np.ndarray
    ends: np.ndarray


def what_is_assumed(paths):
    """A sentence on what the paths leave open, or None."""
    entries = {tuple(sorted(PATHS[name])) for name in paths}
    if (0, 1) in entries:
        return None
    if len(entries) == 2:
        return (
            "no response from one end of the bridge to the other is given: the sign of the treble end's shape is not "
            "known and is taken to be the bass end's in every mode"
        )
    known = ENDS[entries.pop()[0]]
    other = ENDS[1 - ENDS.index(known)]
    return f"only the {known} end is measured: the {other} end is taken to move alike in every mode"


def real_shapes(strengths, paths):
    """Masses and shapes of modes.

    Parameters
    ----------
    strengths : ndarray (n, k) [1/kg]
    paths : tuple of str
        What the k strengths are. With the whole matrix the shape is its largest eigenvector, the nearest matrix of one
        mode; with one driving point and a path to the other end it follows from these two; what is not measured is
        taken as `what_is_assumed` says.

    Returns
    -------
    Shapes
    """
    by_entry = {}
    for column, name in zip(np.asarray(strengths).T, paths, strict=True):
        by_entry.setdefault(tuple(sorted(PATHS[name])), []).append(column)
    means = {entry: np.mean(columns, axis=0) for entry, columns in by_entry.items()}
    with np.errstate(invalid="ignore", divide="ignore"):
        scaled = _scaled(means.get((0, 0)), means.get((0, 1)), means.get((1, 1)))
        at = np.argmax(np.abs(scaled), axis=1)
        largest = np.take_along_axis(scaled, at[:, None], axis=1)
        return Shapes(1.0 / largest[:, 0] ** 2, scaled / largest)


def _scaled(bass, cross, treble):
    """Shapes over the root of the mass, phi / sqrt(m): ndarray (n, 2), NaN where a driving point is not positive."""
    if bass is not None and treble is not None and cross is not None:
        values, vectors = np.linalg.eigh(np.stack([bass, cross, cross, treble], axis=1).reshape(-1, 2, 2))
        positive = np.where(values[:, -1] > -values[:, 0], values[:, -1], np.nan)
        return vectors[:, :, -1] * np.sqrt(positive)[:, None]
    if cross is None:
        bass, treble = (treble if bass is None else bass), (bass if treble is None else treble)
        return np.sqrt(np.stack([bass, treble], axis=1))
    if treble is None:
        return np.stack([np.sqrt(bass), cross / np.sqrt(bass)], axis=1)
    return np.stack([cross / np.sqrt(treble), np.sqrt(treble)], axis=1)
