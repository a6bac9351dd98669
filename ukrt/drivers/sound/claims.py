"""One host at a time: an engine and an output that is about to call it enter; a second one is refused.

Two threads inside one engine would tear its state apart without a word. The register is this process's own; outputs in
child processes are claimed by the object that stands for them here.
"""

import threading
import weakref

from ukrt.errors import DeviceError

_HOLDERS = weakref.WeakKeyDictionary()  # engine -> weak reference to the output that calls it
_LOCK = threading.Lock()


def claim(engine, output):
    """Let ``output`` be the one that calls ``engine``; raises `DeviceError` while another one is."""
    with _LOCK:
        holder = _HOLDERS.get(engine, lambda: None)()
        if holder is not None and holder is not output:
            raise DeviceError(f"{output.name} cannot play a guitar that {holder.name} is playing; close that one first")
        _HOLDERS[engine] = weakref.ref(output)


def release(engine, output):
    """``output`` calls ``engine`` no more."""
    with _LOCK:
        if _HOLDERS.get(engine, lambda: None)() is output:
            del _HOLDERS[engine]
