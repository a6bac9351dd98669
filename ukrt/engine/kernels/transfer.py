"""Another guitar in the same hands: what sounds and what is held in one instance goes over into a fresh one.

Enter the arrays of two instances, the second as it was filled (at rest, its own tables), and the frame at which it
takes over; leave in the second everything that rings, presses, damps, waits and counts. The first is only read, but
for its scratch, and can run on for a crossfade. What is the same in both (a string with its fingers, the body, the
convolver's plan) is copied to the bit; what differs is carried over by these rules:

- A mode keeps its phase and its energy, m (omega^2 q^2 + q'^2) / 2, mode by mode (``carry_mode``). So a swap gives no
  energy, however often it is done, and the string sounds on at the new guitar's pitch; its displacement grows where
  the new string is softer: by sqrt((T / L) / (T' / L')). Modes that the new basis lacks are lost.
- Forces that bend a string (bridge, fingers, pluck) hold the deflection they held before, at their places on the new
  one: a kink moves with its finger. What then still misses the bridge is made up by a deflection from there, what
  misses a finger is eased back to it as when one lands. So nothing snaps.
- Ramps of plucks, lifts, dampers and bends go on where they were; a slide sets out anew for its goal; a landing is done
  anew from where the string is.

At one sample rate frames stay what they are; at another, what is to come is scaled about the present frame.
"""

import numpy as np

from ukrt.engine import layout as at
from ukrt.engine.kernels import convolve_layout as convolver
from ukrt.engine.kernels.energy import total_energy
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.ports import count_contacts
from ukrt.engine.kernels.solve import P_PUSH
from ukrt.engine.kernels.transfer_join import bound_energy, join_string
from ukrt.engine.kernels.transfer_modes import carry_mode, same_energy
from ukrt.engine.kernels.transfer_player import transfer_player
from ukrt.engine.kernels.transfer_strings import carry_string, copy_string, same_string

MOST_ENERGY = 2.0  # times what there was, that a swap may leave (choice; between shipped presets 0.97 to 1.05)


@kernel
def transfer_state(d0, i0, v0, vi0, d1, i1, v1, vi1, now):
    """Let instance 1 go on from where instance 0 stands before frame ``now``.

    Parameters
    ----------
    d0, i0, v0, vi0 : ndarray
        The instance that has sounded until now.
    d1, i1, v1, vi1 : ndarray
        A fresh one: filled, its player reset and given its tables, its convolver prepared.
    now : int
        The absolute frame that both would compute next.
    """
    pace = d1[at.METER + at.M_RATE] / d0[at.METER + at.M_RATE]
    same_body = _same_body(d0, i0, d1, i1, pace)
    if same_body:
        _copy_body(d0, d1)
    else:
        _carry_body(d0, d1)
    for s in range(min(i0[at.H_STRINGS], i1[at.H_STRINGS])):
        same = same_string(d0, i0, d1, i1, s)
        if same:
            copy_string(d0, i0, d1, i1, s)
        else:
            carry_string(d0, i0, d1, i1, s, pace)
        if not (same and same_body):
            join_string(d1, i1, s)
    most = 0
    for s in range(i1[at.H_STRINGS]):
        most = max(most, count_contacts(i1, s))
    i1[at.H_PORTS], i1[at.H_BUSY] = 1 + most, 1
    bound_energy(d1, i1, MOST_ENERGY * total_energy(d0, i0))
    transfer_player(d0, i0, d1, i1, now, pace)
    if pace == 1.0 and i0[at.H_CONVOLVE] and i1[at.H_CONVOLVE] and _same_plan(vi0, vi1):
        # 1.5 MB of a half-second response; unsigned, or each index is looked at for a sign: twice the time
        for k in range(convolver.SHED, convolver.DROP + len(convolver.SIZES)):
            vi1[k] = vi0[k]
        for k in range(np.uint64(vi0[convolver.STATE_START]), np.uint64(vi0[convolver.STATE_STOP])):
            v1[k] = v0[k]


@kernel
def _same_body(d0, i0, d1, i1, pace):
    """Whether both bodies are the same at the same sample rate."""
    if pace != 1.0 or i0[at.H_BODY] != i1[at.H_BODY]:
        return False
    for n in range(at.MAX_BODY_MODES):
        for base in (at.BODY_A, at.BODY_B, at.BODY_BASS, at.BODY_SLOPE):
            if d0[base + n] != d1[base + n]:
                return False
    return True


@kernel
def _copy_body(d0, d1):
    for n in range(at.MAX_BODY_MODES):
        d1[at.BODY_X + n], d1[at.BODY_XS + n] = d0[at.BODY_X + n], d0[at.BODY_XS + n]
    d1[at.BODY_W + 3], d1[at.BODY_W + 4] = d0[at.BODY_W + 3], d0[at.BODY_W + 4]


@kernel
def _count_body(d):
    count = 0
    for n in range(at.MAX_BODY_MODES):
        count += 1 if d[at.BODY_B + n] != 0.0 else 0
    return count


@kernel
def _carry_body(d0, d1):
    """Mode by mode where both bodies have the same number of modes; else the new body starts at rest.

    A mode whose shape points the other way in the new body is turned round: it is the bridge's motion that goes on.
    """
    d1[at.BODY_W + 3] = d1[at.BODY_W + 4] = 0.0
    if _count_body(d0) != _count_body(d1):
        return
    for n in range(at.MAX_BODY_MODES):
        a0, b0, a1, b1 = d0[at.BODY_A + n], d0[at.BODY_B + n], d1[at.BODY_A + n], d1[at.BODY_B + n]
        if b1 == 0.0:
            continue
        bass0, slope0 = d0[at.BODY_BASS + n], d0[at.BODY_SLOPE + n]
        bass1, slope1 = d1[at.BODY_BASS + n], d1[at.BODY_SLOPE + n]
        sign = -1.0 if bass0 * bass1 + (bass0 + slope0) * (bass1 + slope1) < 0.0 else 1.0
        held = (bass0 * d0[at.PAIR + P_PUSH] + slope0 * d0[at.PAIR + P_PUSH + 1]) / (1.0 - a0 - b0)
        held1 = same_energy(a0, b0, a1, b1) * held
        now, coming = carry_mode(d0[at.BODY_X + n], d0[at.BODY_XS + n], held, held1, a0, b0, a1, b1)
        now, coming = sign * now, sign * coming
        d1[at.BODY_X + n], d1[at.BODY_XS + n] = now, coming
        d1[at.BODY_W + 3] += bass1 * coming
        d1[at.BODY_W + 4] += slope1 * coming


@kernel
def _same_plan(vi0, vi1):
    """Whether two convolvers are laid out alike: what they hold then means the same, whatever their responses."""
    n = convolver.HEADER + convolver.RECORD * vi0[convolver.LEVELS]
    if n > len(vi0) or n > len(vi1):
        return False
    for k in range(n):
        state = convolver.SHED <= k < convolver.DROP + len(convolver.SIZES)  # what is left out now: no part of the plan
        if vi0[k] != vi1[k] and not state:
            return False
    return True
