"""Keeping C libraries from talking over ours: while the context is open, what they print to standard error is dropped.

ALSA and JACK print a page of complaints for each device that is absent, which on most machines is most of them; what
matters arrives as an error code and is told in one sentence.
"""

import contextlib
import os
import sys


@contextlib.contextmanager
def quiet_stderr():
    """Send file descriptor 2 to nowhere for a moment (of the whole process: keep the moment short)."""
    try:
        sys.stderr.flush()
        saved = os.dup(2)
    except (OSError, ValueError, AttributeError):  # no standard error at all, as under pythonw
        yield
        return
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 2)
        yield
    finally:
        os.dup2(saved, 2)
        os.close(nowhere)
        os.close(saved)
