"""A note on the engine's compiled loop, plucked within two samples and let ring: its bridge forces leave."""

import numpy as np

from ukrt.engine import gestures
from ukrt.engine import layout as at
from ukrt.engine.discretize import fill_instance, make_arrays
from ukrt.engine.kernels.advance import advance
from ukrt.engine.kernels.hands import perform

from .notes import PLUCKS, SECONDS, TEST_PLUCK, note_place, pluck_place


def engine_record(guitar, intonation, note, sample_rate, seconds=SECONDS):
    """Bridge forces after two plucks side by side [N]: the own string's and the other strings' sum, (samples, 4).

    In Z it is the constraint force of the note's own string, the others have none: (samples, 2).
    """
    d, i = make_arrays()
    own, runs = note.string, []
    for share in PLUCKS:
        fill_instance(d, i, guitar, intonation, sample_rate)
        if note.fret:
            perform(d, i, gestures.PRESS, own, note_place(intonation, note), 1.0, 0.0, 0.0)
            advance(d, i, at.CHUNK)
        angle = 0.0 if note.polarization == "Y" else 0.5 * np.pi
        place = pluck_place(guitar, intonation, note, share)
        perform(d, i, gestures.PLUCK, own, place, TEST_PLUCK, angle, 2.0)
        advance(d, i, at.CHUNK)
        assert i[at.H_BUSY] == 0, "a gesture is still under way"
        count = int(seconds * sample_rate)
        runs.append(forces_y(d, i, count, own) if note.polarization == "Y" else _forces_z(d, i, count, own))
    return np.concatenate(runs, axis=1)


def forces_y(d, i, count, string):
    """Go on for about ``count`` samples: force of ``string`` on the bridge and the others' sum, (samples, 2) [N]."""
    out = np.empty((count // at.CHUNK, at.CHUNK, at.LANES))
    forces = d[at.STRINGS_OUT : at.STRINGS_OUT + at.CHUNK * at.LANES].reshape(at.CHUNK, at.LANES)
    for block in out:
        advance(d, i, at.CHUNK)
        block[:] = forces
    out = out.reshape(-1, at.LANES)
    return np.stack([out[:, string], out.sum(axis=1) - out[:, string]], axis=1)


def _forces_z(d, i, count, string):
    out = np.empty((count, 1))
    for k in range(count):
        advance(d, i, 1)
        out[k] = d[at.LAM_Z + string]
    return out
