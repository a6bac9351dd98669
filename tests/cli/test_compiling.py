"""The helpers that compile: they leave nothing to the command, and take no share twice."""

import os
import subprocess
import sys

import pytest

from ukrt.cli import compiling

_PROGRAM = """
import gc, sys
from ukrt.cli.compiling import SHARES, compile_share
for share in SHARES:
    compile_share(share)
from ukrt.engine.kernels.linking import Kernel
made = {one.__name__: len(one.whole.overloads) for one in gc.get_objects() if isinstance(one, Kernel)}
before = {name for name in sys.modules if name.startswith("ukrt.engine.kernels.")}
from ukrt.engine.engine import Engine
from ukrt.model.presets import load_preset
engine = Engine(load_preset("drop-d"), 44100.0)
assert engine.send(0, 0x90, 52, 80)
assert engine.process(64).shape == (64, 2) and engine.energy() >= 0.0
engine.reset()
late = [one.__name__ for one in gc.get_objects() if isinstance(one, Kernel) and len(one.whole.overloads) >
        made.get(one.__name__, 0)]
late += [name for name in sys.modules if name.startswith("ukrt.engine.kernels.") and name not in before]
print(late, sum(made.values()))
"""


def test_an_engine_needs_nothing_that_is_in_no_share():
    got = subprocess.run([sys.executable, "-c", _PROGRAM], capture_output=True, text=True)
    assert got.returncode == 0, got.stderr
    late, made = got.stdout.rsplit(maxsplit=1)
    assert late == "[]" and made == "0"  # all that Python calls are C functions


def test_a_share_is_compiled_once_whoever_takes_it(tmp_path, monkeypatch):
    compiled = []
    monkeypatch.setattr(compiling, "compile_share", compiled.append)
    first, *others = compiling.SHARES
    os.mkdir(tmp_path / first)  # by another helper, which is at it
    compiling.work_through(tmp_path)
    compiling.work_through(tmp_path)
    assert compiled == others


@pytest.mark.parametrize("program, told", [("sys.exit(3)", 0), ("os.mkdir(sys.argv[1] + '/x-done'); time.sleep(1)", 1)])
def test_the_command_tells_what_is_done_and_goes_on_when_helpers_die(monkeypatch, program, told):
    heard, command = [], [sys.executable, "-c", f"import os, sys, time\n{program}"]
    monkeypatch.setattr(compiling.os, "sched_getaffinity", lambda _: {0}, raising=False)
    monkeypatch.setattr(compiling, "_start", lambda folder: subprocess.Popen([*command, folder]))
    compiling.share_compiling(heard.append)
    assert len(heard) == told
