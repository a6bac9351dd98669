"""What the compiled callback asks of the world: mathematics, memory moves; nothing that allocates or needs Python."""

import pathlib
import pickle
import re

import pytest

from ukrt.engine.kernel_cache import cache_folder
from ukrt.engine.kernels.callback import callback
from ukrt.engine.kernels.play import play
from ukrt.engine.kernels.take_over import take_over

FORBIDDEN = (b"NRT_MemInfo_alloc", b"NRT_Allocate", b"NRT_MemInfo_new", b"\0malloc\0", b"\0calloc\0", b"PyGILState")


@pytest.mark.parametrize("function", [callback, play, take_over], ids=lambda function: function.__name__)
def test_what_the_audio_thread_calls_neither_allocates_nor_calls_python(function):
    name = function.__name__
    assert function.address
    kept = sorted(pathlib.Path(cache_folder()).glob(f"*/{name}.{name}-*.nbc"), key=lambda path: path.stat().st_mtime)
    if not kept:
        pytest.skip("compiled code is not kept here, so its symbols cannot be read")
    (_, kind, (machine_code, _)), *_ = pickle.loads(kept[-1].read_bytes())
    assert kind == "object" and len(machine_code) > 10000
    found = [name for name in FORBIDDEN if name in machine_code]
    assert not found, found
    assert re.search(rb"\0(sin|sincos|cos|exp|pow)\0", machine_code), "symbol names are not where they are looked for"
