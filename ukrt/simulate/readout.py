"""What is read out of an instance of the engine between two samples: small kernels beside its loop.

Before the engine advances from sample k to k + 1 its arrays hold the positions q[k], all constraint offsets d[k] and
the energy between k - 1 and k; afterwards the forces of sample k and the energy between k and k + 1.
"""

from ..engine import layout as at
from ..engine.kernels.jit import kernel
from ..engine.kernels.motion import flow_back, position
from ..engine.kernels.ports import count_contacts


@kernel
def read_positions(d, i, row, drift, strings, body):
    """Sample ``row`` of the largest violated constraint [m] and, where there is room, of the modes' positions.

    Parameters
    ----------
    d, i : ndarray
        The instance.
    row : int
    drift : ndarray (n_rows,) [m]
    strings : ndarray (n_rows, n_tiles, 8)
        Tiles of x = q / sqrt(g), 4 Y and 4 Z; n_rows may be 0.
    body : ndarray (n_rows, n)
    """
    drift[row] = _largest_violation(d, i)
    if row < strings.shape[0]:
        for tile in range(strings.shape[1]):
            for lane in range(8):
                x, c = at.STATE + tile * at.STATE_TILE + lane, at.COEF + tile * at.COEF_TILE + lane % 4
                strings[row, tile, lane] = position(d, x, c)
        for n in range(body.shape[1]):
            body[row, n] = d[at.BODY_X + n]


@kernel
def read_forces(d, row, forces, rises):
    """Sample ``row`` of each string's force on the body in Y and of its dynamic tension: ndarrays (n_rows, n) [N]."""
    for s in range(forces.shape[1]):
        forces[row, s] = -d[at.LAM_Y + s]
        rises[row, s] = -d[at.MU + s]


@kernel
def add_energies(d, i, row, energies):
    """Add half the scheme's energy between two samples to sample ``row``: ndarray (n_rows, 6) [J].

    In the order of `ukrt.experiment.quantities.ENERGY_PARTS`. Called before and after an advance it makes the mean of
    the energies on both sides of the sample.
    """
    if row >= energies.shape[0]:
        return
    for s in range(i[at.H_STRINGS]):
        own_i = at.STRING_I + s * at.STRING_I_SIZE
        for tile in range(i[own_i + at.SI_TILE], i[own_i + at.SI_TILE] + i[own_i + at.SI_TILES]):
            x, c = at.STATE + tile * at.STATE_TILE, at.COEF + tile * at.COEF_TILE
            for lane in range(8):
                own = c + lane % 4
                a, b, now = d[own + at.COEF_A], flow_back(d, own), position(d, x + lane, own)
                energies[row, lane // 4] += 0.5 * _mode_energy(a, b, now, d[x + 8 + lane])
        psi = d[at.PSI + s]
        energies[row, 5] += 0.25 * psi * psi / d[at.SIGMA + s]
        for j in range(1, 1 + count_contacts(i, s)):
            lane = j * at.LANES + s
            a, b, g = d[at.FIN_A + lane], d[at.FIN_B + lane], d[at.FIN_G + lane]
            if g > 0.0 and b < 0.0:
                energies[row, 3] += 0.5 * _mode_energy(a, b, d[at.FIN_Y + lane], d[at.FIN_Y1 + lane]) / g
                energies[row, 4] += 0.5 * _mode_energy(a, b, d[at.FIN_Z + lane], d[at.FIN_Z1 + lane]) / g
    for n in range(8 * i[at.H_BODY]):
        a, b = d[at.BODY_A + n], d[at.BODY_B + n]
        energies[row, 2] += 0.5 * _mode_energy(a, b, d[at.BODY_X + n], d[at.BODY_XS + n])


@kernel
def _mode_energy(a, b, now, coming):
    """Energy of one mode between its last position and this one, where ``coming`` = a now + b before."""
    if b == 0.0:
        return 0.0
    before = (coming - a * now) / b
    return 0.5 * (0.5 * (1.0 - b) * (now * now + before * before) - a * now * before)


@kernel
def _largest_violation(d, i):
    """The largest |A q - d| over all constraints [m]."""
    worst = 0.0
    for s in range(i[at.H_STRINGS]):
        bridge = 0.0
        for n in range(8 * i[at.H_BODY]):
            bridge += d[at.BODY_X + n] * (d[at.BODY_BASS + n] + d[at.XI + s] * d[at.BODY_SLOPE + n])
        for j in range(1 + count_contacts(i, s)):
            on_y, on_z = _displacement(d, i, s, j)
            if j == 0:
                on_y -= bridge
            else:
                row = j * at.LANES + s
                on_y -= d[at.FIN_Y + row] + d[at.LAND_Y + row]
                on_z -= d[at.FIN_Z + row] + d[at.LAND_Z + row]
            worst = max(worst, abs(on_y), abs(on_z))
    return worst


@kernel
def _displacement(d, i, s, port):
    """Displacement of a port of string ``s`` [m], Y and Z."""
    own_i = at.STRING_I + s * at.STRING_I_SIZE
    on_y, on_z = 0.0, 0.0
    for tile in range(i[own_i + at.SI_TILE], i[own_i + at.SI_TILE] + i[own_i + at.SI_TILES]):
        x, c = at.STATE + tile * at.STATE_TILE, at.COEF + tile * at.COEF_TILE
        for lane in range(4):
            column = d[c + at.COEF_COLUMNS + 4 * port + lane]
            on_y += column * position(d, x + lane, c + lane)
            on_z += column * position(d, x + 4 + lane, c + lane)
    return on_y, on_z
