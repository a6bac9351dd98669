"""A note on the reference solver, plucked within 40 microseconds and let ring: its bridge forces and their rate."""

from dataclasses import replace

import numpy as np

from ukrt.reference import compiled
from ukrt.reference.system import make_system

from .notes import PLUCKS, SECONDS, TEST_PLUCK, pluck_place, tuned_and_held

PLUCK_TIME = 4e-5  # s: about the engine's two samples
CHUNK = 4096  # kept samples at once: what the motion of all modes needs of memory
ROOM = 1.25  # the record's rate over twice the basis: kept samples must not fold, and Verlet is a little sharp


def one_direction(system, polarization):
    """The part of a reference system that moves in Y (with the body) or in Z: they are independent when linear."""
    n, contacts = len(system.modes), len(system.points)
    in_y = polarization == "Y"
    strings = system.strings_y if in_y else system.strings_z
    fingers = system.fingers_y if in_y else system.fingers_z
    slices = [*strings, system.body, fingers] if in_y else [*strings, fingers]
    columns = np.concatenate([np.arange(part.start, part.stop) for part in slices])
    if in_y:
        rows = np.concatenate([np.arange(n), 2 * n + np.arange(contacts)])
    else:
        rows = np.concatenate([n + np.arange(n), 2 * n + contacts + np.arange(contacts)])
    assert not np.any(np.delete(system.A[rows], columns, axis=1)), "the two directions are coupled"
    ends = np.cumsum([0, *(part.stop - part.start for part in slices)])
    parts = tuple(slice(int(a), int(b)) for a, b in zip(ends[:-1], ends[1:], strict=True))
    return replace(
        system,
        mass=system.mass[columns],
        stiffness=system.stiffness[columns],
        loss=system.loss[columns],
        dampers=system.dampers[:, columns],
        A=system.A[np.ix_(rows, columns)],
        B_plus=system.B_plus[np.ix_(columns, rows)],
        compliance=system.compliance[np.ix_(rows, rows)],
        strings_y=parts[:n],
        strings_z=parts[:n],
        body=parts[n] if in_y else slice(0, 0),
        fingers_y=parts[-1],
        fingers_z=parts[-1],
    )


def kept_every(basis_hz, step):
    """Every how many steps a sample is kept."""
    return max(1, int(1.0 / (2.0 * ROOM * basis_hz * step)))


def respond(system, row, step, seconds, keep=1):
    """Push with 1 N along ``row`` for the steps of `PLUCK_TIME`, from rest, and let go.

    Returns
    -------
    forces : ndarray (samples, rows) [N]
        Constraint forces, every ``keep``-th step; sample 0 is at time keep * step. The push acts from step 1 on.
    moved : ndarray (samples,) [m]
        Displacement along ``row``.
    """
    motion = np.zeros((3, system.count))
    n_steps, pushed = int(round(seconds / step / keep)) * keep, push_steps(step)
    pushes, nil = np.zeros((n_steps, 1)), np.zeros((n_steps, len(system.A)))
    pushes[:pushed] = TEST_PLUCK
    forces, moved = [], []
    for first in range(0, n_steps, CHUNK * keep):
        part = slice(first, min(first + CHUNK * keep, n_steps))
        kept = range(keep - 1, part.stop - first, keep)
        q, _, force = compiled.run(system, motion, step, pushes[part], row[None], nil[part], kept)
        forces.append(force)
        moved.append(q @ row)
    return np.concatenate(forces), np.concatenate(moved)


def push_steps(step):
    """For how many steps the pluck pushes."""
    return max(1, int(round(PLUCK_TIME / step)))


def reference_record(guitar, intonation, note, step, seconds=SECONDS):
    """Bridge forces after two plucks side by side, as `engine_record` has them, and the rate of the samples [Hz]."""
    tuned, held = tuned_and_held(guitar, intonation, note)
    system = one_direction(make_system(tuned, held), note.polarization)
    length, n, runs = guitar.strings[note.string].length, len(guitar.strings), []
    keep = kept_every(guitar.basis.bandwidth_hz, step)
    for share in PLUCKS:
        place = pluck_place(guitar, intonation, note, share) * length
        forces, _ = respond(system, system.shape(note.string, place, "Y"), step, seconds, keep)
        forces = forces[push_steps(step) // keep + 1 :, :n]
        others = forces.sum(axis=1) - forces[:, note.string]
        runs += [forces[:, note.string]] if note.polarization == "Z" else [forces[:, note.string], others]
    return np.stack(runs, axis=1), 1.0 / (step * keep)
