"""The Udwadia-Kalaba correction of one sample: constraint forces of all strings, fingers and the body, in closed form.

Enter the sums of the last sweep; leave lambda (per port and polarization), mu (minus the dynamic tension) and the
body's and fingers' next positions. Strings stand in the lanes of the vectors. With e = A q* - d, u = A G h, V = (A G
A^T)^-1 of one string (its fingers included, the body not), h = D x:

    lambda + V u mu = V (e_bridge y_body - e)            rows of A
    u . lambda + (4 L / ES + h G h) mu = -psi - h . q*   the scalar auxiliary variable of Kirchhoff-Carrier

Eliminating gives each string's bridge force as lambda_0 + C y_body, and the body, whose shapes are linear along the
bridge, is two points, a place and a slope: a 2 x 2 system. See ukrt/engine/README.md for why the whole is stable.
"""

from types import SimpleNamespace

from llvmlite import ir

from ukrt.engine import layout as at
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.simd import DOUBLE, ZERO, Loop, vector_kernel

_ROWS = at.LANES  # distance between the ports of a lane array
P_PUSH = 0  # in PAIR: the strings' force on the bridge, and its moment about the bass end over the bridge's length


def _gather_sums(v, group, n_ports, n_strings):
    """Add up the partial sums of a group's strings: A q* and u for both polarizations, h G h, h . q*."""

    def row(place):
        start = at.ACC + place * at.ACC_STRIDE + 64 * group
        return v.fold([v.load(v.index(start + 8 * s)) for s in range(n_strings)])

    moved = [row(2 * j) for j in range(n_ports)]
    pushed = [row(2 * j + 1) for j in range(n_ports)]
    hh, hx = (v.add(*row(place)) for place in (at.SUM_HH, at.SUM_HX))
    return moved, pushed, hh, hx


def _times(v, matrix, right):
    """A matrix of vectors times a vector of vectors."""
    out = []
    for row in matrix:
        value = v.mul(row[0], right[0])
        for entry, x in zip(row[1:], right[1:], strict=True):
            value = v.fma(entry, x, value)
        out.append(value)
    return out


def _dot(v, first, second):
    """Sum of products, in two chains so that neither waits long for the other."""
    chains = [ZERO, ZERO]
    for k, (x, y) in enumerate(zip(first, second, strict=True)):
        chains[k % 2] = v.mul(x, y) if chains[k % 2] is ZERO else v.fma(x, y, chains[k % 2])
    return chains[0] if chains[1] is ZERO else v.add(*chains)


def _eliminate(v, group, n_ports, n_strings):
    """Solve the rows of one group of strings up to the bridge's motion: its force there is ``force + stiff y``."""
    lane = 8 * group

    def rows(base, first=0):
        return [v.load(v.index(base + j * _ROWS + lane)) for j in range(first, n_ports)]

    moved, pushed, hh, hx = _gather_sums(v, group, n_ports, n_strings)
    e = []
    for k, (coming, landing) in enumerate(((at.FIN_Y1, at.LAND_Y), (at.FIN_Z1, at.LAND_Z))):
        held = [v.add(f, d) for f, d in zip(rows(coming, 1), rows(landing, 1), strict=True)]
        e.append([moved[0][k]] + [v.sub(m[k], h) for m, h in zip(moved[1:], held, strict=True)])
    u_y, u_z = [p[0] for p in pushed], [p[1] for p in pushed]
    inverse = [rows(at.V + j * at.PORTS * _ROWS) for j in range(n_ports)]
    v_y, v_z, t_y, t_z = (_times(v, inverse, right) for right in (u_y, u_z, *e))
    sigma, psi = v.load(v.index(at.SIGMA + lane)), v.load(v.index(at.PSI + lane))
    schur = v.sub(v.sub(v.add(sigma, hh), _dot(v, u_y, v_y)), _dot(v, u_z, v_z))
    softness = v.reciprocal(schur)
    driven = v.sub(v.add(_dot(v, v_y, e[0]), _dot(v, v_z, e[1])), v.add(psi, hx))
    m0 = v.mul(softness, driven)
    stiff = v.fma(v.mul(v_y[0], v_y[0]), softness, inverse[0][0])
    force = v.neg(v.fma(v_y[0], m0, t_y[0]))
    along = v.load(v.index(at.XI + lane))
    moment = v.mul(stiff, along)
    sums = v.add(*v.fold([stiff, moment, v.mul(moment, along), force, v.mul(force, along), ZERO]))
    return SimpleNamespace(
        lane=lane, along=along, sums=sums, m0=m0, softness=softness, sigma=sigma, psi=psi,
        v_y=v_y, v_z=v_z, t_y=t_y, t_z=t_z, held=[row[0] for row in inverse],
    )  # fmt: skip


