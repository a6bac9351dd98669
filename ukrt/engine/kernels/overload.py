"""When to shed: the load of each live block enters, the level wanted from the next block on leaves (G_SHED_WANTED).

The only part of shedding that looks at a clock; whoever plays a take again leaves it out and uses the noted levels.
"""

from ukrt.engine import stage_layout as at
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.shed import HIGHEST

# All choices. One block that was interrupted must not shed, two are no accident.
BLOCKS, MOST_LATE = 8, 1  # of so many blocks, so many may be above the budget
RISE_SECONDS = 0.05  # least time between two steps up: long enough to feel what the last one has brought
COOL_SECONDS, COOL_SHARE = 2.0, 0.6  # one step down after this long with every block below this share of the budget
_HISTORY = (1 << BLOCKS) - 1  # G_SHED_HOT: a bit for each of the last blocks, above them the frames to wait


@kernel
def watch_load(si, sd, load):
    """Note that the block that has just ended took ``load`` of its period.

    Reads M_SHED_BUDGET (0: nothing is done at all), G_STAMP_BLOCK and M_RATE; keeps G_SHED_HOT and G_SHED_COOL.
    """
    budget = sd[at.M_SHED_BUDGET]
    if not budget > 0.0:
        return
    frames, wanted = si[at.G_STAMP_BLOCK], si[at.G_SHED_WANTED]
    history = ((si[at.G_SHED_HOT] << 1) | (1 if load > budget else 0)) & _HISTORY
    wait = max(0, (si[at.G_SHED_HOT] >> BLOCKS) - frames)
    cool = si[at.G_SHED_COOL] + frames if load < COOL_SHARE * budget else 0
    if _count_bits(history) > MOST_LATE and wait == 0 and wanted < HIGHEST:
        wanted += 1
        history, wait, cool = 0, int(RISE_SECONDS * sd[at.M_RATE]), 0
    elif cool >= COOL_SECONDS * sd[at.M_RATE]:
        wanted, cool = max(0, wanted - 1), 0
    si[at.G_SHED_WANTED], si[at.G_SHED_COOL] = wanted, cool
    si[at.G_SHED_HOT] = wait << BLOCKS | history


@kernel
def _count_bits(bits):
    count = 0
    for k in range(BLOCKS):
        count += (bits >> k) & 1
    return count
