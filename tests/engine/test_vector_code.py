"""The sweep over the modes and the convolver's loops, as machine code for several processors: whole vectors, fused.

What the words of ``simd.py`` write is compiled by LLVM for each of them, whatever machine this is.
"""

import re

import llvmlite.binding as llvm
import pytest
from llvmlite import ir

from ukrt.engine import layout as at
from ukrt.engine.kernels import convolve_vector
from ukrt.engine.kernels.simd import DOUBLE, INT, Vectors
from ukrt.engine.kernels.sweep import make_sweep

# processor: triple, register names of its widest vectors, doubles in one, fused multiply-adds of whole vectors
PROCESSORS = {
    "skylake-avx512": ("x86_64-unknown-linux-gnu", r"%zmm\d+", 8, r"vfn?madd\w+pd"),
    "znver4": ("x86_64-unknown-linux-gnu", r"%zmm\d+", 8, r"vfn?madd\w+pd"),
    "haswell": ("x86_64-unknown-linux-gnu", r"%ymm\d+", 4, r"vfn?madd\w+pd"),
    "cortex-a72": ("aarch64-unknown-linux-gnu", r"\bv\d+\.2d", 2, r"\bfml[as]\s+v\d+\.2d"),
}
SCATTERED = r"gather|scatter|vfn?madd\w+sd|\bfmadd\b|\bld1\b.*\["  # or one number at a time


def machine_code(triple, processor, emit, n_integers):
    """Assembly of what ``emit`` writes for an array and ``n_integers`` integers."""
    module = ir.Module()
    module.triple = triple
    kind = ir.FunctionType(ir.VoidType(), [DOUBLE.as_pointer()] + [INT] * n_integers)
    function = ir.Function(module, kind, "emitted")
    builder = ir.IRBuilder(function.append_basic_block())
    emit(Vectors(builder, function.args[0]), *function.args[1:])
    builder.ret_void()
    target = llvm.Target.from_triple(triple).create_target_machine(cpu=processor, opt=3)
    return target.emit_assembly(llvm.parse_assembly(str(module)))


def hot_loop(code):
    """The lines from a label that is jumped back to, up to that jump: the pass over one tile."""
    lines = code.splitlines()
    labels = {}
    for k, line in enumerate(lines):
        if label := re.match(r"(\.LBB\w+):", line):
            labels[label[1]] = k
        for name, start in labels.items():
            if re.search(rf"\b(j\w+|b\.\w+)\s+{re.escape(name)}\b", line):
                return lines[start : k + 1]
    raise AssertionError(f"there is no loop in\n{code}")


@pytest.fixture(scope="module", autouse=True)
def targets():
    try:
        llvm.initialize_all_targets()
        llvm.initialize_all_asmprinters()
    except (AttributeError, RuntimeError):
        pytest.skip("this llvmlite compiles for this machine only")


def assert_whole_vectors(processor, emit, n_integers, multiply_adds):
    """A pass of the loop does ``multiply_adds`` of eight doubles each, and nothing one number at a time."""
    triple, register, width, fused = PROCESSORS[processor]
    try:
        llvm.Target.from_triple(triple)
    except RuntimeError:
        pytest.skip(f"this llvmlite does not compile for {triple}")
    loop = hot_loop(machine_code(triple, processor, emit, n_integers))
    text = "\n".join(loop)
    assert len(re.findall(fused, text)) == multiply_adds * 8 // width
    assert not re.findall(SCATTERED, text), text
    arithmetic = [line for line in loop if re.search(r"mul|add\w*p|fml[as]", line)]
    assert all(re.search(register, line) for line in arithmetic), arithmetic


@pytest.mark.parametrize("n_extra", range(at.COLUMNS))
@pytest.mark.parametrize("processor", PROCESSORS)
def test_a_pass_is_whole_vectors_and_nothing_else(processor, n_extra):
    # mu, a; for each column its force and two sums; two sums of the tension
    assert_whole_vectors(processor, make_sweep(n_extra).emit, 3, 3 * (1 + n_extra) + 4)


@pytest.mark.parametrize("processor", PROCESSORS)
def test_the_convolver_too(processor):
    assert_whole_vectors(processor, convolve_vector._head, 6, 64)  # 8 taps, 2 ends, 2 sides, 16 frames
    assert_whole_vectors(processor, convolve_vector._products, 6, 32)  # 4 complex products for each of two periods
