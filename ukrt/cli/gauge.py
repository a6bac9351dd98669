"""Measuring a session from outside: an engine and what plays on it are looked at, moments for the status line leave.

Loads are those of the last seconds, as somebody who turns a knob wants to see them; all else counts from the start.
"""

import collections
import time

from ..drivers.live.watch import load_quantile
from ..engine import player_layout as player
from .status import Moment

WINDOW_SECONDS = 5.0  # what "load now" means
_RATE_SECONDS = 1.0  # what "messages a second" means
_TROUBLE_SECONDS = 3.0  # for so long a new interruption is shown in red


def held_strings(engine):
    """How many strings a key or a pedal holds now (int)."""
    i = engine.instance.i
    states = i[player.S_STATE : player.S_STATE + i[player.I_STRINGS]]
    return int(((states == player.HELD) | (states == player.PEDALLED)).sum())


class Gauge:
    """Looks at an engine again and again.

    Parameters
    ----------
    engine : Engine
    now : callable
        The computer's clock [s].
    """

    def __init__(self, engine, now=time.monotonic):
        self._engine, self._now = engine, now
        self._began = now()
        self._loads = collections.deque()  # (time, {load: blocks}) about once a second
        self._messages = collections.deque()
        self._trouble, self._trouble_at = None, -_TROUBLE_SECONDS

    def moment(self, state):
        """The `Moment` that is now.

        Parameters
        ----------
        state : dict
            `LiveSession.state()`, as fresh.
        """
        now, counters = self._now(), self._engine.counters()
        missing = round(state["missing_frames"] / max(state["block_size"], 1))
        trouble = (state["xruns"], state["late_blocks"], missing)
        if self._trouble is not None and trouble != self._trouble:
            self._trouble_at = now
        self._trouble = trouble
        return Moment(
            seconds=state["seconds"],
            output=state["output"],
            rate_hz=state["sample_rate"],
            block=state["block_size"],
            loads=self._recent_loads(now, counters["load_histogram"]),
            xruns=state["xruns"],
            late=state["late_blocks"],
            missing=missing,
            messages_per_s=self._message_rate(now, counters["midi_received"]),
            notes=held_strings(self._engine),
            peak_db=-200.0 if state["peak_db"] is None else state["peak_db"],
            limiter_db=min(state["limiter_db"], 0.0),
            shed=state["shed_level"],
            trouble=now - self._trouble_at < _TROUBLE_SECONDS,
        )

    def _recent_loads(self, now, histogram):
        blocks = dict(histogram)
        if not self._loads or now - self._loads[-1][0] >= 1.0:
            self._loads.append((now, blocks))
        while len(self._loads) > 1 and now - self._loads[1][0] >= WINDOW_SECONDS:
            self._loads.popleft()
        before = self._loads[0][1] if now - self._began > WINDOW_SECONDS else {}
        recent = [(load, n - before.get(load, 0)) for load, n in histogram if n > before.get(load, 0)]
        loads = tuple(load_quantile(recent, share) for share in (0.5, 0.99, 1.0))
        return None if loads[0] is None else loads

    def _message_rate(self, now, count):
        while len(self._messages) > 1 and now - self._messages[1][0] >= _RATE_SECONDS:
            self._messages.popleft()
        self._messages.append((now, count))
        began, before = self._messages[0]
        return (count - before) / max(now - began, _RATE_SECONDS)
