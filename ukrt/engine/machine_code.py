"""Machine code on disk: compiled C functions enter and are kept whole; their addresses leave, without the compiler.

Loading Numba, and through it what it has kept, takes a second; LLVM alone loads the same machine code in milliseconds.
What is kept is found by everything that it depends on: sources, compiler, processor and Numba's settings. Before it
counts, another process has to play a note on it, so that what cannot be loaded is not kept.
"""

import contextlib
import ctypes
import hashlib
import json
import os
import pathlib
import pickle
import subprocess
import sys
import tempfile

import llvmlite
import llvmlite.binding as llvm

from ukrt.child_process import python_module
from ukrt.engine.kernel_cache import cache_folder

_DIGEST = 32  # bytes before the rest of the file
_PATIENCE = 60.0  # s for the other process to play its note
# What kernels would call if they raised an error, or counted references. They do neither.
_UNREACHED = (
    "NRT_Free NRT_MemInfo_call_dtor numba_do_raise numba_gil_ensure numba_gil_release "
    "numba_runtime_build_excinfo_struct numba_unpickle"
).split()


def kept_file():
    """Where machine code for this processor is kept (Path), whether it is there or not."""
    features = llvm.get_host_cpu_features().flatten()
    settings = sorted(item for item in os.environ.items() if item[0].startswith("NUMBA_"))
    key = repr((llvmlite.__version__, llvm.get_process_triple(), llvm.get_host_cpu_name(), features, settings))
    return pathlib.Path(cache_folder()) / f"machine-code-{hashlib.sha256(key.encode()).hexdigest()[:16]}"


def read(path):
    """Names and addresses of the C functions in a file (dict of str to int); None where there is none, or not whole."""
    try:
        data = path.read_bytes()
    except OSError:
        return None
    if hashlib.sha256(data[_DIGEST:]).digest() != data[:_DIGEST]:
        return None
    head, _, code = data[_DIGEST:].partition(b"\n")
    engine, symbols, start = _make_engine(), {}, 0
    for name, symbol, size in json.loads(head):
        engine.add_object_file(llvm.ObjectFileRef.from_data(code[start : start + size]))
        symbols[name], start = symbol, start + size
    engine.finalize_object()
    found = {name: engine.get_function_address(symbol) for name, symbol in symbols.items()}
    return found if all(found.values()) else None


def write(path, functions):
    """Keep C functions (dict of str to ``numba.cfunc``), if they can be; whoever reads finds a whole file or none."""
    parts = {name: _machine_code(function) for name, function in functions.items()}
    if None in parts.values():
        return
    head = json.dumps([(name, symbol, len(code)) for name, (symbol, code) in parts.items()]).encode()
    rest = head + b"\n" + b"".join(code for _, code in parts.values())
    with contextlib.suppress(OSError), tempfile.NamedTemporaryFile(dir=path.parent, delete=False) as file:
        try:
            file.write(hashlib.sha256(rest).digest() + rest)
            file.close()
            if _plays(file.name):
                os.replace(file.name, path)
        finally:
            pathlib.Path(file.name).unlink(missing_ok=True)


def _machine_code(function):
    """What Numba has kept of a C function, None if nothing: for want of a folder to write to.

    Its symbol (str) and its code (bytes). Another process may have kept it meanwhile, by another symbol than ours.
    """
    cache, codegen = function._cache, function._library.codegen
    try:
        (_, kind, payload), described, *_ = cache._cache_file.load(cache._index_key(function._sig, codegen))
        symbol = described.llvm_cfunc_wrapper_name
    except (AttributeError, OSError, TypeError, ValueError, pickle.UnpicklingError):
        return None
    return (symbol, payload[0]) if kind == "object" else None


_engines = []  # machine code lives as long as the process


def _make_engine():
    with contextlib.suppress(RuntimeError):  # needless with newer versions, which say so by this
        llvm.initialize()
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    end = ctypes.cast(ctypes.CDLL(None if os.name == "posix" else "msvcrt").abort, ctypes.c_void_p).value
    for name in _UNREACHED:
        if not llvm.address_of_symbol(name):
            llvm.add_symbol(name, end)
    target = llvm.Target.from_triple(llvm.get_process_triple()).create_target_machine(jit=True)
    _engines.append(llvm.create_mcjit_compiler(llvm.parse_assembly(""), target))
    return _engines[-1]


def _plays(path):
    """Whether another process can load a file and play a note on it."""
    if not pathlib.Path(sys.executable or "").name.startswith("python"):
        return False  # a program that has Python inside, of which nobody wants another
    try:
        return not subprocess.run(
            **python_module("ukrt.engine.first_note", path),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            timeout=_PATIENCE,
        ).returncode
    except (OSError, subprocess.SubprocessError):
        return False
