"""How a convolver is laid out and what it does when: the number of taps in, offsets and a programme out.

The response is cut into a head of 64 taps, run directly, and levels of equal partitions, run by FFT: from tap 64
partitions of 64, from tap 1024 of 512, from tap 8192 of 4096 (Gardner, J. Audio Eng. Soc. 43(3), 127-136, 1995). A
level of size N has its input block complete at a frame t that is a multiple of N, and its result is first heard at
t + N (the 64s: at t); so it has N / 64 blocks of 64 frames to work in, and here is written down, once, which share of
which pass falls to which of them.
"""

import dataclasses

from ukrt.engine.kernels.fft_tables import fft_radices, fft_table_size

BLOCK = 64
SIZES = (64, 512, 4096)  # partitions of the levels [taps], each eight times the last
STARTS = (64, 1024, 8192)  # first tap of each level: twice its size, but for the first
MAX_TAPS = 400_000  # 2 s at 192 kHz, and some more
RADIX = 8  # of the first pass of all three sizes

# Header of vi: offsets into v, except where said otherwise
LEVELS, IN_RING, IN_LENGTH, TAIL, TAIL_LENGTH, HISTORY, HEAD, SUMS, STATE_START, STATE_STOP, SHED, DROP = range(12)
HEADER = 16
# SHED: how many of the last levels are to be silent; DROP and the next two: whether a level's present period is
WHOLE, DROPPED, HEARD = range(3)  # nothing of it heard yet; not computed; its sound has begun: too late to drop it
# A level's record in vi; PROGRAM is an offset into vi: for every slot the first step's offset, then the last step's end
SIZE, DELAY, PARTITIONS, SPECTRA, INPUTS, WORK, PRODUCT, PROGRAM = range(8)
RECORD = 8
# A step of a programme in vi
OP, CHANNEL, FIRST, STOP, STRIDE, TABLE = range(6)
STEP = 6
OP_FIRST, OP_MIDDLE, OP_TILES, OP_PRODUCT, OP_UNTILE, OP_BACK, OP_ADD = range(7)

HISTORY_LENGTH = 2 * BLOCK + 8  # the block before, this one, and what a group of four samples may look at beyond it

# Measured cost of one unit of work [ns, only the ratios matter]: they decide where the programme is cut
_PASS_COST = 14.0
_TILE_COST = (5.0, 3.0)  # a tile of the product, and of each partition in it


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
    sums, history = ground.take(8), ground.take(2 * HISTORY_LENGTH)
    longest = used[-1][0] if used else BLOCK
    in_ring, tail = ground.take(2 * 2 * longest), ground.take(2 * 4 * longest)
    levels = tuple(
        Level(size, start, start - size, count, table, spectra, ground.take(4 * size * count), *_scratch(ground, size))
        for (size, start, count), (table, spectra) in zip(used, fixed, strict=True)
    )
    header = [len(levels), in_ring, 2 * longest, tail, 4 * longest, history, head, sums, state_start, ground.top]
    integers = _integers(header, levels)
    return Plan(n_taps, head, levels, ground.top, tuple(integers))


def _scratch(ground, size):
    return ground.take(4 * size), ground.take(4 * size)


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
    forward, nodes, table, stride = [], 1, level.table, size // RADIX
    for _ in fft_radices(size):
        forward.append((stride, table))
        table += 8 * nodes
        nodes, stride = 8 * nodes, stride // 8
    passes = []
    for channel in (0, 1):
        for number, (stride, place) in enumerate(forward):
            passes.append((OP_MIDDLE if number else OP_FIRST, channel, units, _PASS_COST, stride, place))
        passes.append((OP_TILES, channel, units, _PASS_COST, 32 * level.partitions, table))
    cost = _TILE_COST[0] + _TILE_COST[1] * level.partitions
    passes.append((OP_PRODUCT, 0, size // 8, cost, 0, 0))
    for channel in (0, 1):
        passes.append((OP_UNTILE, channel, units, _PASS_COST, 32, table))
        for number, (stride, place) in reversed(list(enumerate(forward))):
            passes.append((OP_BACK if number else OP_ADD, channel, units, _PASS_COST, stride, place))
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
