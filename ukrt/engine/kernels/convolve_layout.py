"""How a convolver is laid out and what it does when: the number of taps in, offsets and a programme out.

The response is cut into a head of 64 taps, run directly, and levels of equal partitions, run by FFT: from tap 64
partitions of 64, from tap 1024 of 512, from tap 8192 of 4096 (Gardner, J. Audio Eng. Soc. 43(3), 127-136, 1995). A
level of size N has its input block complete at a frame t that is a multiple of N, and its result is first heard at
t + N (the 64s: at t); so it has N / 64 blocks of 64 frames to work in, and here is written down, once, which share of
which pass falls to which of them. Where a level has two partitions or more, products are summed for two of its periods
at once, in one half of the bins in even periods, in the other in odd ones: responses are read half as often.
"""

import dataclasses

from ukrt.engine.kernels.fft_tables import fft_table_size, place_of

BLOCK = 64
SIZES = (64, 512, 4096)  # partitions of the levels [taps], each eight times the last
STARTS = (64, 1024, 8192)  # first tap of each level: twice its size, but for the first
MAX_TAPS = 400_000  # 2 s at 192 kHz, and some more
RADIX = 8  # of the first pass of the larger two sizes

# Header of vi: offsets into v, except where said otherwise
LEVELS, IN_RING, IN_LENGTH, TAIL, TAIL_LENGTH, HEAD, SUMS, STATE_START, STATE_STOP, SHED, DROP = range(11)
HEADER = 16
# SHED: how many of the last levels are to be silent; DROP and the next two: whether a level's present period is
WHOLE, DROPPED, HEARD = range(3)  # nothing of it heard yet; not computed; its sound has begun: too late to drop it
MISSING = 4  # and on top, if the period before was dropped: what that would have summed up for this one is not there
# A level's record in vi; PROGRAM is an offset into vi: for every slot the first step's offset, then the last step's end
SIZE, DELAY, PARTITIONS, SPECTRA, INPUTS, WORK, PRODUCT, LATER, PROGRAM = range(9)
RECORD = 9
# A step of a programme in vi
OP, CHANNEL, FIRST, STOP, STRIDE, TABLE = range(6)
STEP = 6
# A transform of 64 samples and its inverse are one step each (WHOLE), larger ones several
OP_WHOLE, OP_FIRST, OP_MIDDLE, OP_TILES, OP_PRODUCT, OP_UNTILE, OP_BACK, OP_ADD, OP_WHOLE_BACK = range(9)

GROUP = 16  # frames whose direct sums are made at once

# Measured cost of one unit of work [ns, only the ratios matter]: they decide where the programme is cut
_PASS_COST, _LEAF_COST = 16.0, 28.0  # 64 points of one pass, and of the two that end in tiles
_TILE_COST = (10.0, 3.0)  # a tile of the product, and of each partition in it


@dataclasses.dataclass(frozen=True)
class Level:
    """One level: its size [taps], delay from the block's end to the first frame heard, partitions, and offsets."""

    size: int
    start: int
    delay: int
    partitions: int
    table: int
    spectra: int
    inputs: int
    work: int
    product: int
    later: int


@dataclasses.dataclass(frozen=True)
class Plan:
    """Everything about a convolver that follows from the number of taps; ``integers`` is what ``vi`` holds."""

    n_taps: int
    head: int
    levels: tuple
    len_v: int
    integers: tuple


