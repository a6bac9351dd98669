"""The Udwadia-Kalaba correction of one sample: constraint forces of all strings, fingers and the body, in closed form.

Enter the sums of the last sweep; leave lambda (per port and polarization), mu (minus the dynamic tension) and the
body's and fingers' next positions. Strings stand in the lanes of the vectors. With e = A q* - d, u = A G h, V = (A G
A^T)^-1 of one string (its fingers included, the body not), h = D x:

    lambda + V u mu = V (e_bridge y_body - e)            rows of A
    u . lambda + (4 L / ES + h G h) mu = -psi - h . q*   the scalar auxiliary variable of Kirchhoff-Carrier

Eliminating gives each string's bridge force as stiff y_body - held_back, and the body, whose shapes are linear along
the bridge, is two points, a place and a slope: a 2 x 2 system. Nothing else can go on meanwhile, so that what counts is
how many operations wait for each other, not how many there are. See ukrt/engine/README.md for why the whole is stable.
"""

from types import SimpleNamespace

from llvmlite import ir

from ukrt.engine import layout as at
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.simd import ONE, ZERO, Loop, vector_kernel

_ROWS = at.LANES  # distance between the ports of a lane array
P_PUSH = 0  # in PAIR: the strings' force on the bridge, and its moment about the bass end over the bridge's length


def _total(v, values):
    """The sum of a list of vectors, in pairs."""
    while len(values) > 1:
        values = [v.add(*values[k : k + 2]) if k + 1 < len(values) else values[k] for k in range(0, len(values), 2)]
    return values[0]


def _dot(v, first, second, n_chains=2):
    """Sum of products, in chains that do not wait for each other."""
    chains = [ZERO] * n_chains
    for k, (x, y) in enumerate(zip(first, second, strict=True)):
        c = k % n_chains
        chains[c] = v.mul(x, y) if chains[c] is ZERO else v.fma(x, y, chains[c])
    return _total(v, [chain for chain in chains if chain is not ZERO])


def _load_inverse(v, lane, n_ports):
    """V, of which the upper half is enough."""

    def load(j, k):
        return v.load(v.index(at.V + (j * at.PORTS + k) * _ROWS + lane))

    return [[load(min(j, k), max(j, k)) for k in range(n_ports)] for j in range(n_ports)]


def _eliminate(v, group, n_ports, n_strings):
    """Solve the rows of one group of strings up to the bridge's motion: its force there is ``stiff y - held_back``.

    What all strings' sums wait for stands first. ``sums`` is what the body must know of each string: stiff times 1, its
    place and its place squared, held_back times 1 and its place.
    """
    lane = 8 * group

    def load(base, j=0):
        return v.load(v.index(base + j * _ROWS + lane))

    def gather(place):
        """Add up a row of partial sums: for Y and for Z."""
        start = at.ACC + place * at.ACC_STRIDE + 64 * group
        return v.fold([v.load(v.index(start + 8 * s)) for s in range(n_strings)])

    inverse = _load_inverse(v, lane, n_ports)
    u_y, u_z = zip(*(gather(2 * j + 1) for j in range(n_ports)), strict=True)
    v_y, v_z = ([_dot(v, row, u) for row in inverse] for u in (u_y, u_z))
    sigma, psi, along = load(at.SIGMA), load(at.PSI), load(at.XI)
    hh = v.add(*gather(at.SUM_HH))
    softness = v.reciprocal(v.sub(v.add(sigma, hh), _dot(v, u_y + u_z, v_y + v_z, 4)))
    moved = [gather(2 * j) for j in range(n_ports)]
    e_y, e_z = [moved[0][0]], [moved[0][1]]
    for j, (y, z) in enumerate(moved[1:], 1):
        e_y.append(v.sub(y, v.add(load(at.FIN_Y1, j), load(at.LAND_Y, j))))
        e_z.append(v.sub(z, v.add(load(at.FIN_Z1, j), load(at.LAND_Z, j))))
    t_y = _dot(v, inverse[0], e_y)
    driven = v.sub(_dot(v, v_y + v_z, e_y + e_z, 4), v.add(psi, v.add(*gather(at.SUM_HX))))
    sums = []
    for hard, square, order in ((inverse[0][0], v.mul(v_y[0], v_y[0]), 3), (t_y, v.mul(v_y[0], driven), 2)):
        for _ in range(order):
            sums.append(v.fma(square, softness, hard))
            hard, square = v.mul(hard, along), v.mul(square, along)
    return SimpleNamespace(
        lane=lane, along=along, sums=sums, softness=softness, driven=driven, sigma=sigma, psi=psi,
        inverse=inverse, v_y=v_y, v_z=v_z, e_y=e_y, e_z=e_z,
    )  # fmt: skip


