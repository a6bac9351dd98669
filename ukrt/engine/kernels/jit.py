"""How every compiled function of the instrument is compiled: one decorator for kernels, one for C functions.

Enters Python source, leaves nopython code without exceptions. Numba's own cache looks only at the file a function
stands in, not at the files of the functions it calls; therefore the cache folder (`kernel_cache`) is named after a hash
of all kernel sources.
"""

import contextlib

import numba
from numba.core import config as numba_config

from ukrt.engine.kernel_cache import cache_folder
from ukrt.engine.kernels.linking import Kernel, Parts, Wholes

_OPTIONS = {"nopython": True, "error_model": "numpy", "boundscheck": False, "cache": True}
_UNCACHED = {**_OPTIONS, "cache": False}


@contextlib.contextmanager
def _our_cache():
    """Point Numba's cache at our folder while a function of ours is decorated, and leave other packages' alone."""
    before = numba_config.CACHE_DIR
    numba_config.CACHE_DIR = _FOLDER
    try:
        yield
    finally:
        numba_config.CACHE_DIR = before


_FOLDER = cache_folder()


def kernel(function):
    """Compile ``function`` strictly: no reassociation, so that the same code gives the same bits."""
    if numba_config.DISABLE_JIT:
        return function
    part = numba.jit(pipeline_class=Parts, **_UNCACHED)(function)
    with _our_cache():
        return Kernel(part, numba.jit(pipeline_class=Wholes, **_OPTIONS)(function))


def inlined(function):
    """A kernel that stands in those that call it; for what is called from one place."""
    return numba.jit(inline="always", **_UNCACHED)(function)


def entry_point(signature):
    """Compile to a C function of ``signature`` (a ``numba.cfunc``), to be called by hosts without the interpreter."""

    def decorate(function):
        with _our_cache():
            return numba.cfunc(signature, pipeline_class=Wholes, **_OPTIONS)(function)

    return decorate
