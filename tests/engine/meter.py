"""A meter beside the engine's loop: where each sample's energy came from and where it went.

It runs the engine's own kernels one by one and evaluates, from the states before and after, the work of plucks, the
work of constraints (moving offsets, moving contacts) and the losses of every mode, each by its own formula. What is
left between two samples are the jumps at gestures: new ports, lifted fingers, changed tension.
"""

from ukrt.engine import layout as at
from ukrt.engine.kernels.energy import total_energy
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.motion import flow_back, position
from ukrt.engine.kernels.ports import count_contacts
from ukrt.engine.kernels.process import perform_due
from ukrt.engine.kernels.ramps import begin_sample, end_sample, push_strings
from ukrt.engine.kernels.solve import solve_constraints
from ukrt.engine.kernels.sweep import sweep_string

PLUCK, CONSTRAINT, LOSS, JUMP_UP, JUMP_DOWN, LARGEST_ERROR, LARGEST_ENERGY, FRAME = range(8)


@kernel
def metered_steps(d, i, n_samples, ledger, saved):
    """Advance by ``n_samples`` and add up the ledger; ``saved`` is room for a copy of ``d``'s states."""
    for _ in range(n_samples):
        start = total_energy(d, i)
        perform_due(d, i, int(ledger[FRAME]))
        begin_sample(d, i)
        before = total_energy(d, i)
        _book_jump(ledger, before - start)
        for k in range(at.COEF):
            saved[k] = d[k]
        for k in range(at.FIN_Y, at.FIN_A):
            saved[k] = d[k]
        for k in range(at.BODY_X, at.BODY_A):
            saved[k] = d[k]
        solve_constraints(d, i[at.H_STRINGS], i[at.H_PORTS], i[at.H_BODY])
        push_strings(d, i)
        for s in range(i[at.H_STRINGS]):
            sweep_string(d, i, s)
        after = total_energy(d, i)
        work, loss = 0.0, _body_loss(d, i, saved)
        for s in range(i[at.H_STRINGS]):
            pluck, constraint, lost = _string_books(d, i, s, saved)
            ledger[PLUCK] += pluck
            ledger[CONSTRAINT] += constraint
            work, loss = work + pluck + constraint, loss + lost
        work += _bridge_work(d, i, saved)
        ledger[LOSS] += loss
        ledger[LARGEST_ENERGY] = max(ledger[LARGEST_ENERGY], after)
        ledger[LARGEST_ERROR] = max(ledger[LARGEST_ERROR], abs(after - before - work + loss))
        end_sample(d, i)
        _book_jump(ledger, total_energy(d, i) - after)
        ledger[FRAME] += 1.0


@kernel
def _book_jump(ledger, jump):
    if jump > 0.0:
        ledger[JUMP_UP] += jump
    else:
        ledger[JUMP_DOWN] -= jump


@kernel
def _older(d, saved, x, c):
    """Where a mode was before the states in ``saved``: one sample earlier than ``saved`` has it."""
    now = saved[x] / d[c + at.COEF_D] if d[c + at.COEF_D] != 0.0 else saved[x]
    return (saved[x + 8] - d[c + at.COEF_A] * now) / flow_back(d, c)


@kernel
def _string_books(d, i, s, saved):
    """Work of the pluck and of the contacts, and losses of one string and its fingers, over one sample."""
    own_i = at.STRING_I + s * at.STRING_I_SIZE
    n_contacts = count_contacts(i, s)
    pluck, constraint, loss = 0.0, 0.0, 0.0
    for tile in range(i[own_i + at.SI_TILE], i[own_i + at.SI_TILE] + i[own_i + at.SI_TILES]):
        x, c = at.STATE + tile * at.STATE_TILE, at.COEF + tile * at.COEF_TILE
        for lane in range(8):
            b = flow_back(d, c + lane % 4)
            if b == 0.0:
                continue
            step = position(d, x + lane, c + lane % 4) - _older(d, saved, x + lane, c + lane % 4)
            loss += 0.25 * (1.0 + b) * step * step
            forces = at.LAM_Y if lane < 4 else at.LAM_Z
            for j in range(1, 1 + n_contacts):
                column = d[c + at.COEF_COLUMNS + 4 * j + lane % 4]
                constraint += 0.5 * d[forces + j * at.LANES + s] * column * step
            if i[own_i + at.SI_PLUCK] == 1:
                column = d[c + at.COEF_COLUMNS + 4 * (1 + n_contacts) + lane % 4]
                pluck += 0.5 * d[forces + (1 + n_contacts) * at.LANES + s] * column * step
    for j in range(1, 1 + n_contacts):
        row = j * at.LANES + s
        a, b, g = d[at.FIN_A + row], d[at.FIN_B + row], d[at.FIN_G + row]
        for now_at, next_at, forces in ((at.FIN_Y, at.FIN_Y1, at.LAM_Y), (at.FIN_Z, at.FIN_Z1, at.LAM_Z)):
            older = (saved[next_at + row] - a * saved[now_at + row]) / b if b != 0.0 else 0.0
            step = d[now_at + row] - older
            constraint -= 0.5 * d[forces + row] * step
            if g > 0.0:
                loss += 0.25 * (1.0 + b) / g * step * step
    return pluck, constraint, loss


@kernel
def _bridge_work(d, i, saved):
    """Work of the bridge's constraint forces on strings and body together: nothing, but for rounding."""
    work = 0.0
    for s in range(i[at.H_STRINGS]):
        own_i = at.STRING_I + s * at.STRING_I_SIZE
        for tile in range(i[own_i + at.SI_TILE], i[own_i + at.SI_TILE] + i[own_i + at.SI_TILES]):
            x, c = at.STATE + tile * at.STATE_TILE, at.COEF + tile * at.COEF_TILE
            for lane in range(8):
                if flow_back(d, c + lane % 4) != 0.0:
                    step = position(d, x + lane, c + lane % 4) - _older(d, saved, x + lane, c + lane % 4)
                    force = d[(at.LAM_Y if lane < 4 else at.LAM_Z) + s]
                    work += 0.5 * force * d[c + at.COEF_COLUMNS + lane % 4] * step
    for n in range(8 * i[at.H_BODY]):
        a, b = d[at.BODY_A + n], d[at.BODY_B + n]
        if b != 0.0:
            step = d[at.BODY_X + n] - (saved[at.BODY_XS + n] - a * saved[at.BODY_X + n]) / b
            for s in range(i[at.H_STRINGS]):
                shape = d[at.BODY_BASS + n] + d[at.XI + s] * d[at.BODY_SLOPE + n]
                work -= 0.5 * d[at.LAM_Y + s] * shape * step
    return work


@kernel
def _body_loss(d, i, saved):
    """Losses of the body's modes over one sample; the solver has moved them already."""
    loss = 0.0
    for n in range(8 * i[at.H_BODY]):
        a, b = d[at.BODY_A + n], d[at.BODY_B + n]
        if b != 0.0:
            step = d[at.BODY_X + n] - (saved[at.BODY_XS + n] - a * saved[at.BODY_X + n]) / b
            loss += 0.25 * (1.0 + b) * step * step
    return loss
