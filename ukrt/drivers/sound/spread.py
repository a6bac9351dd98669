"""Cards with another number of channels than the guitar has: an engine enters, what such a card can call leaves."""

import numpy as np

from ukrt.engine.kernels.spread import (
    T_CARD_CHANNELS,
    T_CHANNELS,
    T_FUNCTION,
    T_SCRATCH,
    T_SCRATCH_FRAMES,
    T_USERDATA,
    WORDS,
    spread,
)

_SCRATCH_FRAMES = 8192  # computed at once; larger blocks come in several


class Spread:
    """An engine as a card of ``channels`` channels sees it.

    Parameters
    ----------
    engine : Engine or Attached
        Of one or two channels.
    channels : int
        The card's.
    """

    def __init__(self, engine, channels):
        self.channels = channels
        self._engine = engine
        self._scratch = np.zeros(_SCRATCH_FRAMES * engine.channels, np.float32)
        self._table = np.zeros(WORDS, np.int64)
        self._table[T_FUNCTION], self._table[T_USERDATA] = engine.callback_address, engine.userdata_address
        self._table[T_CHANNELS], self._table[T_CARD_CHANNELS] = engine.channels, channels
        self._table[T_SCRATCH], self._table[T_SCRATCH_FRAMES] = self._scratch.ctypes.data, _SCRATCH_FRAMES

    @property
    def callback_address(self):
        """Address of the C function with PortAudio's callback signature (int)."""
        return spread.address

    @property
    def userdata_address(self):
        """The callback's user data (int); valid while this object lives."""
        return self._table.ctypes.data
