"""A few words for writing SIMD kernels: vectors of eight doubles, spelled in LLVM and usable from Numba kernels.

Enters a Python function that emits vector operations, leaves a Numba intrinsic. Numba's own vectoriser may or may not
take a loop; what is written with these words always is one, on every target LLVM knows (eight doubles are one AVX-512
register, two AVX2 ones, four of NEON or WebAssembly). Addresses are 64-byte aligned by the layout.
"""

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

DOUBLE = ir.DoubleType()
INT = ir.IntType(64)
VECTOR = ir.VectorType(DOUBLE, 8)
HALF = ir.VectorType(DOUBLE, 4)
ZERO, ONE = (ir.Constant(VECTOR, [value] * 8) for value in (0.0, 1.0))


class Vectors:
    """Emits vector code where ``builder`` stands; ``base`` is the array that all offsets count from."""

    def __init__(self, builder, base):
        self.builder = builder
        self.base = base

    def index(self, value):
        """The integer constant ``value``."""
        return ir.Constant(INT, value)

    def at(self, offset, more=0):
        """``offset`` (LLVM value or int) plus the constant ``more``."""
        if isinstance(offset, int):
            return self.index(offset + more)
        return self.builder.add(offset, self.index(more)) if more else offset

    def _pointer(self, offset, kind):
        address = self.builder.gep(self.base, [offset if not isinstance(offset, int) else self.index(offset)])
        return self.builder.bitcast(address, kind.as_pointer())

    def align_stack(self):
        """Let vectors for which there is no register lie on 64-byte boundaries of the stack.

        Left to itself LLVM puts them where the stack happens to be, mostly across two cache lines. This is a slot that
        asks for more, whose address it must believe to be used.
        """
        slot = cgutils.alloca_once(self.builder, VECTOR)
        slot.align = 64
        self.builder.asm(ir.FunctionType(ir.VoidType(), [slot.type]), "", "r", [slot], side_effect=True)

    def load(self, offset):
        """Eight doubles from ``offset``."""
        return self.builder.load(self._pointer(offset, VECTOR), align=64)

    def load_twice(self, offset):
        """Four doubles from ``offset``, in both halves: what Y and Z share."""
        half = self.builder.load(self._pointer(offset, HALF), align=32)
        return self.shuffle(half, half, [0, 1, 2, 3, 0, 1, 2, 3])

    def scalar(self, offset):
        """One double from ``offset``."""
        return self.builder.load(self._pointer(offset, DOUBLE))

    def spread(self, value):
        """The scalar ``value`` in all eight places."""
        vector = self.builder.insert_element(ir.Constant(VECTOR, ir.Undefined), value, ir.Constant(ir.IntType(32), 0))
        return self.shuffle(vector, vector, [0] * 8)

    def pair(self, first, second):
        """Scalar ``first`` in the lower half, ``second`` in the upper."""
        return self.shuffle(self.spread(first), self.spread(second), [0, 0, 0, 0, 8, 8, 8, 8])

    def store(self, vector, offset):
        """Put eight doubles at ``offset``."""
        self.builder.store(vector, self._pointer(offset, VECTOR), align=64)

    def store_scalar(self, value, offset):
        """Put one double at ``offset``."""
        self.builder.store(value, self._pointer(offset, DOUBLE))

    def shuffle(self, first, second, order):
        """Elements of two vectors, numbered through, in ``order``."""
        mask = ir.Constant(ir.VectorType(ir.IntType(32), len(order)), order)
        return self.builder.shuffle_vector(first, second, mask)

    def fma(self, x, y, z):
        """x y + z, rounded once."""
        kind = ir.FunctionType(VECTOR, [VECTOR] * 3)
        return self.builder.call(cgutils.get_or_insert_function(self.builder.module, kind, "llvm.fma.v8f64"), [x, y, z])

    def mul(self, x, y):
        """x y."""
        return self.builder.fmul(x, y)

    def add(self, x, y):
        """x + y."""
        return self.builder.fadd(x, y)

    def sub(self, x, y):
        """x - y."""
        return self.builder.fsub(x, y)

    def neg(self, x):
        """-x."""
        return self.builder.fneg(x)

    def reciprocal(self, x):
        """1 / x."""
        return self.builder.fdiv(ONE, x)

    def fold(self, rows):
        """Add up the halves of an even number of vectors, at most eight.

        Returns two vectors: element s holds the sum of elements 0-3 of row s, and of elements 4-7; the rest are 0.
        """
        rows = rows + [ZERO] * (-len(rows) % 4)
        even, odd = [0, 8, 2, 10, 4, 12, 6, 14], [1, 9, 3, 11, 5, 13, 7, 15]
        low, high = [0, 1, 8, 9, 4, 5, 12, 13], [2, 3, 10, 11, 6, 7, 14, 15]
        pairs = zip(rows[::2], rows[1::2], strict=True)
        twos = [ZERO if a is ZERO else self.add(self.shuffle(a, b, even), self.shuffle(a, b, odd)) for a, b in pairs]
        pairs = zip(twos[::2], twos[1::2], strict=True)
        fours = [self.add(self.shuffle(a, b, low), self.shuffle(a, b, high)) for a, b in pairs] + [ZERO]
        lower = self.shuffle(fours[0], fours[1], [0, 1, 2, 3, 8, 9, 10, 11])
        upper = self.shuffle(fours[0], fours[1], [4, 5, 6, 7, 12, 13, 14, 15])
        return lower, upper

    def total(self, vector):
        """The sum of the eight elements (a scalar)."""
        for order in ([4, 5, 6, 7, 0, 1, 2, 3], [2, 3, 0, 1, 4, 5, 6, 7], [1, 0, 2, 3, 4, 5, 6, 7]):
            vector = self.add(vector, self.shuffle(vector, vector, order))
        return self.builder.extract_element(vector, ir.Constant(ir.IntType(32), 0))


