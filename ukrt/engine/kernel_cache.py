"""Where compiled code is kept, and what it was made of; to know that, the compiler is not needed."""

import functools
import hashlib
import os
import pathlib
from importlib.metadata import version

from platformdirs import user_cache_dir

_SOURCES = pathlib.Path(__file__).parent / "kernels"


@functools.cache
def kernel_fingerprint():
    """Hash of every source that compiled code is made of, the compiler's version included (str, 16 hex digits)."""
    digest = hashlib.sha256(f"numba {version('numba')}".encode())
    for path in sorted([*_SOURCES.glob("*.py"), *_SOURCES.parent.glob("*layout*.py"), _SOURCES.parent / "gestures.py"]):
        if path.exists():
            digest.update(path.name.encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:16]


def cache_root():
    """The folder of all that is kept (Path): ``UKRT_CACHE_DIR`` if set, else the platform's user cache."""
    return pathlib.Path(os.environ.get("UKRT_CACHE_DIR") or user_cache_dir("ukrt"))


def cache_folder():
    """The folder in it that compiled code is kept in (str)."""
    return str(cache_root() / f"kernels-{kernel_fingerprint()}")
