"""The loop over samples: strings, fingers and body advance together; the bridge's forces come out.

Enter the state and a number of samples (at most CHUNK); leave the state that many samples on, and the force on the body at
the bass and the treble end of the bridge for each of them.
"""

from ukrt.engine import layout as at
from ukrt.engine.kernels.hands import begin_sample, end_sample, push_strings
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.solve import P_PUSH, solve_constraints
from ukrt.engine.kernels.sweep import sweep_string


@kernel
def advance(d, i, n_samples):
    """Advance everything by ``n_samples``; forces in newtons to BRIDGE (bass, then treble) and STRINGS_OUT."""
    n_strings, n_groups, body_vectors = i[at.H_STRINGS], i[at.H_GROUPS], i[at.H_BODY]
    for k in range(n_samples):
        if i[at.H_BUSY]:
            begin_sample(d, i)
        solve_constraints(d, n_groups, i[at.H_PORTS], body_vectors)
        if i[at.H_BUSY]:
            push_strings(d, i)
        treble = d[at.PAIR + P_PUSH + 1]
        d[at.BRIDGE + k] = d[at.PAIR + P_PUSH] - treble
        d[at.BRIDGE + at.CHUNK + k] = treble
        for s in range(n_strings):
            d[at.STRINGS_OUT + s * at.CHUNK + k] = -d[at.LAM_Y + s]
            own_i = at.STRING_I + s * at.STRING_I_SIZE
            first = i[own_i + at.SI_TILE]
            n_extra = i[own_i + at.SI_FINGER] + i[own_i + at.SI_DAMPER] + i[own_i + at.SI_PLUCK]
            sweep_string(d, first, first + i[own_i + at.SI_TILES], s, n_extra)
        if i[at.H_BUSY]:
            end_sample(d, i)