class Loop:
    """A counted loop from ``first`` to below ``last`` (at least one pass), carrying vectors from pass to pass."""

    def __init__(self, vectors, first, last, carried):
        self._vectors, self._last = vectors, last
        builder = vectors.builder
        before = builder.block
        self._body = builder.function.append_basic_block("pass")
        self._after = builder.function.append_basic_block("after")
        builder.branch(self._body)
        builder.position_at_end(self._body)
        self.index = builder.phi(INT)
        self.index.add_incoming(first, before)
        self.carried = []
        for value in carried:
            phi = builder.phi(VECTOR)
            phi.add_incoming(value, before)
            self.carried.append(phi)

    def close(self, carried):
        """End the body with the new values of what is carried; they also hold after the loop and are returned."""
        builder = self._vectors.builder
        following = builder.add(self.index, ir.Constant(INT, 1))
        self.index.add_incoming(following, self._body)
        for phi, value in zip(self.carried, carried, strict=True):
            phi.add_incoming(value, self._body)
        builder.cbranch(builder.icmp_signed("<", following, self._last), self._body, self._after)
        builder.position_at_end(self._after)
        return carried


def vector_kernel(n_integers):
    """Make an intrinsic ``f(d, n1, n2, ...)`` of a function ``emit(vectors, n1, n2, ...)`` that writes its code.

    The function stays within reach as the intrinsic's ``emit``, for those who want the code by itself.
    """

    def decorate(emit):
        def typing(_context, array, *integers):
            signature = types.void(array, *[types.int64] * n_integers)

            def codegen(context, builder, sig, args):
                base = context.make_array(sig.args[0])(context, builder, args[0]).data
                emit(Vectors(builder, base), *args[1:])
                return context.get_dummy_value()

            return signature, codegen

        made = intrinsic(_with_arity(typing, n_integers))
        made.emit = emit
        return made

    return decorate


def _with_arity(typing, n_integers):
    """Numba wants a typing function whose parameters are named; there are three arities here."""
    if n_integers == 0:
        return lambda context, array: typing(context, array)
    if n_integers == 1:
        return lambda context, array, n1: typing(context, array, n1)
    if n_integers == 3:
        return lambda context, array, n1, n2, n3: typing(context, array, n1, n2, n3)
    raise ValueError(f"no arity for {n_integers} integers")
