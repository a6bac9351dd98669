"""Shared memory of another process, without NumPy: a name enters, the memory leaves, not to be removed by this end."""

import sys
import threading

_attaching = threading.Lock()


def attach_shared(name):
    """The shared memory ``name`` of another process, which alone shall remove it (SharedMemory).

    Before Python 3.13 every process that attaches is also noted as one that removes it when it ends (CPython issue
    82300); nothing is noted while this looks.
    """
    from multiprocessing import resource_tracker, shared_memory

    if sys.version_info >= (3, 13):
        return shared_memory.SharedMemory(name, track=False)
    with _attaching:
        register, resource_tracker.register = resource_tracker.register, lambda *_: None
        try:
            return shared_memory.SharedMemory(name)
        finally:
            resource_tracker.register = register
