"""The two inner loops of the convolver as vector code: the direct head and the products of spectra.

Enter offsets into the convolver's array, leave sums in it. Every sum has one order of its own, whatever the block.
"""

from numba import types
from numba.extending import intrinsic

from ukrt.engine.kernels.convolve_layout import BLOCK, GROUP
from ukrt.engine.kernels.simd import VECTOR, ZERO, Loop, Vectors


def _vectors(context, builder, signature, args, which=0):
    return Vectors(builder, context.make_array(signature.args[which])(context, builder, args[which]).data)


def _anywhere(v, offset):
    """A pointer to eight doubles on any 8-byte boundary."""
    return v.builder.bitcast(v.builder.gep(v.base, [offset]), VECTOR.as_pointer())


def _head(v, window, to_treble, responses, tail, to_right, sums):
    """Tap 8 g + j meets frame 8 o + lane in the vector that begins j + 8 (g - o) earlier: loaded once for all g - o."""
    loop = Loop(v, v.index(0), v.index(8), [ZERO] * 8)
    totals = list(loop.carried)
    start = v.builder.sub(window, loop.index)
    for end in (0, 1):
        begin = v.builder.add(start, to_treble) if end else start
        x = {back: v.builder.load(_anywhere(v, v.at(begin, -8 * back)), align=8) for back in range(-1, 8)}
        for g in range(BLOCK // 8):
            for side in (0, 1):
                place = v.builder.add(responses, v.at(loop.index, (2 * end + side) * BLOCK + 8 * g))
                h = v.spread(v.scalar(place))
                for o in (0, 1):
                    j = 4 * end + 2 * side + o
                    totals[j] = v.fma(h, x[g - o], totals[j])
    totals = loop.close(totals)
    for j in range(4):
        later = v.load(v.at(v.builder.add(tail, to_right) if j > 1 else tail, 8 * (j % 2)))
        total = v.add(v.add(totals[j], totals[4 + j]), later)
        v.store(total, v.at(sums, BLOCK * (j // 2) + 8 * (j % 2)))


def _load_tile(v, x):
    """An input's tile: real and imaginary parts, bass then treble."""
    return [v.load(v.at(x, 8 * j)) for j in range(4)]


def _add_product(v, x, h, sums):
    """Sums (left real, imaginary, right real, imaginary) of a tile plus inputs times the partition's responses."""
    sums = list(sums)
    for end in (0, 1):
        real, imag = x[2 * end], x[2 * end + 1]
        for side in (0, 1):
            a, b = h[4 * end + 2 * side : 4 * end + 2 * side + 2]
            j = 2 * side
            sums[j] = v.fma(v.neg(imag), b, v.fma(real, a, sums[j]))
            sums[j + 1] = v.fma(imag, a, v.fma(real, b, sums[j + 1]))
    return sums


def _load_responses(v, h):
    return [v.load(v.at(h, 8 * j)) for j in range(8)]


def _store_tile(v, values, at):
    for j, value in enumerate(values):
        v.store(value, v.at(at, 8 * j))


def _products(v, inputs, spectra, sums, later, partitions, newest):
    b = v.builder
    x = _load_tile(v, b.add(inputs, b.mul(newest, v.index(32))))
    now = _add_product(v, x, _load_responses(v, spectra), [ZERO] * 4)
    loop = Loop(v, v.index(1), partitions, now + [ZERO] * 4 + x)
    now, following, before = loop.carried[:4], loop.carried[4:8], loop.carried[8:]
    place = b.add(newest, loop.index)
    wrapped = b.select(b.icmp_signed("<", place, partitions), place, b.sub(place, partitions))
    x = _load_tile(v, b.add(inputs, b.mul(wrapped, v.index(32))))
    h = _load_responses(v, b.add(spectra, b.mul(loop.index, v.index(64))))
    totals = loop.close(_add_product(v, x, h, now) + _add_product(v, before, h, following) + x)
    _store_tile(v, totals[:4], sums)
    _store_tile(v, totals[4:8], later)


def _newest(v, x, h, later, sums):
    _store_tile(v, _add_product(v, _load_tile(v, x), _load_responses(v, h), _load_tile(v, later)), sums)


@intrinsic
def copy_group(_context, to, to0, source, from0):
    """Copy GROUP doubles; both places on any 8-byte boundary."""

    def codegen(context, builder, signature, args):
        there, here = _vectors(context, builder, signature, args), _vectors(context, builder, signature, args, 2)
        for k in range(0, GROUP, 8):
            value = builder.load(_anywhere(here, here.at(args[3], k)), align=8)
            builder.store(value, _anywhere(there, there.at(args[1], k)), align=8)
        return context.get_dummy_value()

    return types.void(to, types.int64, source, types.int64), codegen


@intrinsic
def clear_group(_context, v, at):
    """Fill GROUP doubles with zeros."""

    def codegen(context, builder, signature, args):
        vectors = _vectors(context, builder, signature, args)
        for k in range(0, GROUP, 8):
            vectors.store(ZERO, vectors.at(args[1], k))
        return context.get_dummy_value()

    return types.void(v, types.int64), codegen


@intrinsic
def head_of_group(_context, v, window, to_treble, responses, tail, to_right, sums):
    """GROUP frames of both outputs from the 64 inputs that end with each of them, plus what stands at ``tail``.

    ``window``: the first frame's bass input (treble: ``to_treble`` further on); ``responses``: bass to left, bass to
    right, treble to left, treble to right; ``tail``: left (right: ``to_right`` further on); to ``sums``, left, then
    right BLOCK further on. Frames do not mix: what lies beyond the last input only spoils its own.
    """

    def codegen(context, builder, signature, args):
        _head(_vectors(context, builder, signature, args), *args[1:])
        return context.get_dummy_value()

    return types.void(v, *[types.int64] * 6), codegen


@intrinsic
def sum_products(_context, v, inputs, spectra, sums, later, partitions, newest):
    """A tile's products of inputs and responses, summed over ``partitions`` (at least 2), for two periods at once.

    To ``sums`` for this period, all of them; to ``later`` for the next one, all but that of its newest input. So each
    response is loaded half as often. Inputs lie in a ring, ``newest`` (its number there) first.
    """

    def codegen(context, builder, signature, args):
        _products(_vectors(context, builder, signature, args), *args[1:])
        return context.get_dummy_value()

    return types.void(v, *[types.int64] * 6), codegen


@intrinsic
def add_newest(_context, v, x, h, later, sums):
    """A tile's ``sums``: what the period before left in ``later``, and the newest input ``x`` times its response."""

    def codegen(context, builder, signature, args):
        _newest(_vectors(context, builder, signature, args), *args[1:])
        return context.get_dummy_value()

    return types.void(v, *[types.int64] * 4), codegen
