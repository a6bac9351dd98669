"""Streaming convolution without delay: force at the two ends of the bridge in, pressure left and right out (Eq. 51).

Four responses. The first 64 taps run as a direct sum per sample; the rest by FFT in partitions of three sizes
(`convolve_layout`), one input transform for both outputs and one inverse for both inputs. Whenever a block of 64
frames, counted from absolute frame 0, is complete, the convolver does that block's share of all levels' work: the same
amount in every block, in an order that depends on frame numbers only, so that the host's block size changes no bit.
Frames must follow one another without gaps between two resets. What is not finite in the input leaves the output again
once it has passed through the response.
"""

from ukrt.engine.kernels.convolve_layout import (
    BLOCK,
    CHANNEL,
    DELAY,
    DROP,
    DROPPED,
    FIRST,
    GROUP,
    HEAD,
    HEADER,
    HEARD,
    IN_LENGTH,
    IN_RING,
    INPUTS,
    LATER,
    LEVELS,
    MISSING,
    OP,
    OP_ADD,
    OP_BACK,
    OP_FIRST,
    OP_MIDDLE,
    OP_PRODUCT,
    OP_TILES,
    OP_UNTILE,
    OP_WHOLE,
    PARTITIONS,
    PRODUCT,
    PROGRAM,
    RADIX,
    RECORD,
    SHED,
    SIZE,
    SIZES,
    SPECTRA,
    STATE_START,
    STATE_STOP,
    STEP,
    STOP,
    STRIDE,
    SUMS,
    TABLE,
    TAIL,
    TAIL_LENGTH,
    WHOLE,
    WORK,
)
from ukrt.engine.kernels.convolve_vector import add_newest, clear_group, copy_group, head_of_group, sum_products
from ukrt.engine.kernels.fft import (
    fft_first_pass,
    fft_forward_64,
    fft_forward_pass,
    fft_from_tiles,
    fft_inverse_64_add,
    fft_inverse_pass,
    fft_last_pass,
    fft_place,
    fft_to_tiles,
)
from ukrt.engine.kernels.jit import inlined, kernel


@kernel
def convolver_reset(v, vi):
    """Bring a convolver to rest."""
    for at in range(vi[STATE_START], vi[STATE_STOP]):
        v[at] = 0.0
    for at in range(SHED, DROP + vi[LEVELS]):
        vi[at] = 0


@kernel
def convolver_shed(vi, levels):
    """From the next block of 64 frames on leave out the longest ``levels`` of the three sizes; 0: none.

    A level always falls silent and comes back by whole periods, products and inverse transforms left out. What a
    period adds to the output swells over its N frames and fades over the next N by itself, since all its products have
    just one term there, then two, ...; so no ramp is needed. Forward transforms go on: what comes back is complete.
    """
    vi[SHED] = levels


@kernel
def _to_drop(vi, level, into):
    """Whether the level's present period is to be left out, as long as nothing of it has been heard."""
    if into == 0:
        vi[DROP + level] = WHOLE + (MISSING if vi[DROP + level] & 3 == DROPPED else 0)
    if vi[DROP + level] & 3 == WHOLE and level >= len(SIZES) - vi[SHED]:
        vi[DROP + level] += DROPPED - WHOLE
    return vi[DROP + level] & 3 == DROPPED


@kernel
def _multiply(v, vi, record, block_end, missing, first, stop):
    """Pairs of tiles ``first`` to ``stop`` of the sum over partitions.

    Of each pair one sums for this period and the next, the other, which did so in the last period, adds the newest
    input's product; which is which changes from period to period. If the last was left out, that is made up for.
    """
    partitions = vi[record + PARTITIONS]
    period = block_end // vi[record + SIZE]
    newest = -period % partitions
    for tile in range(2 * first, 2 * stop):
        x, h = vi[record + INPUTS] + 32 * partitions * tile, vi[record + SPECTRA] + 64 * partitions * tile
        sums, later = vi[record + PRODUCT] + 32 * tile, vi[record + LATER] + 32 * tile
        if partitions > 1 and (period ^ tile) & 1 == 0:
            sum_products(v, x, h, sums, later, partitions, newest)
        else:
            if partitions > 1 and missing:
                sum_products(v, x, h, sums, later, partitions, (newest + 1) % partitions)
            add_newest(v, x + 32 * newest, h, later, sums)


@inlined
def _tail_place(vi, side, frame):
    """Where what has been summed up for ``frame`` stands."""
    length = vi[TAIL_LENGTH]
    return vi[TAIL] + fft_place(length) * side + fft_place(frame & (length - 1))


