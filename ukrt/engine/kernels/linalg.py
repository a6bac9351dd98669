"""Small symmetric matrices in a flat array: Cholesky factors, triangular solves, inverses. Rows are ROW apart.

A pivot that vanishes means a redundant row (two contacts at one place): it is left out, as a pseudo-inverse would.
"""

import math

from ukrt.engine.kernels.jit import kernel

ROW = 8
_TINY = 1e-11


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