def _total_everywhere(v, vector):
    """The sum of the eight elements, in all eight places."""
    for order in ([1, 0, 3, 2, 5, 4, 7, 6], [2, 3, 0, 1, 6, 7, 4, 5], [4, 5, 6, 7, 0, 1, 2, 3]):
        vector = v.add(vector, v.shuffle(vector, vector, order))
    return vector


def _solve_body(v, sums):
    """(1 + W S) z = z* + W p for the bridge's place and slope z, S and p the strings' sums; stores its forces too.

    Leaves z before the division by the determinant, and what to multiply with instead: nobody waits for both.
    """
    s00, s01, s11, p0, p1 = (_total_everywhere(v, value) for value in sums)
    w00, w01, w11, z0, z1 = (v.spread(v.scalar(v.index(at.BODY_W + k))) for k in range(5))
    m00, m01 = v.fma(w00, s00, v.fma(w01, s01, ONE)), v.fma(w00, s01, v.mul(w01, s11))
    m10, m11 = v.fma(w01, s00, v.mul(w11, s01)), v.fma(w01, s01, v.fma(w11, s11, ONE))
    scale = v.reciprocal(v.fma(v.neg(m01), m10, v.mul(m00, m11)))
    right0, right1 = v.fma(w00, p0, v.fma(w01, p1, z0)), v.fma(w01, p0, v.fma(w11, p1, z1))
    place = v.fma(v.neg(m01), right1, v.mul(m11, right0))
    slope = v.fma(v.neg(m10), right0, v.mul(m00, right1))
    push = v.fma(v.neg(scale), v.fma(s00, place, v.mul(s01, slope)), p0)
    moment = v.fma(v.neg(scale), v.fma(s01, place, v.mul(s11, slope)), p1)
    for k, force in enumerate((push, moment)):
        first = v.builder.extract_element(force, ir.Constant(ir.IntType(32), 0))
        v.store_scalar(first, v.index(at.PAIR + P_PUSH + k))
    return place, slope, scale


def _apply(v, part, place, slope, scale):
    """Given the bridge's motion, the forces of a group of strings; then move their fingers and psi.

    Each force is written so that little is left to do once ``scale`` is there.
    """
    shape = v.fma(part.along, slope, place)
    stiff, held_back = part.sums[0], part.sums[3]
    m0 = v.mul(part.softness, part.driven)
    mu = v.fma(v.neg(v.mul(v.mul(part.softness, part.v_y[0]), shape)), scale, m0)
    bridge = v.mul(shape, scale)
    v.store(mu, v.index(at.MU + part.lane))
    v.store(v.neg(v.fma(part.sigma, mu, part.psi)), v.index(at.PSI + part.lane))
    for j, row in enumerate(part.inverse):
        lane = j * _ROWS + part.lane
        if j:
            held = v.fma(row[0], bridge, v.neg(_dot(v, row, part.e_y)))
            force_y = v.fma(v.neg(part.v_y[j]), mu, held)
        else:
            force_y = v.fma(v.mul(stiff, shape), scale, v.neg(held_back))
        force_z = v.neg(v.fma(part.v_z[j], mu, _dot(v, row, part.e_z)))
        v.store(force_y, v.index(at.LAM_Y + lane))
        v.store(force_z, v.index(at.LAM_Z + lane))
        if j:
            _move_finger(v, lane, force_y, at.FIN_Y, at.FIN_Y1)
            _move_finger(v, lane, force_z, at.FIN_Z, at.FIN_Z1)


