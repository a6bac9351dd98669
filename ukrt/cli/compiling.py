"""Several processes share the compiling before the first sound.

What has to be compiled comes in shares, which write into the cache of compiled code and need nothing of each other. The
command starts helpers, ``python -m ukrt.cli.compiling FOLDER``, one for each core. They take share after share, each by
making a folder of its name, which only one of them can, and the command says how many are done. Only whole files are
left in the cache, whoever is ended when; what is missing afterwards, the command makes itself.
"""

import gc
import importlib
import os
import subprocess
import sys
import tempfile
import time

from ..child_process import python_module

# In this order: what takes longest comes first.
SHARES = ("callback", "play", "take_over", "doors")
_DONE = "-done"
_LOOK_EVERY = 0.05  # s


def share_compiling(say):
    """Have the engine compiled by a helper on each core that is of use.

    Parameters
    ----------
    say : callable (str)
        Told of each share that is done.
    """
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    began, told = time.monotonic(), 0
    with tempfile.TemporaryDirectory(prefix="ukrt-") as folder:
        helpers = [_start(folder) for _ in range(min(cores, len(SHARES)))]
        try:
            while any(helper.poll() is None for helper in helpers):
                time.sleep(_LOOK_EVERY)
                done = sum(name.endswith(_DONE) for name in os.listdir(folder))
                if done > told:
                    say(f"compiled {done} of {len(SHARES)} parts after {time.monotonic() - began:.0f} s")
                    told = done
        finally:
            for helper in helpers:
                helper.kill()  # files in the cache are written elsewhere and renamed
                helper.wait()


def _start(folder):
    return subprocess.Popen(
        **python_module("ukrt.cli.compiling", folder),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )


def work_through(folder):
    """Compile one share after the other that nobody else has taken; ``folder`` keeps who has."""
    for share in SHARES:
        place = os.path.join(folder, share)
        try:
            os.mkdir(place)
        except FileExistsError:
            continue
        compile_share(share)
        os.mkdir(place + _DONE)


def compile_share(share):
    """Import a module of kernels, by which its C functions are compiled."""
    importlib.import_module(f"ukrt.engine.kernels.{share}")


if __name__ == "__main__":
    gc.disable()  # a compiler holds on to most of what it makes: looking through it takes a tenth of the time
    work_through(sys.argv[1])
    os._exit(0)  # nothing to tidy up, which would take a second
