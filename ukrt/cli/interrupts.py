"""Ctrl-C, a request to end, a terminal that closes: signals enter; the first ends tidily, the second one at once."""

import contextlib
import os
import signal
import threading

EXIT_AT_ONCE = 130  # as a shell reports a process that Ctrl-C ended
_HURRY_SECONDS = 0.5
_SIGNALS = ("SIGINT", "SIGTERM", "SIGHUP")


class Interrupts:
    """Context manager: the first signal raises `KeyboardInterrupt`, the next one closes the files and leaves.

    Attributes
    ----------
    count : int
        Signals so far: one that came where Python cannot raise is seen here.
    hurried : list of callable
        What a second signal still does, such as closing files; half a second is given to all together.
    """

    def __init__(self):
        self.count, self.hurried = 0, []
        self._before = {}

    def __enter__(self):
        if threading.current_thread() is threading.main_thread():
            for number in (getattr(signal, name) for name in _SIGNALS if hasattr(signal, name)):
                self._before[number] = signal.signal(number, self._handle)
        return self

    def __exit__(self, *_):
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def check(self):
        """Raise for a signal that came where its exception was lost."""
        if self.count:
            raise KeyboardInterrupt

    def _handle(self, _number, _frame):
        self.count += 1
        if self.count == 1:
            raise KeyboardInterrupt
        closing = threading.Thread(target=self._hurry, daemon=True)
        closing.start()
        closing.join(_HURRY_SECONDS)  # whoever was interrupted may hold what closing needs
        os._exit(EXIT_AT_ONCE)

    def _hurry(self):
        for step in self.hurried:
            with contextlib.suppress(Exception):
                step()
