"""The Udwadia-Kalaba correction of one sample: constraint forces of all strings, fingers and the body, in closed form.

Enter the sums of the last sweep; leave lambda (per port and polarization), mu (minus the dynamic tension) and the body's and
fingers' next positions. Strings stand in the lanes of the vectors. With e = A q* - d, u = A G h, V = (A G A^T)^-1 of one
string (its fingers included, the body not), h = D x:

    lambda + V u mu = V (e_bridge y_body - e)            rows of A
    u . lambda + (4 L / ES + h G h) mu = -psi - h . q*   the scalar auxiliary variable of Kirchhoff-Carrier

Eliminating gives each string's bridge force as lambda_0 + C y_body, and the body, whose shapes are linear along the bridge,
is two points: a 2 x 2 system. See ukrt/engine/README.md for why the whole is stable.
"""

from ukrt.engine import layout as at
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.simd import ZERO, Loop, vector_kernel

_ROWS = at.LANES  # distance between the ports of a lane array
T_VY, T_TY, T_VZ, T_TZ = (k * at.PORTS for k in range(4))
T_M0, T_INVERSE = 4 * at.PORTS, 4 * at.PORTS + 1
P_STIFF, P_FORCE, P_BODY, P_PUSH = 0, 3, 8, 10  # in PAIR: sums of C and of lambda_0; the bridge's place and slope; forces on them


def _gather_sums(v, group, n_ports, n_strings):
    """Add up the partial sums of six or eight strings: e without offsets and u for both polarizations, h G h, h . q*."""
    start = v.builder.mul(group, v.index(64))

    def row(place):
        return v.fold([v.load(v.at(start, at.ACC + place * at.ACC_STRIDE + 8 * s)) for s in range(n_strings)])

    moved = [row(2 * j) for j in range(n_ports)]
    pushed = [row(2 * j + 1) for j in range(n_ports)]
    hh, hx = (v.add(*row(place)) for place in (at.SUM_HH, at.SUM_HX))
    return moved, pushed, hh, hx


def _times_inverse(v, lane, n_ports, right):
    """V times a vector per lane."""
    out = []
    for j in range(n_ports):
        row = [v.load(v.at(lane, at.V + (j * at.PORTS + k) * _ROWS)) for k in range(n_ports)]
        value = v.mul(row[0], right[0])
        for k in range(1, n_ports):
            value = v.fma(row[k], right[k], value)
        out.append(value)
    return out


def _stretch(v, lane, j, moved, coming, landing):
    """How far the string's predicted place at contact ``j`` is from where the finger's will be."""
    row = v.at(lane, j * _ROWS)
    return v.sub(v.sub(moved, v.load(v.at(row, coming))), v.load(v.at(row, landing)))


def _dot(v, first, second, start):
    for x, y in zip(first, second, strict=True):
        start = v.fma(x, y, start)
    return start


def _make_local(n_ports, n_strings):
    """Eliminate the contacts and the tension of eight strings; add their stiffness seen from the bridge to PAIR."""

    @vector_kernel(1)
    def local(v, group):
        lane = v.builder.mul(group, v.index(8))
        moved, pushed, hh, hx = _gather_sums(v, group, n_ports, n_strings)
        e_y, e_z = (
            [moved[0][k]] + [_stretch(v, lane, j, moved[j][k], *arrays) for j in range(1, n_ports)]
            for k, arrays in enumerate(((at.FIN_Y1, at.LAND_Y), (at.FIN_Z1, at.LAND_Z)))
        )
        u_y, u_z = [p[0] for p in pushed], [p[1] for p in pushed]
        v_y, v_z = _times_inverse(v, lane, n_ports, u_y), _times_inverse(v, lane, n_ports, u_z)
        t_y, t_z = _times_inverse(v, lane, n_ports, e_y), _times_inverse(v, lane, n_ports, e_z)
        schur = v.add(v.load(v.at(lane, at.SIGMA)), hh)
        schur = v.sub(v.sub(schur, _dot(v, u_y, v_y, ZERO)), _dot(v, u_z, v_z, ZERO))
        inverse = v.reciprocal(schur)
        driven = v.neg(v.add(v.load(v.at(lane, at.PSI)), hx))
        m0 = v.mul(inverse, _dot(v, v_z, e_z, _dot(v, v_y, e_y, driven)))
        for base, values in ((T_VY, v_y), (T_TY, t_y), (T_VZ, v_z), (T_TZ, t_z), (T_M0, [m0]), (T_INVERSE, [inverse])):
            for j, value in enumerate(values):
                v.store(value, v.at(lane, at.TMP + (base + j) * _ROWS))
        stiff = v.fma(v.mul(v_y[0], v_y[0]), inverse, v.load(v.at(lane, at.V)))
        force = v.neg(v.fma(v_y[0], m0, t_y[0]))
        along = v.load(v.at(lane, at.XI))
        moment = v.mul(stiff, along)
        rows = [stiff, moment, v.mul(moment, along), force, v.mul(force, along), ZERO, ZERO]
        sums = v.add(*v.fold(rows))
        v.store(v.add(v.load(v.index(at.PAIR)), sums), v.index(at.PAIR))

    return local