def _move_finger(v, row, force, now, coming):
    """A contact is one more mode: pushed by minus the force on the string, then predicted one step on."""
    a, b, g = (v.load(v.index(base + row)) for base in (at.FIN_A, at.FIN_B, at.FIN_G))
    old = v.load(v.index(now + row))
    new = v.sub(v.load(v.index(coming + row)), v.mul(g, force))
    v.store(new, v.index(now + row))
    v.store(v.fma(a, new, v.mul(b, old)), v.index(coming + row))


def _make_solver(n_ports, groups):
    """The solver for ``n_ports`` ports a string and ``groups``: how many strings each vector of eight lanes holds."""

    @vector_kernel(0)
    def solve(v):
        v.align_stack()
        parts = [_eliminate(v, group, n_ports, count) for group, count in enumerate(groups)]
        body = _solve_body(v, [_total(v, list(values)) for values in zip(*(part.sums for part in parts), strict=True)])
        for part in parts:
            _apply(v, part, *body)

    return solve


# Six strings, the usual guitar, are spared adding up those that are not there.
_six1, _six2, _six3, _six4, _six5, _six6 = [_make_solver(n + 1, (6,)) for n in range(at.PORTS)]
_all1, _all2, _all3, _all4, _all5, _all6 = [_make_solver(n + 1, (8, at.MAX_STRINGS - 8)) for n in range(at.PORTS)]


@kernel
def _solve_six(d, n_ports):
    if n_ports == 1:
        _six1(d)
    elif n_ports == 2:
        _six2(d)
    elif n_ports == 3:
        _six3(d)
    elif n_ports == 4:
        _six4(d)
    elif n_ports == 5:
        _six5(d)
    else:
        _six6(d)


@kernel
def _solve_all(d, n_ports):
    if n_ports == 1:
        _all1(d)
    elif n_ports == 2:
        _all2(d)
    elif n_ports == 3:
        _all3(d)
    elif n_ports == 4:
        _all4(d)
    elif n_ports == 5:
        _all5(d)
    else:
        _all6(d)


@vector_kernel(1)
def _sweep_body(v, n_vectors):
    """The body's modes: correct with the forces in PAIR, predict, and the bridge's predicted place and slope."""
    force, moment = (v.spread(v.scalar(v.index(at.PAIR + P_PUSH + k))) for k in (0, 1))
    loop = Loop(v, v.index(0), n_vectors, [ZERO, ZERO])
    place = v.builder.mul(loop.index, v.index(8))
    a, b, bass, slope, old, new = (
        v.load(v.at(place, base)) for base in (at.BODY_A, at.BODY_B, at.BODY_BASS, at.BODY_SLOPE, at.BODY_X, at.BODY_XS)
    )
    new = v.fma(slope, moment, v.fma(bass, force, new))
    predicted = v.fma(a, new, v.mul(b, old))
    v.store(new, v.at(place, at.BODY_X))
    v.store(predicted, v.at(place, at.BODY_XS))
    sums = loop.close([v.fma(bass, predicted, loop.carried[0]), v.fma(slope, predicted, loop.carried[1])])
    for k, value in enumerate(sums):
        v.store_scalar(v.total(value), v.index(at.BODY_W + 3 + k))


@kernel
def solve_constraints(d, n_strings, n_ports, body_vectors):
    """All constraint forces of this sample; ``n_ports`` is the most that any string has, its bridge included."""
    if n_strings <= 6:
        _solve_six(d, n_ports)
    else:
        _solve_all(d, n_ports)
    _sweep_body(d, body_vectors)
