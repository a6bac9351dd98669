"""The audio thread's path allocates nothing: every malloc of the process is counted while the callback runs.

glibc's own tracer does the counting (libc_malloc_debug, preloaded): the same compiled loop runs no block, then
thousands with dense playing, a change of guitar and shedding; the two traces must be equally long.
"""

import os
import pathlib
import platform
import subprocess
import sys

import pytest

_TRACERS = [path for folder in ("/lib", "/usr/lib") for path in pathlib.Path(folder).glob("*/libc_malloc_debug.so.0")]

_SCRIPT = '''
import ctypes, sys
import numpy as np
from numba import types
from llvmlite import ir
import numba
from numba.extending import intrinsic
from ukrt.engine import stage_layout as at
from ukrt.engine.engine import Engine
from ukrt.engine.instance import Instance
from ukrt.model.presets import load_preset

@intrinsic
def call(_context, function, out, n, host):
    def codegen(_context, builder, _signature, args):
        word, byte = ir.IntType(64), ir.IntType(8).as_pointer()
        kind = ir.FunctionType(ir.IntType(32), [byte, byte, word, byte, word, byte])
        none = ir.Constant(byte, None)
        target = builder.inttoptr(args[0], kind.as_pointer())
        place, table = builder.inttoptr(args[1], byte), builder.inttoptr(args[3], byte)
        builder.call(target, [none, place, args[2], none, ir.Constant(word, 0), table])
        return ir.Constant(ir.IntType(64), 0)
    return types.int64(types.int64, types.int64, types.int64, types.int64), codegen

@intrinsic
def plain(_context, function):
    def codegen(_context, builder, _signature, args):
        kind = ir.FunctionType(ir.VoidType(), [])
        builder.call(builder.inttoptr(args[0], kind.as_pointer()), [])
        return ir.Constant(ir.IntType(64), 0)
    return types.int64(types.int64), codegen

@numba.njit
def run(trace, untrace, function, out, n, host, blocks):
    plain(trace)
    for _ in range(blocks):
        call(function, out, n, host)
    plain(untrace)

find = ctypes.CDLL(None).dlvsym  # the tracer's functions are compatibility symbols, found by version only
find.restype, find.argtypes = ctypes.c_void_p, [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_char_p]
tracer = ctypes.CDLL("libc_malloc_debug.so.0")._handle
trace, untrace = (find(tracer, name, b"GLIBC_2.2.5") for name in (b"mtrace", b"muntrace"))
engine = Engine(load_preset("classical"), shared=True)
out = np.zeros((64, 2), np.float32)
random = np.random.default_rng(1)
for k in range(6000):
    frame, note = 40 * k, 40 + int(random.integers(0, 40))
    engine.send(frame, 0x90 if k % 3 else 0x80, note, int(random.integers(1, 128)))
    if k % 20 == 0:
        engine.send(frame, 0xE0, 0, int(random.integers(0, 128)))
    if k % 50 == 0:
        for piece in ((0xF0, 127, 127), (0xF4, 4, 1), (0xF4, 0, k // 50), (0xF7, 0, 0), (0xB0, 66, k % 100),
                      (0xF0, 127, 0), (0xF4, 8, 2), (0xF4, 0, 1), (0xF4, 60, 61), (0xF4, k // 50, 3), (0xF7, 0, 0)):
            engine.send(frame, *piece)
    if k % 500 == 0:
        engine.send_event(frame, at.KIND_SHED, k // 500 % 4)
engine.load(Instance(load_preset("drop-d"), 48000.0, shared=True))
arguments = (trace, untrace, engine.callback_address, out.ctypes.data, 64, engine.userdata_address)
if sys.argv[2] == "proof":  # that the tracer sees what is there to be seen
    ctypes.PYFUNCTYPE(None)(trace)()
    kept = [bytes(5000) for _ in range(100)]
    ctypes.PYFUNCTYPE(None)(untrace)()
    sys.exit()  # the next trace would begin the file anew
run(*arguments, 0)
engine.swap(1000)
run(*arguments, int(sys.argv[1]))
counts = engine.counters()
print(counts["blocks"], counts["notes_on"], counts["swaps"], counts["shed_events"])
engine.close()
'''


def _mallocs(folder, blocks, proof="no"):
    trace, script = folder / f"trace-{blocks}-{proof}", folder / "count.py"
    script.write_text(_SCRIPT)
    environment = {**os.environ, "LD_PRELOAD": str(_TRACERS[0]), "MALLOC_TRACE": str(trace)}
    command = [sys.executable, str(script), str(blocks), proof]
    got = subprocess.run(command, env=environment, capture_output=True, text=True)
    assert got.returncode == 0, got.stderr
    return got.stdout.split(), sum(line.startswith("@") and " + " in line for line in trace.open())


@pytest.mark.skipif(not _TRACERS or platform.machine() != "x86_64", reason="needs glibc's tracer on x86-64")
def test_the_callback_allocates_nothing(tmp_path):
    _, without = _mallocs(tmp_path, 0)
    (blocks, notes, swaps, sheds), with_blocks = _mallocs(tmp_path, 3000)
    assert int(blocks) == 3000 and int(notes) > 1000 and int(swaps) == 1 and int(sheds) > 5
    assert with_blocks == without
    _, proof = _mallocs(tmp_path, 0, "proof")
    assert proof >= 100