def _make_apply(n_ports):
    """Given the body's ends, the forces of eight strings; then move their fingers and psi."""

    @vector_kernel(1)
    def apply(v, group):
        lane = v.builder.mul(group, v.index(8))

        def kept(row):
            return v.load(v.at(lane, at.TMP + row * _ROWS))

        bass = v.spread(v.scalar(v.index(at.PAIR + P_BODY)))
        slope = v.spread(v.scalar(v.index(at.PAIR + P_BODY + 1)))
        bridge = v.fma(v.load(v.at(lane, at.XI)), slope, bass)
        mu = v.sub(kept(T_M0), v.mul(kept(T_INVERSE), v.mul(kept(T_VY), bridge)))
        v.store(mu, v.at(lane, at.MU))
        psi = v.fma(v.load(v.at(lane, at.SIGMA)), mu, v.load(v.at(lane, at.PSI)))
        v.store(v.neg(psi), v.at(lane, at.PSI))
        for j in range(n_ports):
            held = v.load(v.at(lane, at.V + j * at.PORTS * _ROWS))
            force_y = v.sub(v.sub(v.mul(held, bridge), kept(T_TY + j)), v.mul(kept(T_VY + j), mu))
            force_z = v.neg(v.fma(kept(T_VZ + j), mu, kept(T_TZ + j)))
            v.store(force_y, v.at(lane, at.LAM_Y + j * _ROWS))
            v.store(force_z, v.at(lane, at.LAM_Z + j * _ROWS))
            if j:
                _move_finger(v, v.at(lane, j * _ROWS), force_y, at.FIN_Y, at.FIN_Y1)
                _move_finger(v, v.at(lane, j * _ROWS), force_z, at.FIN_Z, at.FIN_Z1)

    return apply


def _move_finger(v, row, force, now, coming):
    """A contact is one more mode: pushed by minus the force on the string, then predicted one step on."""
    a, b, g = (v.load(v.at(row, base)) for base in (at.FIN_A, at.FIN_B, at.FIN_G))
    old = v.load(v.at(row, now))
    new = v.sub(v.load(v.at(row, coming)), v.mul(g, force))
    v.store(new, v.at(row, now))
    v.store(v.fma(a, new, v.mul(b, old)), v.at(row, coming))


# Six strings, the usual guitar, are spared adding up the two that are not there.
_six1, _six2, _six3, _six4, _six5, _six6 = [_make_local(n + 1, 6) for n in range(at.PORTS)]
_eight1, _eight2, _eight3, _eight4, _eight5, _eight6 = [_make_local(n + 1, 8) for n in range(at.PORTS)]
_apply1, _apply2, _apply3, _apply4, _apply5, _apply6 = [_make_apply(n + 1) for n in range(at.PORTS)]


@kernel
def _solve_six(d, group, n_ports):
    if n_ports == 1:
        _six1(d, group)
    elif n_ports == 2:
        _six2(d, group)
    elif n_ports == 3:
        _six3(d, group)
    elif n_ports == 4:
        _six4(d, group)
    elif n_ports == 5:
        _six5(d, group)
    else:
        _six6(d, group)


