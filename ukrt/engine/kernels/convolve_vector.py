"""The two inner loops of the convolver as vector code: the direct head and the products of spectra.

Enter offsets into the convolver's array, leave sums in it. Every sum has one order of its own, whatever the block.
"""

from numba import types
from numba.extending import intrinsic

from ukrt.engine.kernels.convolve_layout import BLOCK, HISTORY_LENGTH
from ukrt.engine.kernels.simd import VECTOR, ZERO, Loop, Vectors


def _vectors(context, builder, signature, args):
    return Vectors(builder, context.make_array(signature.args[0])(context, builder, args[0]).data)


def _load_anywhere(v, offset):
    """Eight doubles from an offset on any 8-byte boundary."""
    pointer = v.builder.bitcast(v.builder.gep(v.base, [offset]), VECTOR.as_pointer())
    return v.builder.load(pointer, align=8)


def _head(v, window, responses, sums):
    left, right = [ZERO] * 4, [ZERO] * 4
    for tap in range(0, BLOCK, 8):
        for end in (0, 1):
            h_left, h_right = (v.load(v.at(responses, (2 * end + side) * BLOCK + tap)) for side in (0, 1))
            for j in range(4):
                x = _load_anywhere(v, v.at(window, end * HISTORY_LENGTH + tap + j))
                left[j], right[j] = v.fma(h_left, x, left[j]), v.fma(h_right, x, right[j])
    v.store(v.add(*v.fold(left + right)), sums)


def _product(v, inputs, spectra, result, count):
    places = [v.at(result, 8 * j) for j in range(4)]  # left real, imaginary, right real, imaginary
    loop = Loop(v, v.index(0), count, [v.load(place) for place in places] + [ZERO] * 4)
    totals = list(loop.carried)
    x = v.builder.add(inputs, v.builder.mul(loop.index, v.index(32)))
    h = v.builder.add(spectra, v.builder.mul(loop.index, v.index(64)))
    for end in (0, 1):
        real, imag = v.load(v.at(x, 16 * end)), v.load(v.at(x, 16 * end + 8))
        minus = v.neg(imag)
        for side in (0, 1):
            a, b = (v.load(v.at(h, 32 * end + 16 * side + part)) for part in (0, 8))
            j = 4 * end + 2 * side
            totals[j] = v.fma(minus, b, v.fma(real, a, totals[j]))
            totals[j + 1] = v.fma(imag, a, v.fma(real, b, totals[j + 1]))
    totals = loop.close(totals)
    for place, bass, treble in zip(places, totals[:4], totals[4:], strict=True):
        v.store(v.add(bass, treble), place)


@intrinsic
def head_of_four(_context, v, window, responses, sums):
    """Four samples of both outputs (4 left, 4 right to ``sums``) from the 64 inputs that end with each of them.

    ``window``: oldest bass input of the first sample (treble: HISTORY_LENGTH further on); ``responses``: bass to left,
    bass to right, treble to left, treble to right, reversed in time.
    """

    def codegen(context, builder, signature, args):
        _head(_vectors(context, builder, signature, args), *args[1:])
        return context.get_dummy_value()

    return types.void(v, *[types.int64] * 3), codegen


@intrinsic
def add_products(_context, v, inputs, spectra, result, count):
    """Add to a tile of both outputs the products of ``count`` (at least 1) tiles of inputs and responses in a row."""

    def codegen(context, builder, signature, args):
        _product(_vectors(context, builder, signature, args), *args[1:])
        return context.get_dummy_value()

    return types.void(v, *[types.int64] * 4), codegen
