"""The loop over samples: strings, fingers and body advance together; the bridge's forces come out.

Enter the state and a number of samples (at most CHUNK); leave the state that many samples on, and the force on the
body at the bass and the treble end of the bridge for each of them.
"""

from ukrt.engine import layout as at
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.ramps import begin_sample, end_sample, push_strings
from ukrt.engine.kernels.sleep import rest_string
from ukrt.engine.kernels.solve import P_PUSH, solve_constraints
from ukrt.engine.kernels.sweep import sweep_string


@kernel
def advance(d, i, n_samples):
    """Advance everything by ``n_samples``; forces in newtons to BRIDGE (bass, then treble) and STRINGS_OUT."""
    n_strings, body_vectors = i[at.H_STRINGS], i[at.H_BODY]
    shedding = i[at.H_SHED] > 0
    for k in range(n_samples):
        if i[at.H_BUSY]:
            begin_sample(d, i)
        solve_constraints(d, n_strings, i[at.H_PORTS], body_vectors)
        if i[at.H_BUSY]:
            push_strings(d, i)
        treble = d[at.PAIR + P_PUSH + 1]
        d[at.BRIDGE + k] = d[at.PAIR + P_PUSH] - treble
        d[at.BRIDGE + at.CHUNK + k] = treble
        for s in range(at.LANES):
            d[at.STRINGS_OUT + k * at.LANES + s] = -d[at.LAM_Y + s]
        for s in range(n_strings):
            own_i = at.STRING_I + s * at.STRING_I_SIZE
            if shedding and i[own_i + at.SI_SLEEP] == at.ASLEEP:
                rest_string(d, s)
            else:
                sweep_string(d, i, s)
        if i[at.H_BUSY]:
            end_sample(d, i)
