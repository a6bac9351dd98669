"""Small symmetric matrices in a flat array: Cholesky factors, triangular solves, axes. Rows are ROW apart.

A pivot that vanishes means a redundant row (two contacts at one place): it is left out, as a pseudo-inverse would.
"""

import math

from ukrt.engine import layout as at
from ukrt.engine.kernels.jit import kernel

ROW = 8
_ROW_OUT = at.SCRATCH + 1088
_TINY = 1e-11
_SWEEPS = 12  # of Jacobi's method at most; six are enough for seven rows


@kernel
def cholesky(d, m, n):
    """Replace the matrix at ``m`` by its lower factor; redundant rows become zero."""
    for j in range(n):
        full = d[m + ROW * j + j]
        pivot = full
        for k in range(j):
            pivot -= d[m + ROW * j + k] ** 2
        if pivot > _TINY * full and pivot > 0.0:
            root = math.sqrt(pivot)
            d[m + ROW * j + j] = root
            for r in range(j + 1, n):
                value = d[m + ROW * r + j]
                for k in range(j):
                    value -= d[m + ROW * r + k] * d[m + ROW * j + k]
                d[m + ROW * r + j] = value / root
        else:
            for r in range(j, n):
                d[m + ROW * r + j] = 0.0
        for k in range(j + 1, n):
            d[m + ROW * j + k] = 0.0


@kernel
def solve_lower(d, m, n, b, step):
    """Solve C x = b in place; the vector's elements are ``step`` apart. Redundant rows give 0."""
    for j in range(n):
        value = d[b + step * j]
        for k in range(j):
            value -= d[m + ROW * j + k] * d[b + step * k]
        pivot = d[m + ROW * j + j]
        d[b + step * j] = value / pivot if pivot != 0.0 else 0.0


@kernel
def solve_upper(d, m, n, b, step):
    """Solve C^T x = b in place."""
    for j in range(n - 1, -1, -1):
        value = d[b + step * j]
        for k in range(j + 1, n):
            value -= d[m + ROW * k + j] * d[b + step * k]
        pivot = d[m + ROW * j + j]
        d[b + step * j] = value / pivot if pivot != 0.0 else 0.0


@kernel
def whiten(d, m, n, x):
    """Replace the symmetric matrix at ``x`` by C^-1 x C^-T, C the factor at ``m``."""
    for k in range(n):
        solve_lower(d, m, n, x + k, ROW)
    for k in range(n):
        solve_lower(d, m, n, x + ROW * k, 1)


@kernel
def _turn(d, m, n, u, p, q):
    """One rotation of Jacobi's method: element (p, q) of the matrix at ``m`` becomes zero."""
    theta = 0.5 * (d[m + ROW * q + q] - d[m + ROW * p + p]) / d[m + ROW * p + q]
    t = 1.0 / (abs(theta) + math.sqrt(theta * theta + 1.0))
    t = t if theta >= 0.0 else -t
    c = 1.0 / math.sqrt(t * t + 1.0)
    s = t * c
    for k in range(n):
        a, b = d[m + ROW * k + p], d[m + ROW * k + q]
        d[m + ROW * k + p], d[m + ROW * k + q] = c * a - s * b, s * a + c * b
    for k in range(n):
        a, b = d[m + ROW * p + k], d[m + ROW * q + k]
        d[m + ROW * p + k], d[m + ROW * q + k] = c * a - s * b, s * a + c * b
    for k in range(n):
        a, b = d[u + ROW * k + p], d[u + ROW * k + q]
        d[u + ROW * k + p], d[u + ROW * k + q] = c * a - s * b, s * a + c * b


@kernel
def principal_axes(d, m, n, u):
    """Turn the symmetric matrix at ``m`` into its eigenvalues; the axes become the columns at ``u``, largest first."""
    for j in range(n):
        for k in range(n):
            d[u + ROW * j + k] = 1.0 if j == k else 0.0
    for _ in range(_SWEEPS):
        turned = False
        for p in range(n):
            for q in range(p + 1, n):
                size = abs(d[m + ROW * p + p]) + abs(d[m + ROW * q + q])
                if abs(d[m + ROW * p + q]) > 1e-15 * size:
                    _turn(d, m, n, u, p, q)
                    turned = True
        if not turned:
            break
    for j in range(n):
        largest = j
        for k in range(j + 1, n):
            if d[m + ROW * k + k] > d[m + ROW * largest + largest]:
                largest = k
        a, b = (ROW + 1) * j, (ROW + 1) * largest
        d[m + a], d[m + b] = d[m + b], d[m + a]
        for k in range(n):
            a, b = u + ROW * k + j, u + ROW * k + largest
            d[a], d[b] = d[b], d[a]


@kernel
def along_axis(d, m, n, u, j):
    """The symmetric matrix at ``m`` along axis ``j`` of those at ``u``: u_j^T m u_j."""
    total = 0.0
    for p in range(n):
        for q in range(n):
            total += d[u + ROW * p + j] * d[m + ROW * p + q] * d[u + ROW * q + j]
    return total


@kernel
def turn_rows(d, m, n_rows, n, u):
    """Replace each row r of length ``n`` at ``m`` by r U: what was written along the old axes, along those at ``u``."""
    for p in range(n_rows):
        for j in range(n):
            value = 0.0
            for k in range(n):
                value += d[m + ROW * p + k] * d[u + ROW * k + j]
            d[_ROW_OUT + j] = value
        for j in range(n):
            d[m + ROW * p + j] = d[_ROW_OUT + j]
