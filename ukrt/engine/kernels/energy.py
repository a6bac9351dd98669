"""The scheme's energy, the meter all tests read: what the constrained system holds between two samples.

H = sum over all modes of [(1 - b)/2 (x[k]^2 + x[k-1]^2) - a x[k] x[k-1]] / 2 (x = q / sqrt(g)), fingers and body
alike, plus psi^2 / 2 of each string's Kirchhoff-Carrier stretching. It changes only by work of forces, by losses and
by gestures.
"""

from ukrt.engine import layout as at
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.motion import flow_back, former_position, position
from ukrt.engine.kernels.sleep import bridge_motion


@kernel
def _mode_energy(a, b, now, before):
    return 0.5 * (0.5 * (1.0 - b) * (now * now + before * before) - a * now * before)


@kernel
def string_energy(d, i, s):
    """Energy of string ``s`` [J], its fingers not included; of one that sleeps, the energy of the spring it is."""
    own_i = at.STRING_I + s * at.STRING_I_SIZE
    if i[own_i + at.SI_SLEEP] == at.ASLEEP:
        now, before = bridge_motion(d, i, s)
        return 0.25 * d[at.V + s] * (now * now + before * before)
    total = 0.0
    for tile in range(i[own_i + at.SI_TILE], i[own_i + at.SI_TILE] + i[own_i + at.SI_TILES]):
        x, c = at.STATE + tile * at.STATE_TILE, at.COEF + tile * at.COEF_TILE
        for lane in range(8):
            own = c + lane % 4
            now, before = position(d, x + lane, own), former_position(d, x + lane, own)
            total += _mode_energy(d[own + at.COEF_A], flow_back(d, own), now, before)
    psi = d[at.PSI + s]
    return total + 0.5 * psi * psi / d[at.SIGMA + s]


@kernel
def finger_energy(d, i, s):
    """Energy of the fingers on string ``s`` [J]."""
    own_i = at.STRING_I + s * at.STRING_I_SIZE
    total = 0.0
    for j in range(1, 1 + i[own_i + at.SI_FINGER] + i[own_i + at.SI_DAMPER]):
        row = j * at.LANES + s
        a, b, g = d[at.FIN_A + row], d[at.FIN_B + row], d[at.FIN_G + row]
        if g > 0.0 and b <= 0.0:
            for now_at, next_at in ((at.FIN_Y, at.FIN_Y1), (at.FIN_Z, at.FIN_Z1)):
                now = d[now_at + row]
                # a finger so damped that its last place cannot be told from its next: its spring's energy
                before = (d[next_at + row] - a * now) / b if b < -1e-3 else now
                total += _mode_energy(a, b, now, before) / g
    return total


@kernel
def body_energy(d, i):
    """Energy of the body [J]."""
    total = 0.0
    for n in range(8 * i[at.H_BODY]):
        a, b, now = d[at.BODY_A + n], d[at.BODY_B + n], d[at.BODY_X + n]
        if b != 0.0:
            total += _mode_energy(a, b, now, (d[at.BODY_XS + n] - a * now) / b)
    return total


@kernel
def total_energy(d, i):
    """Energy of strings, fingers and body [J]."""
    total = body_energy(d, i)
    for s in range(i[at.H_STRINGS]):
        total += string_energy(d, i, s) + finger_energy(d, i, s)
    return total