@kernel
def _solve_eight(d, group, n_ports):
    if n_ports == 1:
        _eight1(d, group)
    elif n_ports == 2:
        _eight2(d, group)
    elif n_ports == 3:
        _eight3(d, group)
    elif n_ports == 4:
        _eight4(d, group)
    elif n_ports == 5:
        _eight5(d, group)
    else:
        _eight6(d, group)


@kernel
def _apply_forces(d, group, n_ports):
    if n_ports == 1:
        _apply1(d, group)
    elif n_ports == 2:
        _apply2(d, group)
    elif n_ports == 3:
        _apply3(d, group)
    elif n_ports == 4:
        _apply4(d, group)
    elif n_ports == 5:
        _apply5(d, group)
    else:
        _apply6(d, group)


@vector_kernel(1)
def _sweep_body(v, n_vectors):
    """The body's modes: correct with the forces in PAIR, predict, and the bridge's predicted place and slope."""
    force, moment = (v.spread(v.scalar(v.index(at.PAIR + P_PUSH + k))) for k in (0, 1))
    loop = Loop(v, v.index(0), n_vectors, [ZERO, ZERO])
    place = v.builder.mul(loop.index, v.index(8))
    a, b, bass, slope, old, new = (
        v.load(v.at(place, base))
        for base in (at.BODY_A, at.BODY_B, at.BODY_BASS, at.BODY_SLOPE, at.BODY_X, at.BODY_XS)
    )
    new = v.fma(slope, moment, v.fma(bass, force, new))
    predicted = v.fma(a, new, v.mul(b, old))
    v.store(new, v.at(place, at.BODY_X))
    v.store(predicted, v.at(place, at.BODY_XS))
    sums = loop.close([v.fma(bass, predicted, loop.carried[0]), v.fma(slope, predicted, loop.carried[1])])
    for k, value in enumerate(sums):
        v.store_scalar(v.total(value), v.index(at.BODY_W + 3 + k))


@kernel
def _solve_body(d):
    """(1 + W S) z = z* - W p for the bridge's place and slope z, where S and p are the strings' sums; then its forces."""
    s00, s01, s11 = d[at.PAIR + P_STIFF], d[at.PAIR + P_STIFF + 1], d[at.PAIR + P_STIFF + 2]
    p0, p1 = d[at.PAIR + P_FORCE], d[at.PAIR + P_FORCE + 1]
    w00, w01, w11 = d[at.BODY_W], d[at.BODY_W + 1], d[at.BODY_W + 2]
    right0 = d[at.BODY_W + 3] - w00 * p0 - w01 * p1
    right1 = d[at.BODY_W + 4] - w01 * p0 - w11 * p1
    m00, m01 = 1.0 + w00 * s00 + w01 * s01, w00 * s01 + w01 * s11
    m10, m11 = w01 * s00 + w11 * s01, 1.0 + w01 * s01 + w11 * s11
    scale = 1.0 / (m00 * m11 - m01 * m10)
    place = scale * (m11 * right0 - m01 * right1)
    slope = scale * (m00 * right1 - m10 * right0)
    d[at.PAIR + P_BODY], d[at.PAIR + P_BODY + 1] = place, slope
    d[at.PAIR + P_PUSH] = -(p0 + s00 * place + s01 * slope)
    d[at.PAIR + P_PUSH + 1] = -(p1 + s01 * place + s11 * slope)


@kernel
def solve_constraints(d, n_strings, n_ports, body_vectors):
    """All constraint forces of this sample; ``n_ports`` is the most that any string has, its bridge included."""
    for k in range(8):
        d[at.PAIR + k] = 0.0
    n_groups = (n_strings + 7) // 8
    if n_strings <= 6:
        _solve_six(d, 0, n_ports)
    else:
        for group in range(n_groups):
            _solve_eight(d, group, n_ports)
    _solve_body(d)
    for group in range(n_groups):
        _apply_forces(d, group, n_ports)
    _sweep_body(d, body_vectors)
