"""What the compiled callback asks of the world: mathematics, memory moves; nothing that allocates or needs Python."""

import pathlib
import pickle

import pytest

from ukrt.engine.kernel_cache import cache_folder
from ukrt.engine.kernels.callback import callback

FORBIDDEN = (b"NRT_MemInfo_alloc", b"NRT_Allocate", b"NRT_MemInfo_new", b"\0malloc\0", b"\0calloc\0", b"PyGILState")


def test_the_callback_neither_allocates_nor_calls_python():
    assert callback.address
    kept = sorted(pathlib.Path(cache_folder()).glob("*/callback.callback-*.nbc"), key=lambda path: path.stat().st_mtime)
    if not kept:
        pytest.skip("compiled code is not kept here, so its symbols cannot be read")
    (_, kind, (machine_code, _)), *_ = pickle.loads(kept[-1].read_bytes())
    assert kind == "object" and len(machine_code) > 10000
    found = [name for name in FORBIDDEN if name in machine_code]
    assert not found, found
    assert b"\0sin\0" in machine_code or b"\0sincos\0" in machine_code, "symbol names are not where they are looked for"
