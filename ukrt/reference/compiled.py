"""The steps of `definition.run`, compiled: each constraint row touches one string and at most the body or one finger,
so rows are kept as runs of consecutive modes and nothing else is multiplied.

All compiled code of the reference stands in this one file, so that Numba's cache sees every change of it.
"""

import numba
import numpy as np

from .definition import DAMPING_VELOCITIES, PASSES

# Sums may be reordered: the order of a sum is not part of the scheme.
_OPTIONS = {"cache": True, "error_model": "numpy", "fastmath": {"reassoc", "contract", "nsz"}}


def run(system, motion, step, pushes, shapes, b, kept_steps, damping_velocity="predicted"):
    """The same as `ukrt.reference.definition.run`."""
    n_kept, n = len(kept_steps), system.count
    kept_q, kept_v = np.empty((n_kept, n)), np.empty((n_kept, n))
    kept_force = np.empty((n_kept, len(system.A)))
    strings = [(y.start, z.start, y.stop - y.start) for y, z in zip(system.strings_y, system.strings_z, strict=True)]
    kappa = np.concatenate([modes.kappa for modes in system.modes])
    runs, values = _runs(system.A)
    elasticity = np.array([modes.axial_stiffness / (2.0 * modes.length) for modes in system.modes])
    _run(
        motion,
        (1.0 / system.mass, system.stiffness, system.loss),
        (runs, values, values / system.mass, system.compliance),
        (*_runs(system.dampers), len(system.dampers)),
        (*_runs(shapes), pushes),
        (np.array(strings).reshape(-1, 3), kappa, elasticity),
        b,
        (step, DAMPING_VELOCITIES[damping_velocity] * step, kept_steps.start, kept_steps.step, PASSES),
        (kept_q, kept_v, kept_force),
    )
    return kept_q, kept_v, kept_force


def _runs(rows):
    """Rows as runs of consecutive columns that are not zero throughout: (run -> row, start, stop) and their values.

    Returns
    -------
    where : ndarray (n_runs, 3) int64
    values : ndarray (n_runs, n)
        The whole rows, for reading at ``start`` to ``stop``.
    """
    where, chosen = [], []
    for number, row in enumerate(rows):
        columns = np.flatnonzero(row)
        if not len(columns):
            continue
        breaks = np.flatnonzero(np.diff(columns) > 8)  # shorter gaps of zeros are multiplied with the rest
        starts = np.concatenate([columns[:1], columns[breaks + 1]])
        stops = np.concatenate([columns[breaks], columns[-1:]]) + 1
        for start, stop in zip(starts, stops, strict=True):
            where.append((number, start, stop))
            chosen.append(row)
    width = rows.shape[1]
    return np.array(where, np.int64).reshape(-1, 3), np.array(chosen, float).reshape(-1, width)


@numba.njit(**_OPTIONS)
def _gather(runs, values, vector, out, sign):
    """Add ``sign`` rows . vector to ``out``."""
    for k in range(len(runs)):
        row, start, stop = runs[k, 0], runs[k, 1], runs[k, 2]
        total = 0.0
        for n in range(start, stop):
            total += values[k, n] * vector[n]
        out[row] += sign * total


@numba.njit(**_OPTIONS)
def _scatter(runs, values, weights, out, sign):
    """Add ``sign`` rows^T . weights to ``out``."""
    for k in range(len(runs)):
        row, start, stop = runs[k, 0], runs[k, 1], runs[k, 2]
        weight = sign * weights[row]
        if weight != 0.0:
            for n in range(start, stop):
                out[n] += values[k, n] * weight


@numba.njit(**_OPTIONS)
def _stretch(strings, kappa, elasticity, q, force):
    """Kirchhoff-Carrier (Eq. 20) of every string that has an axial stiffness."""
    first = 0
    for s in range(len(strings)):
        on_y, on_z, count = strings[s, 0], strings[s, 1], strings[s, 2]
        if elasticity[s] > 0.0:
            total = 0.0
            for n in range(count):
                total += kappa[first + n] * (q[on_y + n] * q[on_y + n] + q[on_z + n] * q[on_z + n])
            tension = elasticity[s] * total
            for n in range(count):
                force[on_y + n] -= kappa[first + n] * tension * q[on_y + n]
                force[on_z + n] -= kappa[first + n] * tension * q[on_z + n]
        first += count


@numba.njit(**_OPTIONS)
def _run(motion, diagonals, constraints, dampers, forcing, stretching, b, times, kept):
    lightness, stiffness, loss = diagonals
    runs, values, per_mass, compliance = constraints
    damper_runs, damper_values, n_dampers = dampers
    push_runs, push_values, pushes = forcing
    strings, kappa, elasticity = stretching
    step, ahead, first_kept, keep, passes = times
    done = 0
    q, v, a = motion[0], motion[1], motion[2]
    n_modes, n_rows = len(q), b.shape[1]
    force, early = np.empty(n_modes), np.empty(n_modes)
    missing, reaction, total = np.empty(n_rows), np.empty(n_rows), np.empty(n_rows)
    resistance = np.empty(n_dampers)
    for k in range(len(pushes)):
        for n in range(n_modes):
            q[n] += step * v[n] + 0.5 * step * step * a[n]
            early[n] = v[n] + ahead * a[n]
            v[n] += 0.5 * step * a[n]
            force[n] = -loss[n] * early[n] - stiffness[n] * q[n]
        _scatter(push_runs, push_values, pushes[k], force, 1.0)
        if n_dampers > 0:
            resistance[:] = 0.0
            _gather(damper_runs, damper_values, early, resistance, 1.0)
            _scatter(damper_runs, damper_values, resistance, force, -1.0)
        _stretch(strings, kappa, elasticity, q, force)
        for n in range(n_modes):
            a[n] = force[n] * lightness[n]
        for row in range(n_rows):
            total[row] = 0.0
        for _ in range(passes):
            for row in range(n_rows):
                missing[row] = b[k, row]
            _gather(runs, values, a, missing, -1.0)
            for row in range(n_rows):
                reaction[row] = 0.0
                for other in range(n_rows):
                    reaction[row] += compliance[row, other] * missing[other]
                total[row] += reaction[row]
            _scatter(runs, per_mass, reaction, a, 1.0)
        for n in range(n_modes):
            v[n] += 0.5 * step * a[n]
        if done < len(kept[0]) and k == first_kept + keep * done:
            kept[0][done], kept[1][done], kept[2][done] = q, v, total
            done += 1
