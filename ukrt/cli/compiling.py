"""A second process that shares the compiling before the first sound.

Run as ``python -m ukrt.cli.compiling`` it compiles everything beside the callback into the cache of compiled code: what
Python calls to prepare an engine, and the callbacks of the drivers. The command itself compiles the callback meanwhile
and finds the rest there. Whichever comes first leaves whole files; what is missing, the command makes itself.
"""

import atexit
import os
import pathlib
import subprocess
import sys

_ROOT = pathlib.Path(__file__).resolve().parents[2]


def share_compiling():
    """Start the second process, if there is a second core; it ends with this one at the latest."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    if cores == 1:
        return
    paths = [str(_ROOT), os.environ.get("PYTHONPATH")]
    process = subprocess.Popen(
        [sys.executable, "-P", "-m", "ukrt.cli.compiling"],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, paths))},
    )
    atexit.register(_end, process)


def _end(process):
    process.kill()  # files in the cache are written elsewhere and renamed
    process.wait()


def compile_beside():
    """Import whatever is compiled on its own, but for the callback."""
    from ..engine.kernels import doors, idle, jack, jack_notices, spread  # noqa: F401


if __name__ == "__main__":
    compile_beside()
