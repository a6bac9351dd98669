"""What compiled code needs of the machine: addresses as arrays, clocks, order between threads, denormals off.

These are the only places where the processor shows; on one that lacks them they do nothing or give 0.
"""

import platform

from llvmlite import ir
from numba import carray, types
from numba.core import cgutils
from numba.extending import intrinsic

from ukrt.engine.kernels.jit import kernel

_X86 = platform.machine().lower() in ("x86_64", "amd64", "i686", "x86")
_BYTES = ir.IntType(8).as_pointer()
FLUSH = 0x8040  # MXCSR: flush to zero, denormals are zero


@intrinsic
def _double_pointer(_context, address):
    def codegen(_context, builder, _signature, args):
        return builder.inttoptr(args[0], ir.DoubleType().as_pointer())

    return types.CPointer(types.float64)(address), codegen


@intrinsic
def _integer_pointer(_context, address):
    def codegen(_context, builder, _signature, args):
        return builder.inttoptr(args[0], ir.IntType(64).as_pointer())

    return types.CPointer(types.int64)(address), codegen


@intrinsic
def address_of(_context, pointer):
    """The address (int64) that a C pointer holds."""

    def codegen(_context, builder, _signature, args):
        return builder.ptrtoint(args[0], ir.IntType(64))

    return types.int64(pointer), codegen


@kernel
def doubles_at(address, length):
    """The ``length`` doubles at ``address`` as an array that owns nothing."""
    return carray(_double_pointer(address), length)


@kernel
def integers_at(address, length):
    """The ``length`` 64-bit integers at ``address`` as an array that owns nothing."""
    return carray(_integer_pointer(address), length)


@intrinsic
def ticks(_context):
    """A counter that runs steadily (int64); its rate is measured outside. 0 where there is none."""

    def codegen(context, builder, _signature, _args):
        name = "llvm.readcyclecounter" if _X86 else "llvm.readsteadycounter"
        kind = ir.FunctionType(ir.IntType(64), [])
        return builder.call(cgutils.get_or_insert_function(builder.module, kind, name), [])

    return types.int64(), codegen


@intrinsic
def float_mode(_context):
    """The processor's floating-point control word (int64), to be given back to ``set_float_mode``."""

    def codegen(context, builder, _signature, _args):
        if not _X86:
            return ir.Constant(ir.IntType(64), 0)
        slot = cgutils.alloca_once(builder, ir.IntType(32))
        kind = ir.FunctionType(ir.VoidType(), [_BYTES])
        store = cgutils.get_or_insert_function(builder.module, kind, "llvm.x86.sse.stmxcsr")
        builder.call(store, [builder.bitcast(slot, _BYTES)])
        return builder.zext(builder.load(slot), ir.IntType(64))

    return types.int64(), codegen


@intrinsic
def set_float_mode(_context, word):
    """Set the floating-point control word; ``float_mode() | FLUSH`` makes denormals zero."""

    def codegen(context, builder, _signature, args):
        if _X86:
            slot = cgutils.alloca_once(builder, ir.IntType(32))
            builder.store(builder.trunc(args[0], ir.IntType(32)), slot)
            kind = ir.FunctionType(ir.VoidType(), [_BYTES])
            load = cgutils.get_or_insert_function(builder.module, kind, "llvm.x86.sse.ldmxcsr")
            builder.call(load, [builder.bitcast(slot, _BYTES)])
        return context.get_dummy_value()

    return types.void(types.int64), codegen


def _place(context, builder, signature, args):
    """A pointer to the element of an integer array that the first two arguments name."""
    array = context.make_array(signature.args[0])(context, builder, args[0])
    return builder.gep(array.data, [args[1]])


@intrinsic
def load_acquire(_context, array, index):
    """``array[index]``: what another thread wrote before its ``store_release`` there is seen after this."""

    def codegen(context, builder, signature, args):
        return builder.load_atomic(_place(context, builder, signature, args), "acquire", 8)

    return types.int64(array, types.int64), codegen


@intrinsic
def store_release(_context, array, index, value):
    """``array[index] = value``, seen by other threads only after all that was written before."""

    def codegen(context, builder, signature, args):
        builder.store_atomic(args[2], _place(context, builder, signature, args), "release", 8)
        return context.get_dummy_value()

    return types.void(array, types.int64, types.int64), codegen


@intrinsic
def _call_clock(_context, function, clock, buffer):
    """int clock_gettime(clockid_t, struct timespec *) at the address ``function``."""

    def codegen(_context, builder, _signature, args):
        kind = ir.FunctionType(ir.IntType(32), [ir.IntType(32), _BYTES])
        call = builder.inttoptr(args[0], kind.as_pointer())
        where = builder.inttoptr(args[2], _BYTES)
        return builder.sext(builder.call(call, [builder.trunc(args[1], ir.IntType(32)), where]), ir.IntType(64))

    return types.int64(types.int64, types.int64, types.int64), codegen


@intrinsic
def _call_thread_id(_context, function):
    """pid_t gettid(void) at the address ``function``."""

    def codegen(_context, builder, _signature, args):
        kind = ir.FunctionType(ir.IntType(32), [])
        return builder.sext(builder.call(builder.inttoptr(args[0], kind.as_pointer()), []), ir.IntType(64))

    return types.int64(types.int64), codegen


@kernel
def nanoseconds(function, clock, buffer):
    """What the C library's clock shows [ns]; 0 where there is none. ``buffer`` is the address of two words."""
    if function == 0:
        return 0
    time = integers_at(buffer, 2)
    if _call_clock(function, clock, buffer) != 0:
        return 0
    return time[0] * 1_000_000_000 + time[1]


@kernel
def thread_id(function):
    """The operating system's number of this thread; 0 where it cannot be asked for."""
    return _call_thread_id(function) if function != 0 else 0


@intrinsic
def _single_pointer(_context, address):
    def codegen(_context, builder, _signature, args):
        return builder.inttoptr(args[0], ir.FloatType().as_pointer())

    return types.CPointer(types.float32)(address), codegen


@kernel
def singles_at(address, length):
    """The ``length`` floats at ``address`` as an array that owns nothing."""
    return carray(_single_pointer(address), length)


@kernel
def ticks_now():
    """`ticks` for callers in Python."""
    return ticks()
