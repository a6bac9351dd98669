"""The butterflies of the right-angle FFT as vector code: points and twiddles in, points divided or joined out.

Each is a Numba intrinsic ``f(d, x, y, x_imag, y_imag, stride, table)``: offsets of the points read and written in
``d``, the distances of their imaginary parts, the distance between two points, and the offset of the twiddles; all in
doubles, all vectors of eight on 64-byte boundaries. The equations are in `fft`.
"""

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from ukrt.engine.kernels.simd import VECTOR, Vectors

_TWO = ir.Constant(VECTOR, [2.0] * 8)


def _divide(v, a, b, w, quarter):
    """(a + w b, a - w b), w turned by i if ``quarter``; points are (real, imaginary), None for b's where it is 0."""
    real, imag = (v.neg(w[1]), w[0]) if quarter else w
    if b[1] is None:
        plus = v.fma(real, b[0], a[0]), v.mul(imag, b[0])
        return plus, (v.fma(_TWO, a[0], v.neg(plus[0])), v.neg(plus[1]))
    plus_real = v.fma(v.neg(imag), b[1], v.fma(real, b[0], a[0]))
    plus_imag = v.fma(real, b[1], v.fma(imag, b[0], a[1]))
    return (plus_real, plus_imag), (v.fma(_TWO, a[0], v.neg(plus_real)), v.fma(_TWO, a[1], v.neg(plus_imag)))


def _join(v, p, m, w, quarter):
    """Undo `_divide`, twice too large: (p + m, conj(w) (p - m))."""
    real, imag = (v.neg(w[1]), w[0]) if quarter else w
    d = v.sub(p[0], m[0]), v.sub(p[1], m[1])
    b = v.fma(imag, d[1], v.mul(real, d[0])), v.fma(v.neg(imag), d[0], v.mul(real, d[1]))
    return (v.add(p[0], m[0]), v.add(p[1], m[1])), b


