"""Lines of JSON through a pipe without ever waiting for its reader: a stopped parent must not stop MIDI."""

import json
import os

_MOST_BYTES = 1 << 18  # kept while the reader does not read; lines beyond that are dropped, oldest kept


class Talk:
    """The writing end.

    Parameters
    ----------
    descriptor : int
        File descriptor of the pipe, which no longer blocks from now on (on Windows from Python 3.12).
    """

    def __init__(self, descriptor):
        self._descriptor, self._waiting = descriptor, bytearray()
        try:
            os.set_blocking(descriptor, False)
        except (OSError, AttributeError):
            pass

    def say(self, what):
        """Send a dict, now or with a later one."""
        line = json.dumps(what).encode() + b"\n"
        if len(self._waiting) + len(line) <= _MOST_BYTES:
            self._waiting += line
        self.flush()

    def flush(self):
        """Send what the pipe takes of what is waiting."""
        try:
            while self._waiting:
                del self._waiting[: os.write(self._descriptor, self._waiting)]
        except BlockingIOError:
            pass
        except OSError:  # the reader is gone, and this process soon as well
            self._waiting.clear()
