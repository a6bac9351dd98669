"""One pass over a string's modes per sample: correct q[k+1], predict q*[k+2], sum up what the constraints need.

Enter the state of one string and the forces the solver found; leave the new state and, per string, 2 (ports + pluck) +
2 vectors of partial sums. With x = q / sqrt(g), so that the step's compliance matrix G is the identity, each mode does

    x  <- x* + mu D x + sum_j column_j lambda_j         Udwadia-Kalaba correction, Kirchhoff-Carrier, pluck
    x* <- a x_new + b x_old                             exact flow of the free mode

D = g kappa; mu is minus the dynamic tension. Y and Z share all coefficients and stand in one vector, four modes each.
"""

from ukrt.engine import layout as at
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.simd import ZERO, Loop, vector_kernel


def make_sweep(n_extra, tension=True):
    """The sweep for the bridge and ``n_extra`` further columns (contacts and the pluck).

    Without ``tension`` it leaves out Kirchhoff-Carrier, whose cost is measured so; the engine has it always.
    """
    n_columns = 1 + n_extra

    @vector_kernel(3)
    def sweep(v, first_tile, end_tile, s):
        forces = [
            v.pair(v.scalar(v.at(s, at.LAM_Y + j * at.LANES)), v.scalar(v.at(s, at.LAM_Z + j * at.LANES)))
            for j in range(n_columns)
        ]
        mu = v.spread(v.scalar(v.at(s, at.MU)))
        loop = Loop(v, first_tile, end_tile, [ZERO] * (2 * n_columns + 2))
        state = v.builder.mul(loop.index, v.index(at.STATE_TILE))
        coefficient = v.builder.mul(loop.index, v.index(at.COEF_TILE))
        a, b, d = (v.load_twice(v.at(coefficient, at.COEF + k)) for k in (at.COEF_A, at.COEF_B, at.COEF_D))
        columns = [v.load_twice(v.at(coefficient, at.COEF + at.COEF_COLUMNS + 4 * j)) for j in range(n_columns)]
        old = v.load(v.at(state, at.STATE))
        new = v.load(v.at(state, at.STATE + 8))
        if tension:
            new = v.fma(mu, v.mul(d, old), new)
        for column, force in zip(columns, forces, strict=True):
            new = v.fma(column, force, new)
        predicted = v.fma(a, new, v.mul(b, old))
        weighted = v.mul(d, new) if tension else ZERO
        sums = []
        for j, column in enumerate(columns):
            sums.append(v.fma(column, predicted, loop.carried[2 * j]))
            sums.append(v.fma(column, weighted, loop.carried[2 * j + 1]) if tension else ZERO)
        sums.append(v.fma(weighted, weighted, loop.carried[-2]) if tension else ZERO)
        sums.append(v.fma(weighted, predicted, loop.carried[-1]) if tension else ZERO)
        v.store(new, v.at(state, at.STATE))
        v.store(predicted, v.at(state, at.STATE + 8))
        loop.close(sums)
        row = v.builder.mul(s, v.index(8))
        places = [*range(2 * n_columns), at.SUM_HH, at.SUM_HX]
        for place, value in zip(places, sums, strict=True):
            v.store(value, v.at(row, at.ACC + place * at.ACC_STRIDE))

    return sweep


_sweep0, _sweep1, _sweep2, _sweep3, _sweep4, _sweep5, _sweep6 = [make_sweep(n) for n in range(at.COLUMNS)]


@kernel
def sweep_string(d, first_tile, end_tile, s, n_extra):
    """Advance string ``s``, from ``first_tile`` to below ``end_tile``, with ``n_extra`` columns beside the bridge's."""
    if n_extra == 0:
        _sweep0(d, first_tile, end_tile, s)
    elif n_extra == 1:
        _sweep1(d, first_tile, end_tile, s)
    elif n_extra == 2:
        _sweep2(d, first_tile, end_tile, s)
    elif n_extra == 3:
        _sweep3(d, first_tile, end_tile, s)
    elif n_extra == 4:
        _sweep4(d, first_tile, end_tile, s)
    elif n_extra == 5:
        _sweep5(d, first_tile, end_tile, s)
    else:
        _sweep6(d, first_tile, end_tile, s)
