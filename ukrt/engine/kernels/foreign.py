"""C functions whose addresses arrive as numbers, called from compiled code; and memory at an address, as arrays.

Enters an address (int64), leaves a call through it: nothing of it stands in the machine code, so that the code can be
kept from one run to the next, although libraries lie elsewhere each time.
"""

import numpy as np
from llvmlite import ir
from numba import carray, types
from numba.core import cgutils
from numba.extending import intrinsic

from ukrt.engine.kernels.jit import kernel

_LONG_BITS = 8 * np.dtype("L").itemsize
_POINTER = ir.IntType(8).as_pointer()
_C_TYPES = {
    "pointer": _POINTER,
    "int": ir.IntType(32),
    "long": ir.IntType(_LONG_BITS),
    "int64": ir.IntType(64),
    "void": ir.VoidType(),
}


def _to_c(builder, value, kind):
    """An int64 as an argument of C type ``kind``."""
    if kind == "pointer":
        return builder.inttoptr(value, _POINTER)
    target = _C_TYPES[kind]
    return value if target == value.type else builder.trunc(value, target)


def c_function(result, *kinds):
    """A caller of C functions of one signature.

    Parameters
    ----------
    result : {"pointer", "int", "void"}
    *kinds : {"pointer", "int", "long", "int64"}
        Of the arguments; "int" is 32 bits wide, "long" is C's unsigned long.

    Returns
    -------
    intrinsic (address, arguments)
        An int64 and a tuple of them. It gives an int64: an address, an int without its sign, 0 for "void".
    """

    @intrinsic
    def call(_context, address, arguments):
        def codegen(_context, builder, _signature, args):
            values = cgutils.unpack_tuple(builder, args[1], len(kinds))
            kind = ir.FunctionType(_C_TYPES[result], [_C_TYPES[k] for k in kinds])
            function = builder.inttoptr(args[0], kind.as_pointer())
            given = builder.call(function, [_to_c(builder, a, k) for a, k in zip(values, kinds, strict=True)])
            if result == "void":
                return ir.Constant(ir.IntType(64), 0)
            if result == "pointer":
                return builder.ptrtoint(given, ir.IntType(64))
            return builder.zext(given, ir.IntType(64))

        return types.int64(types.int64, types.UniTuple(types.int64, len(kinds))), codegen

    return call


def _pointer_to(element, llvm):
    @intrinsic
    def pointer(_context, address):
        def codegen(_context, builder, _signature, args):
            return builder.inttoptr(args[0], llvm.as_pointer())

        return types.CPointer(element)(types.int64), codegen

    return pointer


_to_bytes = _pointer_to(types.uint8, ir.IntType(8))
_to_words = _pointer_to(types.uint32, ir.IntType(32))


@kernel
def bytes_at(address, length):
    """The ``length`` bytes at ``address`` as an array that owns nothing."""
    return carray(_to_bytes(address), length)


@kernel
def words_at(address, length):
    """The ``length`` unsigned 32-bit integers at ``address`` as an array that owns nothing."""
    return carray(_to_words(address), length)