class _Ground:
    """Hands out sections of ``v`` on 64-byte boundaries."""

    def __init__(self):
        self.top = 0

    def take(self, size):
        at = self.top
        self.top += -(-size // 8) * 8
        return at


def make_plan(n_taps):
    """The layout of a convolver of ``n_taps`` taps (1 to MAX_TAPS)."""
    if not 1 <= n_taps <= MAX_TAPS:
        raise ValueError(f"a convolver takes 1 to {MAX_TAPS} taps, not {n_taps}")
    ground = _Ground()
    ends = (*STARTS[1:], MAX_TAPS + SIZES[-1])
    used = []
    for size, start, end in zip(SIZES, STARTS, ends, strict=True):
        if n_taps > start:
            used.append((size, start, -(-(min(n_taps, end) - start) // size)))
    head = ground.take(4 * BLOCK)
    fixed = [(ground.take(fft_table_size(size)), ground.take(8 * size * count)) for size, _, count in used]
    state_start = ground.top
    sums = ground.take(2 * BLOCK)
    longest = used[-1][0] if used else BLOCK
    in_ring, tail = ground.take(2 * (BLOCK + 2 * longest)) + BLOCK, ground.take(2 * place_of(4 * longest))
    levels = tuple(
        Level(size, start, start - size, count, table, spectra, ground.take(4 * size * count), *_scratch(ground, size))
        for (size, start, count), (table, spectra) in zip(used, fixed, strict=True)
    )
    header = [len(levels), in_ring, 2 * longest, tail, 4 * longest, head, sums, state_start, ground.top]
    integers = _integers(header, levels)
    return Plan(n_taps, head, levels, ground.top, tuple(integers))


def _scratch(ground, size):
    return ground.take(4 * place_of(size)), ground.take(4 * size), ground.take(4 * size)


def _integers(header, levels):
    """The contents of ``vi``: header, records, then each level's programme."""
    numbers = header + [0] * (HEADER - len(header) + RECORD * len(levels))
    for j, level in enumerate(levels):
        at = HEADER + RECORD * j
        numbers[at : at + RECORD] = [
            level.size,
            level.delay,
            level.partitions,
            level.spectra,
            level.inputs,
            level.work,
            level.product,
            level.later,
            len(numbers),
        ]
        slots = make_program(level)
        first = len(numbers) + len(slots) + 1
        for steps in slots:
            numbers.append(first)
            first += STEP * len(steps)
        numbers.append(first)
        for steps in slots:
            for step in steps:
                numbers.extend(step)
    return numbers


def _passes(level):
    """All passes of a level in the order of work: (op, channel, units, cost of a unit, stride, table)."""
    size, units = level.size, level.size // 64
    product = (OP_PRODUCT, 0, size // 16, 2 * (_TILE_COST[0] + _TILE_COST[1] * level.partitions), 0, 0)
    there, back = (32 * level.partitions, level.table), (32, level.table)
    if size == BLOCK:
        whole = [(OP_WHOLE, channel, 1, _LEAF_COST, *there) for channel in (0, 1)]
        return [*whole, product, *((OP_WHOLE_BACK, channel, 1, _LEAF_COST, *back) for channel in (0, 1))]
    early, nodes, table, stride = [], 1, level.table, size // RADIX
    while stride > 8:
        early.append((stride, table))
        table += 8 * nodes
        nodes, stride = 8 * nodes, stride // 8
    passes = []
    for channel in (0, 1):
        for number, place in enumerate(early):
            passes.append((OP_MIDDLE if number else OP_FIRST, channel, units, _PASS_COST, *place))
        passes.append((OP_TILES, channel, units, _LEAF_COST, there[0], table))
    passes.append(product)
    for channel in (0, 1):
        passes.append((OP_UNTILE, channel, units, _LEAF_COST, back[0], table))
        for number, place in reversed(list(enumerate(early))):
            passes.append((OP_BACK if number else OP_ADD, channel, units, _PASS_COST, *place))
    return passes


def make_program(level):
    """Cut a level's passes into equal shares, one for each of its N / 64 slots (list of lists of steps)."""
    passes = _passes(level)
    n_slots = level.size // BLOCK
    total = sum(units * cost for _, _, units, cost, _, _ in passes)
    slots = [[] for _ in range(n_slots)]
    done = 0.0
    for op, channel, units, cost, stride, table in passes:
        for unit in range(units):
            steps = slots[int((done + cost / 2) * n_slots / total)]
            if steps and steps[-1][:2] == [op, channel] and steps[-1][STRIDE] == stride:
                steps[-1][STOP] = unit + 1
            else:
                steps.append([op, channel, unit, unit + 1, stride, table])
            done += cost
    return slots
