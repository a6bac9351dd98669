"""Used by ``bench_peers``: the paper's scheme in NumPy, as quick as NumPy makes it, on the first seconds of the piece.

    python -m peers.paper_numpy SECONDS OUT.wav

What `ukrt.reference.definition` defines, but linear (no stretching), with one fingering throughout (E2 held at its
fifth fret, as in the paper's Fig. 6), and factored: the inertia-weighted projection of Eq. 5 is two thin matrices,
A (rows, modes) and M^-1/2 B^+ (modes, rows), each multiplied by the compiled BLAS, in one pass; the n x n projection
is never formed. All arrays are reused; nothing is allocated within a step. One string is pulled at a time: the newest.
"""

import sys

import numpy as np
import soundfile

from ukrt.experiment.case import Case, HeldString
from ukrt.model.presets import load_preset
from ukrt.reference.system import make_system

from . import piece

STEP = 1e-5  # s, the paper's
PULL_S, PULL_N = 0.010, 5.0  # a force that grows for so long, then lets go
PLACE = 0.9  # of the length
KEEP = 2  # every second step is a sample
PEAK = 0.1  # of what is written; nothing here has a loudness


def pluck_steps(notes, shapes):
    """When which string is pulled, by the number of the step: dict of int to ndarray (modes,) [N per step] or None."""
    changes = {}
    for note in notes:
        first = int(round(note.start / STEP))
        changes[first] = shapes[note.string] * (PULL_N * note.velocity / 127 / (PULL_S / STEP))
        changes.setdefault(first + int(round(PULL_S / STEP)), None)
    return changes


def run(system, notes, seconds):
    """The body's velocity, summed over its modes: ndarray (n,)."""
    shapes = [system.shape(n, PLACE * modes.length, "Y") / system.mass for n, modes in enumerate(system.modes)]
    changes = pluck_steps(notes, shapes)
    stiffness, loss = -system.stiffness / system.mass, -system.loss / system.mass
    rows, back = np.ascontiguousarray(system.A), system.B_plus / np.sqrt(system.mass)[:, None]
    q, v, a, term, early, push = np.zeros((6, system.count))
    missing, body, growth = np.zeros(len(rows)), slice(system.body.start, system.body.stop), None
    heard = np.zeros(int(round(seconds / STEP)))
    for k in range(len(heard)):
        np.multiply(a, STEP, out=term)
        np.add(v, term, out=early)
        term *= 0.5
        v += term  # at the half step
        np.multiply(v, STEP, out=term)
        q += term
        np.multiply(q, stiffness, out=a)
        np.multiply(early, loss, out=term)
        a += term
        if k in changes:
            growth = changes[k]
            push[:] = 0.0
        if growth is not None:
            push += growth
            a += push
        np.dot(rows, a, out=missing)
        np.dot(back, missing, out=term)
        a -= term
        np.multiply(a, 0.5 * STEP, out=term)
        v += term
        if k % KEEP == 0:
            heard[k] = v[body].sum()
    return heard[::KEEP]


if __name__ == "__main__":
    seconds, target = float(sys.argv[1]), sys.argv[2]
    guitar = load_preset("paper")
    case = Case("bench", seconds, guitar, held=(HeldString("E2", 0.2509),))
    sound = run(make_system(guitar, case.held_points(0.0)), piece.first_seconds(piece.make_piece(), seconds), seconds)
    soundfile.write(target, PEAK * sound / np.abs(sound).max(), round(1.0 / STEP / KEEP), subtype="FLOAT")
