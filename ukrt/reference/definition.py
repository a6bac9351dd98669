"""The scheme, as plain as the paper writes it: modal accelerations under constraints (Eqs. 5, 6, 11, 20) and
velocity-Verlet. This is the definition; `compiled` does the same steps faster and is tested to be equal.

The velocity that the losses of the next step are computed from is not yet known there. It is predicted, v + dt a, which
keeps the scheme second order; the half-step velocity v + dt a / 2 that Verlet forms anyway makes losses late by dt / 2
and the scheme first order (``damping_velocity``; see README.md for both, measured).
"""

import numpy as np

PASSES = 2  # Eq. 5 once is exact; a second time it takes out what rounding left of b - A q'', which would drift
DAMPING_VELOCITIES = {"predicted": 1.0, "half-step": 0.5}


def accelerations(system, q, v, push, b):
    """Modal accelerations and constraint forces.

    Parameters
    ----------
    system : ukrt.reference.system.ReferenceSystem
    q, v : ndarray (n,) [m], [m/s]
    push : ndarray (n,) [N]
        External modal forces.
    b : ndarray (n_rows,) [m/s^2]
        Of A q'' = b (Eq. 2): not nil only while a finger lands.

    Returns
    -------
    acceleration : ndarray (n,) [m/s^2]
        Eq. 5.
    force : ndarray (n_rows,) [N]
        lambda of the constraint forces F_c = A^T lambda (Eq. 6).
    """
    force = push - system.loss * v - system.dampers.T @ (system.dampers @ v) - system.stiffness * q
    for modes, on_y, on_z in zip(system.modes, system.strings_y, system.strings_z, strict=True):
        force[on_y] += modes.tension_force(q[on_y], q[on_z])
        force[on_z] += modes.tension_force(q[on_z], q[on_y])
    acceleration, reaction = force / system.mass, np.zeros(len(b))
    for _ in range(PASSES):
        missing = b - system.A @ acceleration
        acceleration = acceleration + system.B_plus @ missing / np.sqrt(system.mass)
        reaction = reaction + system.compliance @ missing
    return acceleration, reaction


def run(system, motion, step, pushes, shapes, b, kept_steps, damping_velocity="predicted"):
    """Steps of velocity-Verlet.

    Parameters
    ----------
    system : ReferenceSystem
    motion : ndarray (3, n)
        Displacements [m], velocities [m/s] and accelerations [m/s^2] of the modes; changed in place.
    step : float [s]
    pushes : ndarray (n_steps, n_pushes) [N]
        External forces at the end of each step.
    shapes : ndarray (n_pushes, n) [1]
        Where and in which direction they push.
    b : ndarray (n_steps, n_rows) [m/s^2]
        At the end of each step.
    kept_steps : range
        Which steps are kept: 0 is the first.
    damping_velocity : {"predicted", "half-step"}

    Returns
    -------
    kept_q, kept_v : ndarray (n_kept, n) [m], [m/s]
    kept_force : ndarray (n_kept, n_rows) [N]
    """
    q, v, a = motion
    ahead = DAMPING_VELOCITIES[damping_velocity] * step
    kept_q, kept_v, kept_force = [], [], []
    for k in range(len(pushes)):
        q = q + step * v + 0.5 * step**2 * a
        half, early = v + 0.5 * step * a, v + ahead * a
        a, force = accelerations(system, q, early, pushes[k] @ shapes, b[k])
        v = half + 0.5 * step * a
        if k in kept_steps:
            kept_q.append(q)
            kept_v.append(v)
            kept_force.append(force)
    motion[:] = q, v, a
    sizes = system.count, system.count, len(system.A)
    return tuple(np.array(kept).reshape(-1, n) for kept, n in zip((kept_q, kept_v, kept_force), sizes, strict=True))
