"""Several processes share the compiling before the first sound.

What has to be compiled comes in shares, which write into the cache of compiled code and need nothing of each other. The
command starts helpers, ``python -m ukrt.cli.compiling FOLDER``; it and they take share after share, each by making a
folder of its name, which only one of them can. Whole files are left in the cache, whoever is ended when; what is
missing, the command makes itself.
"""

import atexit
import importlib
import os
import pathlib
import subprocess
import sys
import tempfile

_ROOT = pathlib.Path(__file__).resolve().parents[2]
_KERNELS = "ukrt.engine.kernels."
# In this order: what takes longest comes first.
SHARES = ("callback", "play", "take_over", "instance", "drivers")
_HELPERS = 2  # more would wait for the callback, which is one share


def share_compiling():
    """Compile the engine with a helper on every other core that is of use."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    with tempfile.TemporaryDirectory(prefix="ukrt-") as folder:
        helpers = [_start(folder) for _ in range(min(cores - 1, _HELPERS))]
        work_through(folder)
        for process in helpers:
            process.wait()


def _start(folder):
    """A helper; it ends with this process at the latest."""
    paths = [str(_ROOT), os.environ.get("PYTHONPATH")]
    process = subprocess.Popen(
        [sys.executable, "-P", "-m", "ukrt.cli.compiling", folder],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, paths))},
    )
    atexit.register(_end, process)
    return process


def _end(process):
    process.kill()  # files in the cache are written elsewhere and renamed
    process.wait()


def work_through(folder):
    """Compile one share after the other that nobody else has taken; ``folder`` keeps who has."""
    for share in SHARES:
        try:
            os.mkdir(os.path.join(folder, share))
        except FileExistsError:
            continue
        compile_share(share)


def compile_share(share):
    """Call or import what belongs to ``share``."""
    if share == "instance":
        _compile_instance()
    elif share == "drivers":
        for name in ("idle", "jack", "jack_notices", "spread"):
            importlib.import_module(_KERNELS + name)
    else:
        importlib.import_module(_KERNELS + share)


def _compile_instance():
    """What Python calls to prepare an engine."""
    from ..engine.instance import Instance
    from ..engine.kernels.energy import total_energy
    from ..engine.kernels.machine import ticks_now
    from ..engine.kernels.queue import lane_push
    from ..engine.stage import Stage
    from ..model.presets import load_preset

    instance, stage = Instance(load_preset("classical"), 48000.0), Stage(2)
    total_energy(instance.d, instance.i)
    lane_push(stage.si, 0, 0, 0)
    ticks_now()


if __name__ == "__main__":
    work_through(sys.argv[1])