@kernel
def _run_step(v, vi, record, step, block_end, missing):
    """One step of a level's programme for the input block that ended before frame ``block_end``."""
    size, partitions = vi[record + SIZE], vi[record + PARTITIONS]
    op, channel, stride, table = vi[step + OP], vi[step + CHANNEL], vi[step + STRIDE], vi[step + TABLE]
    first, stop = vi[step + FIRST], vi[step + STOP]
    work = vi[record + WORK] + 2 * fft_place(size) * channel
    tiles = vi[record + INPUTS] + 32 * (-(block_end // size) % partitions) + 16 * channel
    ring, heard = vi[IN_LENGTH], block_end + vi[record + DELAY]
    x = vi[IN_RING] + (BLOCK + ring) * channel + ((block_end - size) & (ring - 1))
    y, second = _tail_place(vi, channel, heard), _tail_place(vi, channel, heard + size)
    if op == OP_WHOLE:
        fft_forward_64(v, x, tiles, stride, table)
    elif op == OP_FIRST:
        fft_first_pass(v, x, work, size, RADIX, table, first, stop)
    elif op == OP_MIDDLE:
        fft_forward_pass(v, work, size, stride, table, first, stop)
    elif op == OP_TILES:
        fft_to_tiles(v, work, tiles, size, stride, table, first, stop)
    elif op == OP_PRODUCT:
        _multiply(v, vi, record, block_end, missing, first, stop)
    elif op == OP_UNTILE:
        fft_from_tiles(v, vi[record + PRODUCT] + 16 * channel, work, size, stride, table, first, stop)
    elif op == OP_BACK:
        fft_inverse_pass(v, work, size, stride, table, first, stop)
    elif op == OP_ADD:
        fft_last_pass(v, work, y, second, size, RADIX, table, first, stop)
    else:
        fft_inverse_64_add(v, vi[record + PRODUCT] + 16 * channel, y, second, stride, table)


@kernel
def _finish_block(v, vi, frame):
    """The share of all levels that falls to the block of 64 frames that ended before ``frame``."""
    for side in (0, 1):
        tail = _tail_place(vi, side, frame - BLOCK)
        for at in range(0, BLOCK, GROUP):
            clear_group(v, tail + at)
    for level in range(vi[LEVELS]):
        record = HEADER + RECORD * level
        size = vi[record + SIZE]
        into = frame & (size - 1)
        place = vi[record + PROGRAM] + into // BLOCK
        dropped = _to_drop(vi, level, into)
        for step in range(vi[place], vi[place + 1], STEP):
            if not (dropped and vi[step + OP] >= OP_PRODUCT):
                _run_step(v, vi, record, step, frame - into, vi[DROP + level] & MISSING != 0)
            if vi[step + OP] >= OP_ADD and not dropped:
                vi[DROP + level] |= HEARD


@kernel
def _move(to, to0, source, from0, n):
    """Copy ``n`` doubles."""
    for k in range(0, n - GROUP + 1, GROUP):
        copy_group(to, to0 + k, source, from0 + k)
    for k in range(n // GROUP * GROUP, n):
        to[to0 + k] = source[from0 + k]


@kernel
def convolve_chunk(v, vi, frame0, n, inp, in0, out, out0):
    """Convolve ``n`` frames from absolute frame ``frame0``, not across a multiple of 64.

    Bass at ``inp[in0 + k]``, treble at ``inp[in0 + 64 + k]`` [N]; left at ``out[out0 + k]``, right 64 further on [Pa].
    """
    start = frame0 & (BLOCK - 1)
    length, to_right = vi[IN_LENGTH], fft_place(vi[TAIL_LENGTH])
    at = frame0 & (length - 1)
    ring, to_treble = vi[IN_RING] + at, BLOCK + length
    for end in (0, 1):
        _move(v, ring + to_treble * end, inp, in0 + BLOCK * end, n)
        if at >= length - BLOCK:  # what stands before the ring is its end
            _move(v, ring + to_treble * end - length, inp, in0 + BLOCK * end, n)
    tail, sums = _tail_place(vi, 0, frame0), vi[SUMS] + start
    for k in range(-(start % GROUP), n, GROUP):
        head_of_group(v, ring + k, to_treble, vi[HEAD], tail + k, to_right, sums + k)
    for side in (0, 1):
        _move(out, out0 + BLOCK * side, v, sums + BLOCK * side, n)
    if start + n == BLOCK:
        _finish_block(v, vi, frame0 + n)