def _solve_body(v, sums):
    """(1 + W S) z = z* - W p for the bridge's place and slope z, S and p the strings' sums; stores its forces too."""
    b = v.builder
    s00, s01, s11, p0, p1 = (b.extract_element(sums, ir.Constant(ir.IntType(32), k)) for k in range(5))
    w00, w01, w11, z0, z1 = (v.scalar(v.index(at.BODY_W + k)) for k in range(5))

    def sum_of(*products):
        total = b.fmul(*products[0])
        for x, y in products[1:]:
            total = b.fadd(total, b.fmul(x, y))
        return total

    one = ir.Constant(DOUBLE, 1.0)
    m00, m01 = b.fadd(one, sum_of((w00, s00), (w01, s01))), sum_of((w00, s01), (w01, s11))
    m10, m11 = sum_of((w01, s00), (w11, s01)), b.fadd(one, sum_of((w01, s01), (w11, s11)))
    right0, right1 = b.fsub(z0, sum_of((w00, p0), (w01, p1))), b.fsub(z1, sum_of((w01, p0), (w11, p1)))
    scale = b.fdiv(one, b.fsub(b.fmul(m00, m11), b.fmul(m01, m10)))
    place = b.fmul(scale, b.fsub(b.fmul(m11, right0), b.fmul(m01, right1)))
    slope = b.fmul(scale, b.fsub(b.fmul(m00, right1), b.fmul(m10, right0)))
    push = b.fneg(b.fadd(p0, sum_of((s00, place), (s01, slope))))
    moment = b.fneg(b.fadd(p1, sum_of((s01, place), (s11, slope))))
    v.store_scalar(push, v.index(at.PAIR + P_PUSH))
    v.store_scalar(moment, v.index(at.PAIR + P_PUSH + 1))
    return v.spread(place), v.spread(slope)


def _apply(v, part, place, slope):
    """Given the bridge's motion, the forces of a group of strings; then move their fingers and psi."""
    bridge = v.fma(part.along, slope, place)
    mu = v.sub(part.m0, v.mul(part.softness, v.mul(part.v_y[0], bridge)))
    v.store(mu, v.index(at.MU + part.lane))
    v.store(v.neg(v.fma(part.sigma, mu, part.psi)), v.index(at.PSI + part.lane))
    for j, held in enumerate(part.held):
        row = j * _ROWS + part.lane
        force_y = v.sub(v.fma(held, bridge, v.neg(part.t_y[j])), v.mul(part.v_y[j], mu))
        force_z = v.neg(v.fma(part.v_z[j], mu, part.t_z[j]))
        v.store(force_y, v.index(at.LAM_Y + row))
        v.store(force_z, v.index(at.LAM_Z + row))
        if j:
            _move_finger(v, row, force_y, at.FIN_Y, at.FIN_Y1)
            _move_finger(v, row, force_z, at.FIN_Z, at.FIN_Z1)


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
        parts = [_eliminate(v, group, n_ports, count) for group, count in enumerate(groups)]
        sums = parts[0].sums
        for part in parts[1:]:
            sums = v.add(sums, part.sums)
        place, slope = _solve_body(v, sums)
        for part in parts:
            _apply(v, part, place, slope)

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
