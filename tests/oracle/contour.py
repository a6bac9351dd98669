"""All poles in a window: a system enters, contour integrals of N(s) count its poles, Newton polishes them."""

from dataclasses import replace

import numpy as np

from .continuous import characteristic, poles

RIGHT_EDGE = 20.0  # 1/s: right of every pole of a passive system
LARGEST_COUNT = 3  # poles a rectangle may hold when their polynomial is solved


def _power_sums(system, low, high, max_decay, order):
    """Power sums (about the centre, over the radius) of the poles in a rectangle, and those two."""
    left, right = -max_decay, RIGHT_EDGE
    corners = np.array([left + 1j * low, right + 1j * low, right + 1j * high, left + 1j * high, left + 1j * low])
    nodes, weights = np.polynomial.legendre.leggauss(16)
    points, factors = [], []
    for a, b in zip(corners[:-1], corners[1:], strict=True):
        panel = 4.0 if abs((b - a).real) > 0 else 12.0  # rad/s; poles may lie near the edges of constant frequency
        edges = a + (b - a) * np.linspace(0.0, 1.0, max(2, int(abs(b - a) / panel)) + 1)
        half = 0.5 * np.diff(edges)
        points.append(((edges[:-1] + half)[:, None] + half[:, None] * nodes).ravel())
        factors.append((half[:, None] * weights).ravel())
    points, factors = np.concatenate(points), np.concatenate(factors)
    centre = 0.5 * (left + right) + 0.5j * (low + high)
    radius = 0.5 * abs(complex(right - left, high - low))
    values = np.concatenate([characteristic(system, part) for part in np.array_split(points, points.size // 64 + 1)])
    scaled = (points - centre) / radius
    return [np.sum(factors * values * scaled**k) / (2j * np.pi) for k in range(order + 1)], centre, radius


def _count(sums):
    """The number of poles, or -1 where an edge runs too close to one for the integral to be a whole number."""
    count = int(round(sums[0].real))
    return count if abs(sums[0] - count) < 0.01 else -1


def _seeds(system, low, high, max_decay, sums, centre, radius):
    """Approximate poles of a rectangle whose power sums are known, splitting it while it holds too many."""
    count = _count(sums)
    if count <= LARGEST_COUNT:
        coefficients = [1.0]  # Newton's identities: from power sums to the polynomial
        for k in range(1, count + 1):
            coefficients.append(-sum(coefficients[k - j] * sums[j] for j in range(1, k + 1)) / k)
        return list(centre + radius * np.roots(coefficients))
    for share in (0.49, 0.43, 0.56, 0.37, 0.62, 0.3, 0.7):
        middle = low + share * (high - low)
        edges = ((low, middle), (middle, high))
        halves = [(a, b, _power_sums(system, a, b, max_decay, LARGEST_COUNT)) for a, b in edges]
        if all(_count(half[2][0]) >= 0 for half in halves):
            return [seed for a, b, half in halves for seed in _seeds(system, a, b, max_decay, *half)]
    raise RuntimeError(f"no clean cut between {low / 2 / np.pi} and {high / 2 / np.pi} Hz: poles too close together")


def poles_between(system, low_hz, high_hz, max_decay=150.0):
    """All poles with frequency in (low_hz, high_hz) and decay rate below max_decay [1/s], sorted by frequency.

    Counted by the argument principle, split until at most three share a rectangle, then Newton from the roots of the
    polynomial with the same power sums (Delves & Lyness 1967). The window's own edges must not touch a pole.
    """
    coarse = system if system.n_modes else replace(system, cut_hz=min(system.cut_hz, 60e3))
    low, high = 2.0 * np.pi * low_hz, 2.0 * np.pi * high_hz
    first = _power_sums(coarse, low, high, max_decay, LARGEST_COUNT)
    if _count(first[0]) < 0:
        raise RuntimeError(f"an edge of the window {low_hz} to {high_hz} Hz touches a pole: move it")
    seeds = _seeds(coarse, low, high, max_decay, *first)
    found = poles(system, seeds) if seeds else np.zeros(0, complex)
    found = found[np.argsort(found.imag)]
    if found.size > 1 and np.min(np.abs(np.diff(found)) / np.abs(found[1:])) < 1e-11:
        raise RuntimeError("two seeds reached the same pole")
    return found
