"""A string's free modes in discrete time: exact flow at the present tension (Eqs. 48, 49), the motion kept.

Enter the string's constants and its tension ratio; leave a, b, D = g kappa and the bridge column of every mode, and
what the step does wrong to each mode's receptance (residual.py takes it out again).
"""

import math

from ukrt.engine import layout as at
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.motion import former_position, place_mode, position, set_flow


@kernel
def mode_frequency(d, own, n, ratio):
    """Angular frequency of mode n = 1, 2, ... [rad/s] (Eq. 48) at ``ratio`` times the tension at rest."""
    p = (2 * n - 1) * math.pi / (2.0 * d[own + at.S_LENGTH])
    tension = d[own + at.S_TENSION] * ratio
    return math.sqrt(tension / d[own + at.S_DENSITY]) * p * (1.0 + d[own + at.S_STIFFNESS] * p * p / (2.0 * tension))


@kernel
def mode_damping(d, own, n, ratio, omega):
    """Damping ratio of mode n [1] (Eq. 49)."""
    p = (2 * n - 1) * math.pi / (2.0 * d[own + at.S_LENGTH])
    tension = d[own + at.S_TENSION] * ratio
    bending = d[own + at.S_STIFFNESS] * p * p
    lost = tension * (d[own + at.S_LOSS_INTERNAL] + (d[own + at.S_LOSS_AIR] + d[own + at.S_HUSH]) / omega)
    lost += d[own + at.S_LOSS_BENDING] * bending
    return 0.5 * lost / (tension + bending)


@kernel
def flow(omega, zeta, dt):
    """a and b of q[k+1] = a q[k] + b q[k-1], exact for a free mode of any damping."""
    sigma = zeta * omega
    if zeta < 1.0:
        a = 2.0 * math.exp(-sigma * dt) * math.cos(omega * math.sqrt(1.0 - zeta * zeta) * dt)
    else:
        root = omega * math.sqrt(zeta * zeta - 1.0)
        a = math.exp((root - sigma) * dt) + math.exp(-(root + sigma) * dt)
    return a, -math.exp(-2.0 * sigma * dt)


@kernel
def _step_error(a, b, phase, theta, zeta, still):
    """How a mode's receptance in steps differs from rho times the continuous one, at ``phase`` radians a sample.

    Real part and loss (minus the imaginary part), for column products: a mode with column c adds c c^T times this.
    """
    real = math.cos(phase) * (1.0 - b) - a
    imaginary = math.sin(phase) * (1.0 + b)
    size = real * real + imaginary * imaginary
    rho = math.tan(0.5 * phase) / (0.5 * phase)
    stiff = (theta * theta - phase * phase) / (theta * theta)
    lossy = 2.0 * zeta * phase / theta
    exact = rho / (still * (stiff * stiff + lossy * lossy))
    return real / size - stiff * exact, imaginary / size - lossy * exact


@kernel
def tune_string(d, i, s):
    """Set the coefficients of string ``s`` for its present tension ratio; where it is at k and k - 1 stays."""
    own, own_i = at.STRING + s * at.STRING_D_SIZE, at.STRING_I + s * at.STRING_I_SIZE
    dt, ratio, length = 1.0 / d[at.M_RATE + at.METER], d[own + at.S_RATIO], d[own + at.S_LENGTH]
    half_mass = 0.5 * d[own + at.S_DENSITY] * length
    for n in range(1, i[own_i + at.SI_MODES] + 1):
        tile, lane = i[own_i + at.SI_TILE] + (n - 1) // 4, (n - 1) % 4
        c, x = at.COEF + tile * at.COEF_TILE + lane, at.STATE + tile * at.STATE_TILE + lane
        omega = mode_frequency(d, own, n, ratio)
        zeta = mode_damping(d, own, n, ratio, omega)
        a, b = flow(omega, zeta, dt)
        stiffness = half_mass * omega * omega
        still = 1.0 - a - b
        g = still / stiffness
        p = (2 * n - 1) * math.pi / (2.0 * length)
        scale = abs(d[c + at.COEF_COLUMNS]) / math.sqrt(g)
        y, y_before = scale * position(d, x, c), scale * former_position(d, x, c)
        z, z_before = scale * position(d, x + 4, c), scale * former_position(d, x + 4, c)
        set_flow(d, c, a, b, g * 0.5 * p * p * length)
        place_mode(d, x, c, y, y_before)
        place_mode(d, x + 4, c, z, z_before)
        d[c + at.COEF_COLUMNS] = math.sqrt(g) if n % 2 == 1 else -math.sqrt(g)
        for match in range(at.MATCHES):
            phase = d[own + at.S_MATCH_1 + match] * math.sqrt(ratio)
            real, loss = _step_error(a, b, phase, omega * dt, zeta, still)
            d[at.ERROR + tile * at.ERROR_TILE + 8 * match + lane] = real
            d[at.ERROR + tile * at.ERROR_TILE + 8 * match + 4 + lane] = loss
    d[own + at.S_IMPEDANCE] = math.sqrt(d[own + at.S_TENSION] * ratio * d[own + at.S_DENSITY])
