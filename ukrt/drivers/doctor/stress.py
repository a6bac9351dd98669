"""Work that disturbs a Python process, to be done beside sound: a name and a duration enter, nothing leaves.

Each stress runs in the calling thread until its time is over. Whoever plays from Python code suffers from all but the
first; compiled code that needs no interpreter should notice none.
"""

import ctypes
import gc
import sys
import time

HOLD_SECONDS = 0.02  # for which the interpreter's lock is kept in C without a pause
_GRAPH_NODES = 200_000  # objects that refer to each other in rings, which only the collector can free: tens of MB
_STEPS = 20_000  # of arithmetic between two looks at the clock: about a millisecond

WORDS = {
    "none": "Python idle",
    "python": "Python computing",
    "gc": "Python collecting garbage",
    "gil": f"C code holding Python's lock for {1e3 * HOLD_SECONDS:.0f} ms at a time",
}


def run_stress(name, seconds):
    """Do the work called ``name`` (a key of `WORDS`) for ``seconds`` [s]."""
    ends = time.monotonic() + seconds
    {"none": _idle, "python": _compute, "gc": _collect, "gil": _hold}[name](ends)


def _idle(ends):
    time.sleep(max(0.0, ends - time.monotonic()))


def _compute(ends):
    total = 0
    while time.monotonic() < ends:
        for k in range(_STEPS):
            total += k * k % 7
    return total


def _collect(ends):
    graph = []
    while time.monotonic() < ends:
        graph.clear()
        for k in range(_GRAPH_NODES):
            node = [k, {"owner": graph}]
            node.append(node)
            graph.append(node)
            if k % 10_000 == 0 and time.monotonic() >= ends:
                break
        gc.collect()
    graph.clear()
    gc.collect()


def _hold(ends):
    pause, unit = _sleep_in_c()
    length = int(HOLD_SECONDS / unit)
    while time.monotonic() < ends:
        pause(length)


def _sleep_in_c():
    """A C function that sleeps without letting go of the interpreter's lock, and the unit of its argument [s]."""
    if sys.platform == "win32":
        return ctypes.PyDLL("kernel32").Sleep, 1e-3
    return ctypes.PyDLL(None).usleep, 1e-6
