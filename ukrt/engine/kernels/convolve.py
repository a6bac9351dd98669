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
    HEAD,
    HEADER,
    HEARD,
    HISTORY,
    HISTORY_LENGTH,
    IN_LENGTH,
    IN_RING,
    INPUTS,
    LEVELS,
    OP,
    OP_ADD,
    OP_BACK,
    OP_FIRST,
    OP_MIDDLE,
    OP_PRODUCT,
    OP_TILES,
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
from ukrt.engine.kernels.convolve_vector import add_products, head_of_four
from ukrt.engine.kernels.fft import (
    fft_first_pass,
    fft_forward_pass,
    fft_from_tiles,
    fft_inverse_pass,
    fft_last_pass,
    fft_to_tiles,
)
from ukrt.engine.kernels.jit import kernel


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
        vi[DROP + level] = WHOLE
    if vi[DROP + level] == WHOLE and level >= len(SIZES) - vi[SHED]:
        vi[DROP + level] = DROPPED
    return vi[DROP + level] == DROPPED


@kernel
def _multiply(v, inputs, spectra, product, partitions, newest, first, stop):
    """Tiles ``first`` to ``stop`` of the sum over partitions; inputs lie in a ring, the ``newest`` first."""
    for tile in range(first, stop):
        result = product + 32 * tile
        for at in range(result, result + 32):
            v[at] = 0.0
        x, h = inputs + 32 * partitions * tile, spectra + 64 * partitions * tile
        add_products(v, x + 32 * newest, h, result, partitions - newest)
        if newest > 0:
            add_products(v, x, h + 64 * (partitions - newest), result, newest)


@kernel
def _run_step(v, vi, record, step, block_end):
    """One step of a level's programme for the input block that ended before frame ``block_end``."""
    size, partitions = vi[record + SIZE], vi[record + PARTITIONS]
    op, channel, stride, table = vi[step + OP], vi[step + CHANNEL], vi[step + STRIDE], vi[step + TABLE]
    first, stop = vi[step + FIRST], vi[step + STOP]
    work = vi[record + WORK] + 2 * size * channel
    newest = -(block_end // size) % partitions
    if op == OP_FIRST:
        ring = vi[IN_LENGTH]
        x = vi[IN_RING] + ring * channel + ((block_end - size) & (ring - 1))
        fft_first_pass(v, x, work, size, RADIX, table, first, stop)
    elif op == OP_MIDDLE:
        fft_forward_pass(v, work, size, stride, table, first, stop)
    elif op == OP_TILES:
        fft_to_tiles(v, work, vi[record + INPUTS] + 32 * newest + 16 * channel, size, stride, table, first, stop)
    elif op == OP_PRODUCT:
        inputs, spectra = vi[record + INPUTS], vi[record + SPECTRA]
        _multiply(v, inputs, spectra, vi[record + PRODUCT], partitions, newest, first, stop)
    elif op == OP_BACK:
        fft_inverse_pass(v, work, size, stride, table, first, stop)
    elif op == OP_ADD:
        length = vi[TAIL_LENGTH]
        tail, heard = vi[TAIL] + length * channel, block_end + vi[record + DELAY]
        y, second = tail + (heard & (length - 1)), tail + ((heard + size) & (length - 1))
        fft_last_pass(v, work, y, second, size, RADIX, table, first, stop)
    else:
        fft_from_tiles(v, vi[record + PRODUCT] + 16 * channel, work, size, stride, table, first, stop)


@kernel
def _finish_block(v, vi, frame):
    """The share of all levels that falls to the block of 64 frames that ended before ``frame``."""
    history = vi[HISTORY]
    for at in range(history, history + BLOCK):
        v[at] = v[at + BLOCK]
        v[at + HISTORY_LENGTH] = v[at + HISTORY_LENGTH + BLOCK]
    for level in range(vi[LEVELS]):
        record = HEADER + RECORD * level
        size = vi[record + SIZE]
        into = frame & (size - 1)
        place = vi[record + PROGRAM] + into // BLOCK
        dropped = _to_drop(vi, level, into)
        for step in range(vi[place], vi[place + 1], STEP):
            if not (dropped and vi[step + OP] >= OP_PRODUCT):
                _run_step(v, vi, record, step, frame - into)
            if vi[step + OP] == OP_ADD and not dropped:
                vi[DROP + level] = HEARD


@kernel
def convolve_chunk(v, vi, frame0, n, inp, in0, out, out0):
    """Convolve ``n`` frames from absolute frame ``frame0``, not across a multiple of 64.

    Bass at ``inp[in0 + k]``, treble at ``inp[in0 + 64 + k]`` [N]; left at ``out[out0 + k]``, right 64 further on [Pa].
    """
    start = frame0 & (BLOCK - 1)
    history, ring = vi[HISTORY], vi[IN_RING] + (frame0 & (vi[IN_LENGTH] - 1))
    tail, sums = vi[TAIL] + (frame0 & (vi[TAIL_LENGTH] - 1)), vi[SUMS]
    other_ring, other_tail = vi[IN_LENGTH], vi[TAIL_LENGTH]
    for k in range(n):
        bass, treble = inp[in0 + k], inp[in0 + BLOCK + k]
        v[history + BLOCK + start + k] = bass
        v[history + HISTORY_LENGTH + BLOCK + start + k] = treble
        v[ring + k] = bass
        v[ring + other_ring + k] = treble
    for group in range(0, n, 4):
        head_of_four(v, history + 1 + start + group, vi[HEAD], sums)
        for j in range(min(4, n - group)):
            k = group + j
            out[out0 + k] = v[sums + j] + v[tail + k]
            out[out0 + BLOCK + k] = v[sums + 4 + j] + v[tail + other_tail + k]
            v[tail + k] = 0.0
            v[tail + other_tail + k] = 0.0
    if start + n == BLOCK:
        _finish_block(v, vi, frame0 + n)
