"""Uncertainties of identified modes: the spread over model orders, and what the noise that the fit leaves does.

The spread alone is too small, for all orders see the same noise. The second part is the Cramer-Rao bound: frequency and
damping as further parameters of the least-squares fit, linearised, with the noise taken from what the fit leaves.
"""

import numpy as np

from .residues import fit_strengths, mode_responses, reals
from .shapes import real_shapes

SPREAD_ORDERS = 12  # of the sweep, the highest, that the spread is taken from
STEP = 1e-4  # of the decay rate, for derivatives by the pole
NAMES = ("frequencies_hz", "damping_ratios", "modal_masses", "shapes")


def uncertainties(band, sweep, chosen, beside, paths):
    """Standard uncertainties of modes.

    Parameters
    ----------
    band : ukrt.identify.residues.Band
    sweep : list of Poles
    chosen, beside : list of Track
        Modes, and others that share in the fit.
    paths : tuple of str

    Returns
    -------
    dict of str to ndarray
        Under `NAMES`: (n,) [Hz], (n,) [1], (n,) [kg], (n, 2) [1].
    """
    by_order = _spread(band, len(sweep), chosen, beside, paths)
    by_noise = _noise(band, chosen, beside, paths)
    both = np.hypot(by_order, by_noise)
    return dict(zip(NAMES, (both[:, 0], both[:, 1], both[:, 2], both[:, 3:]), strict=True))


def _row(poles, strengths, paths):
    """Frequencies, damping ratios, masses and shapes of modes: ndarray (n, 5)."""
    made, omega = real_shapes(strengths, paths), np.abs(poles)
    return np.stack([omega / (2.0 * np.pi), -poles.real / omega, made.masses, *made.ends.T], axis=1)


def _spread(band, count, chosen, beside, paths):
    """Standard deviations over the highest orders, robust: half of what lies between the 16th and 84th per cent."""
    rows, n = [], len(chosen)
    for order in range(max(count - SPREAD_ORDERS, 0), count):
        poles = np.array([one.at(order) for one in chosen + beside])
        rows.append(_row(poles[:n], fit_strengths(band, poles).values[:n], paths))
    known = np.isfinite(rows).any(axis=0)
    low, high = np.nanpercentile(np.where(known, rows, 0.0), (15.87, 84.13), axis=0)
    return np.where(known, (high - low) / 2.0, np.inf)


def _noise(band, chosen, beside, paths):
    """Standard errors (n, 5) from the Cramer-Rao bound."""
    poles, n = np.array([one.median for one in chosen + beside]), len(chosen)
    values, of_poles, of_strengths = _covariances(band, poles)
    omega, zeta = np.abs(poles), -poles.real / np.abs(poles)
    cosine, count = np.sqrt(1.0 - zeta**2), len(poles)
    decay, turn = np.maximum(of_poles.diagonal(), 0.0).reshape(2, count)
    of_omega = np.sqrt(zeta**2 * decay + cosine**2 * turn)  # |pole| from its two parts, whose errors are independent
    of_zeta = np.sqrt(cosine**2 * decay + zeta**2 * turn) / omega * cosine
    mean, total = _row(poles[:n], values[:n], paths), np.zeros((n, 5))
    for k in range(values.shape[1]):
        shifted = values[:n].copy()
        shifted[:, k] += of_strengths[:n, k]
        total += (_row(poles[:n], shifted, paths) - mean) ** 2
    return np.column_stack([of_omega[:n] / (2.0 * np.pi), of_zeta[:n], np.sqrt(total[:, 2:])])


def _covariances(band, poles):
    """Strengths (n, k) [1/kg], the covariance (2n, 2n) of the poles' real and imaginary parts [1/s^2], and the standard
    errors (n, k) of the strengths with the poles' errors in them."""
    basis = reals(np.concatenate([mode_responses(band, poles), band.outside()], axis=1))
    size = np.linalg.norm(basis, axis=0)
    left, upper = np.linalg.qr(basis / size)
    wanted, n = reals(band.values), len(poles)
    inverse = np.linalg.inv(upper) / size[:, None]
    values = inverse @ (left.T @ wanted)
    rest = wanted - left @ (left.T @ wanted)
    variance = np.sum(rest**2, axis=0) / max(len(wanted) - len(size) - 2 * n, 1)
    variance = np.maximum(variance, 1e-24 * np.mean(wanted**2, axis=0))  # of a record without noise
    slopes = _slopes(band, poles)
    inside = left.T @ slopes
    free = slopes.T @ slopes - inside.T @ inside
    doubled = np.concatenate([values[:n], values[:n]])
    information = sum(free * np.outer(one, one) / own for one, own in zip(doubled.T, variance, strict=True))
    root = np.sqrt(information.diagonal())
    of_poles = np.linalg.pinv(information / np.outer(root, root), hermitian=True) / np.outer(root, root)
    errors = []
    for strength, own in zip(doubled.T, variance, strict=True):
        moved = (inverse @ inside)[:n] * strength
        square = own * np.sum(inverse[:n] ** 2, axis=1) + np.einsum("ij,jk,ik->i", moved, of_poles, moved)
        errors.append(np.sqrt(np.maximum(square, 0.0)))
    return values[:n], of_poles, np.stack(errors, axis=1)


def _slopes(band, poles):
    """Derivatives of modes' transforms by the real and the imaginary part of their poles: ndarray (2 m, 2 n)."""
    step = STEP * np.abs(poles.real)
    by = [
        (mode_responses(band, poles + turn * step) - mode_responses(band, poles - turn * step)) / (2.0 * step)
        for turn in (1.0, 1j)
    ]
    return reals(np.concatenate(by, axis=1))