def _layers(radix):
    """Layers of a butterfly: lists of (place of a, place of b, twiddle, turned by i)."""
    layers, half, depth = [], radix // 2, 0
    while half:
        layer = []
        for node in range(radix // (2 * half)):
            twiddle = 3 if node >= 2 else depth  # the lower two of the third layer have a twiddle of their own
            layer += [(2 * half * node + q, 2 * half * node + q + half, twiddle, node % 2 == 1) for q in range(half)]
        layers.append(layer)
        half, depth = half // 2, depth + 1
    return layers


def _forward(v, points, twiddles):
    for layer in _layers(len(points)):
        for a, b, w, quarter in layer:
            points[a], points[b] = _divide(v, points[a], points[b], twiddles[w], quarter)


def _inverse(v, points, twiddles):
    for layer in reversed(_layers(len(points))):
        for a, b, w, quarter in layer:
            points[a], points[b] = _join(v, points[a], points[b], twiddles[w], quarter)


def _transpose(v, rows):
    """Eight vectors of eight, rows and columns exchanged."""
    for width in (1, 2, 4):
        low = [j + 8 - width if j & width else j for j in range(8)]
        high = [j + 8 if j & width else j + width for j in range(8)]
        rows = list(rows)
        for r in range(8):
            if not r & width:
                a, b = rows[r], rows[r + width]
                rows[r], rows[r + width] = v.shuffle(a, b, low), v.shuffle(a, b, high)
    return rows


class _Places:
    """A butterfly's points in memory: ``count`` vectors from ``at``, ``stride`` apart, imaginary ``to_imag`` on."""

    def __init__(self, v, count, at, stride, to_imag):
        self.v = v
        self.real, self.imag = [], []
        for _ in range(count):
            self.real.append(at)
            self.imag.append(v.builder.add(at, to_imag))
            at = v.builder.add(at, stride)

    def load(self):
        return [(self.v.load(a), self.v.load(b)) for a, b in zip(self.real, self.imag, strict=True)]

    def load_real(self):
        return [(self.v.load(a), None) for a in self.real]

    def store(self, points):
        for (x, y), a, b in zip(points, self.real, self.imag, strict=True):
            self.v.store(x, a)
            self.v.store(y, b)

    def accumulate(self, points):
        self.store([(self.v.add(p[0], q[0]), self.v.add(p[1], q[1])) for p, q in zip(points, self.load(), strict=True)])


def _spread_twiddles(v, table, radix):
    needed = {2: 1, 4: 2, 8: 4}[radix]
    return [(v.spread(v.scalar(v.at(table, 2 * j))), v.spread(v.scalar(v.at(table, 2 * j + 1)))) for j in range(needed)]


def _lane_twiddles(v, table):
    return [(v.load(v.at(table, 16 * j)), v.load(v.at(table, 16 * j + 8))) for j in range(4)]


def _transposed(v, points):
    return list(zip(_transpose(v, [p[0] for p in points]), _transpose(v, [p[1] for p in points]), strict=True))


def _first(radix):
    def emit(v, x, y, x_stride, y_imag, stride, table):
        """Real points at x, with a distance of their own, to complex points at y."""
        points = _Places(v, radix, x, x_stride, v.index(0)).load_real()
        _forward(v, points, _spread_twiddles(v, table, radix))
        _Places(v, radix, y, stride, y_imag).store(points)

    return emit


def _last(radix):
    def emit(v, x, y, x_imag, y_imag, stride, table):
        """Complex points at x, joined and added to what is at y."""
        points = _Places(v, radix, x, stride, x_imag).load()
        _inverse(v, points, _spread_twiddles(v, table, radix))
        _Places(v, radix, y, stride, y_imag).accumulate(points)

    return emit


def _middle(step):
    def emit(v, x, y, x_imag, y_imag, stride, table):
        """Eight complex points at x to y."""
        points = _Places(v, 8, x, stride, x_imag).load()
        step(v, points, _spread_twiddles(v, table, 8))
        _Places(v, 8, y, stride, y_imag).store(points)

    return emit


def _from_real(v, x):
    return _Places(v, 8, x, v.index(8), v.index(0)).load_real()


def _from_complex(v, x, x_imag):
    return _Places(v, 8, x, v.index(8), x_imag).load()


def _points_to_tiles(v, points, y, y_imag, stride, table):
    _forward(v, points, _spread_twiddles(v, table, 8))
    points = _transposed(v, points)
    _forward(v, points, _lane_twiddles(v, v.at(table, 8)))
    _Places(v, 8, y, stride, y_imag).store(points)


def _tiles_to_points(v, x, x_imag, stride, table):
    points = _Places(v, 8, x, stride, x_imag).load()
    _inverse(v, points, _lane_twiddles(v, v.at(table, 8)))
    points = _transposed(v, points)
    _inverse(v, points, _spread_twiddles(v, table, 8))
    return points


def _to_tiles(v, x, y, x_imag, y_imag, stride, table):
    """64 points in a row at x through the last two passes to eight tiles (real, imaginary) at y, ``stride`` apart."""
    _points_to_tiles(v, _from_complex(v, x, x_imag), y, y_imag, stride, table)


def _real_to_tiles(v, x, y, _x_imag, y_imag, stride, table):
    """The same of 64 real points, which is a whole transform."""
    _points_to_tiles(v, _from_real(v, x), y, y_imag, stride, table)


def _from_tiles(v, x, y, x_imag, y_imag, stride, table):
    """Undo `_to_tiles`: tiles at x, ``stride`` apart, to points at y."""
    _Places(v, 8, y, v.index(8), y_imag).store(_tiles_to_points(v, x, x_imag, stride, table))


def _add_tiles(v, x, y, x_imag, y_imag, stride, table):
    """Undo `_real_to_tiles`: tiles at x, joined, are added to what is at y."""
    _Places(v, 8, y, v.index(8), y_imag).accumulate(_tiles_to_points(v, x, x_imag, stride, table))


def _butterfly(emit):
    def typing(_context, d, x, y, x_imag, y_imag, stride, table):
        def codegen(context, builder, sig, args):
            emit(Vectors(builder, context.make_array(sig.args[0])(context, builder, args[0]).data), *args[1:])
            return context.get_dummy_value()

        return types.void(d, *[types.int64] * 6), codegen

    return intrinsic(typing)


first2, first4, first8 = (_butterfly(_first(radix)) for radix in (2, 4, 8))
last2, last4, last8 = (_butterfly(_last(radix)) for radix in (2, 4, 8))
forward8, inverse8 = _butterfly(_middle(_forward)), _butterfly(_middle(_inverse))
to_tiles, from_tiles = _butterfly(_to_tiles), _butterfly(_from_tiles)
real_to_tiles, add_tiles = _butterfly(_real_to_tiles), _butterfly(_add_tiles)
