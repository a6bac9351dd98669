"""One pass over a string's modes per sample: correct q[k+1], predict q*[k+2], sum up what the constraints need.

Enter the state of one string and the forces the solver found; leave the new state and, per string, 2 (ports + pluck) +
2 vectors of partial sums. With x = q / sqrt(g), so that the step's compliance matrix G is the identity, each mode does

    x  <- x* + mu D x + sum_j column_j lambda_j         Udwadia-Kalaba correction, Kirchhoff-Carrier, pluck
    x* <- a x_new + b x_old                             exact flow of the free mode

D = g kappa; mu is minus the dynamic tension. What is kept of x is D x, which both the sums and the next correction
want, so b stands as b / D; pseudo-modes, which have no D, come last, in a loop of their own (motion.py). Y and Z share
all coefficients and stand in one vector, four modes each.
"""

from ukrt.engine import layout as at
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.simd import ZERO, Loop, vector_kernel


class _Tile:
    """The coefficients and the state of the tile that a loop has come to, and its free flow."""

    def __init__(self, v, loop, n_columns):
        self._v, self._state = v, v.builder.mul(loop.index, v.index(at.STATE_TILE))
        self._coefficient = v.builder.mul(loop.index, v.index(at.COEF_TILE))
        self.a, self.back = self.field(at.COEF_A), self.field(at.COEF_BACK)
        self.columns = [self.field(at.COEF_COLUMNS + 4 * j) for j in range(n_columns)]
        self.old, self.new = (v.load(v.at(self._state, at.STATE + 8 * k)) for k in range(2))

    def field(self, place):
        """One coefficient of four modes, for Y and Z."""
        return self._v.load_twice(self._v.at(self._coefficient, at.COEF + place))

    def push(self, forces):
        """Correct with the forces at the ports, then predict."""
        v = self._v
        for column, force in zip(self.columns, forces, strict=True):
            self.new = v.fma(column, force, self.new)
        self.predicted = v.fma(self.a, self.new, v.mul(self.back, self.old))

    def keep(self, now):
        """Store what is kept of x[k], and x*[k+1]."""
        self._v.store(now, self._v.at(self._state, at.STATE))
        self._v.store(self.predicted, self._v.at(self._state, at.STATE + 8))


def _sweep_modes(v, tiles, n_columns, forces, mu):
    """The modes, which feel the tension; leaves all sums, those of h last."""
    loop = Loop(v, *tiles, [ZERO] * (2 * n_columns + 2))
    tile = _Tile(v, loop, n_columns)
    weight = tile.field(at.COEF_D)
    if mu is not None:
        tile.new = v.fma(mu, tile.old, tile.new)
    tile.push(forces)
    weighted = v.mul(weight, tile.new)
    sums = []
    for j, column in enumerate(tile.columns):
        sums.append(v.fma(column, tile.predicted, loop.carried[2 * j]))
        sums.append(v.fma(column, weighted, loop.carried[2 * j + 1]) if mu is not None else ZERO)
    sums.append(v.fma(weighted, weighted, loop.carried[-2]) if mu is not None else ZERO)
    sums.append(v.fma(weighted, tile.predicted, loop.carried[-1]) if mu is not None else ZERO)
    tile.keep(weighted)
    return loop.close(sums)


def _sweep_pseudo_modes(v, tiles, n_columns, forces, sums):
    """The pseudo-modes, which do not; ``sums`` are those of the modes, of which A q* grows."""
    loop = Loop(v, *tiles, sums[: 2 * n_columns : 2])
    tile = _Tile(v, loop, n_columns)
    tile.push(forces)
    moved = [v.fma(c, tile.predicted, carried) for c, carried in zip(tile.columns, loop.carried, strict=True)]
    tile.keep(tile.new)
    sums[: 2 * n_columns : 2] = loop.close(moved)
    return sums


def make_sweep(n_extra, tension=True):
    """The sweep for the bridge and ``n_extra`` further columns (contacts and the pluck).

    Without ``tension`` it leaves out Kirchhoff-Carrier, whose cost is measured so; the engine has it always.
    """
    n_columns = 1 + n_extra

    @vector_kernel(4)
    def sweep(v, first_tile, first_pseudo, end_tile, s):
        forces = [
            v.pair(v.scalar(v.at(s, at.LAM_Y + j * at.LANES)), v.scalar(v.at(s, at.LAM_Z + j * at.LANES)))
            for j in range(n_columns)
        ]
        mu = v.spread(v.scalar(v.at(s, at.MU))) if tension else None
        sums = _sweep_modes(v, (first_tile, first_pseudo), n_columns, forces, mu)
        sums = _sweep_pseudo_modes(v, (first_pseudo, end_tile), n_columns, forces, sums)
        row = v.builder.mul(s, v.index(8))
        places = [*range(2 * n_columns), at.SUM_HH, at.SUM_HX]
        for place, value in zip(places, sums, strict=True):
            v.store(value, v.at(row, at.ACC + place * at.ACC_STRIDE))

    return sweep


_sweep0, _sweep1, _sweep2, _sweep3, _sweep4, _sweep5, _sweep6 = [make_sweep(n) for n in range(at.COLUMNS)]


@kernel
def sweep_string(d, i, s):
    """Advance string ``s`` by one sample."""
    own_i = at.STRING_I + s * at.STRING_I_SIZE
    n_extra, first, end = i[own_i + at.SI_EXTRA], i[own_i + at.SI_TILE], i[own_i + at.SI_END]
    pseudo = first + i[own_i + at.SI_TILES] - at.PSEUDO_TILES
    if n_extra == 0:
        _sweep0(d, first, pseudo, end, s)
    elif n_extra == 1:
        _sweep1(d, first, pseudo, end, s)
    elif n_extra == 2:
        _sweep2(d, first, pseudo, end, s)
    elif n_extra == 3:
        _sweep3(d, first, pseudo, end, s)
    elif n_extra == 4:
        _sweep4(d, first, pseudo, end, s)
    elif n_extra == 5:
        _sweep5(d, first, pseudo, end, s)
    else:
        _sweep6(d, first, pseudo, end, s)
