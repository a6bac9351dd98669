"""Named arrays in one piece of memory, private or shared between processes: sizes enter, aligned arrays leave.

A block that is shared is described by its manifest (plain data, fit for JSON), from which another process attaches it.
"""

import contextlib
from multiprocessing import shared_memory

import numpy as np

from ukrt.engine.shared import attach_shared

_LINE = 64  # bytes: every array starts on a cache line of its own


class Block:
    """Arrays side by side in one piece of memory, zero at first.

    Parameters
    ----------
    sizes : dict of str to (dtype, int)
        Type and length of each array by its name.
    shared : bool
        Whether other processes shall be able to attach it.

    Attributes
    ----------
    arrays : dict of str to ndarray (1-D)
        Each on a 64-byte boundary.
    """

    def __init__(self, sizes, shared=False):
        places, end = {}, 0
        for name, (kind, length) in sizes.items():
            kind = np.dtype(kind)
            places[name] = [kind.name, end, int(length)]
            end += -(-kind.itemsize * int(length) // _LINE) * _LINE
        self._owner = True
        self._memory = shared_memory.SharedMemory(create=True, size=max(end, _LINE)) if shared else None
        self._open(places, self._memory.buf if shared else _private(end))

    @classmethod
    def attach(cls, manifest):
        """The block that ``manifest`` (of another process) describes; its end there does not remove it."""
        block = cls.__new__(cls)
        block._owner = False
        block._memory = attach_shared(manifest["name"])
        block._open(manifest["arrays"], block._memory.buf)
        return block

    def _open(self, places, buffer):
        self._places = places
        self.arrays = {
            name: np.frombuffer(buffer, kind, length, offset) for name, (kind, offset, length) in places.items()
        }

    def manifest(self):
        """What another process needs to attach the block (dict); only of a shared one."""
        if self._memory is None:
            raise ValueError("a private block has no manifest")
        return {"name": self._memory.name, "arrays": self._places}

    def close(self):
        """Give shared memory back; who made it removes it. The arrays remain as private copies, to be read."""
        if self._memory is None:
            return
        memory, self._memory = self._memory, None
        self.arrays = {name: array.copy() for name, array in self.arrays.items()}
        try:
            memory.close()
        except BufferError:  # somebody still holds an array: the memory goes with the last of them
            memory._buf = memory._mmap = None
            memory.close()
        if self._owner:
            with contextlib.suppress(FileNotFoundError):
                memory.unlink()


def _private(size):
    """``size`` zero bytes from a 64-byte boundary, as a memoryview."""
    raw = np.zeros(size + 2 * _LINE, np.uint8)
    skip = -raw.ctypes.data % _LINE
    return memoryview(raw[skip : skip + max(size, _LINE)])
