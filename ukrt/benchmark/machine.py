"""The machine that is measured: which processor it has, and one of its cores for the time being."""

import contextlib
import os
import platform
import time


@contextlib.contextmanager
def one_core():
    """Keep this process on the core that has least to do, where the system can; gives the core's number or None."""
    if not hasattr(os, "sched_setaffinity"):
        yield None
        return
    before = os.sched_getaffinity(0)
    first = _idle_ticks()
    time.sleep(0.3)
    last = _idle_ticks()
    core = max(before, key=lambda number: (last.get(number, 0) - first.get(number, 0), number))
    os.sched_setaffinity(0, {core})
    try:
        yield core
    finally:
        os.sched_setaffinity(0, before)


def _idle_ticks():
    """Idle time of each core so far (dict of int); empty where the system does not tell."""
    with contextlib.suppress(OSError), open("/proc/stat", encoding="ascii") as lines:
        rows = [line.split() for line in lines if line.startswith("cpu") and line[3].isdigit()]
        return {int(row[0][3:]): int(row[4]) for row in rows}
    return {}


def processor_name():
    """What the processor calls itself (str)."""
    with contextlib.suppress(OSError), open("/proc/cpuinfo", encoding="utf-8") as lines:
        for line in lines:
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def describe_machine(core):
    """What a report says of the machine (dict)."""
    import numba

    return {
        "processor": processor_name(),
        "core": core,
        "python": platform.python_version(),
        "numba": numba.__version__,
    }
