"""What a script of gestures brings to a string, held against its work: a guitar and a script enter."""

import numpy as np
from engine.bench import add, on_bench
from engine.meter import CONSTRAINT, JUMP_DOWN, JUMP_UP, LARGEST_ENERGY, LARGEST_ERROR, LOSS, PLUCK, metered_steps

from ukrt.engine import layout as at
from ukrt.engine.kernels.energy import total_energy


def check_balance(guitar, s, script, n_samples, jump_up=1e-6):
    """Every sample balances to rounding, changes of ports only take (up to ``jump_up`` of the work), and no more is
    there than was put in; ``script`` is (frame, kind, string, numbers of the gesture ...), played on string ``s``."""
    d, i = on_bench(guitar)
    for frame, kind, _, *numbers in script:
        add(d, i, frame, kind, s, *numbers)
    ledger, saved = np.zeros(8), np.zeros(at.D_SIZE)
    metered_steps(d, i, n_samples, ledger, saved)
    put_in = ledger[PLUCK] + ledger[CONSTRAINT]
    assert put_in > 1e-5
    assert ledger[LARGEST_ERROR] < 1e-10 * ledger[LARGEST_ENERGY]
    assert ledger[JUMP_UP] < jump_up * put_in
    kept = total_energy(d, i) + ledger[LOSS] - put_in
    assert abs(kept - ledger[JUMP_UP] + ledger[JUMP_DOWN]) < 1e-9 * put_in
    assert kept < 1e-7 * put_in
