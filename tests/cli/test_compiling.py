"""The second process that compiles: it leaves nothing to the first but the callback."""

import subprocess
import sys

_PROGRAM = """
import gc, sys
from ukrt.cli.compiling import compile_beside
compile_beside()
from ukrt.engine import compiled
from ukrt.engine.kernels.linking import Kernel
entries = compiled._ENTRIES.items()
print([name for name, (module, *_) in entries if "ukrt.engine.kernels." + module not in sys.modules])
from ukrt.engine.engine import Engine
from ukrt.model.presets import load_preset
engine = Engine(load_preset("drop-d"), 44100.0)
assert engine.send(0, 0x90, 52, 80)
assert engine.process(64).shape == (64, 2) and engine.energy() >= 0.0
engine.reset()
print([one.__name__ for one in gc.get_objects() if isinstance(one, Kernel) and one.whole.overloads])
"""


def test_an_engine_needs_nothing_that_was_not_compiled_beside():
    got = subprocess.run([sys.executable, "-c", _PROGRAM], capture_output=True, text=True)
    assert got.returncode == 0, got.stderr
    assert got.stdout.splitlines() == ["['callback']", "[]"]
