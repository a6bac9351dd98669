"""One guitar at one sample rate, as arrays that compiled code advances: a preset enters, an instance at rest leaves."""

import numpy as np

from ukrt.engine import layout as at
from ukrt.engine.compiled import convolver_reset, player_reset
from ukrt.engine.convolver import convolver_prepare, convolver_size
from ukrt.engine.discretize import check_rate, fill_instance
from ukrt.engine.memory import Block
from ukrt.engine.player_tables import make_player_tables
from ukrt.engine.solved_intonations import solved_intonation
from ukrt.errors import ParameterError
from ukrt.model.fingerboard import fingerboard
from ukrt.radiation.impulse_response import load_impulse_response
from ukrt.units import db_to_gain

SIGNALS = {"pressure": at.SIGNAL_PRESSURE, "bridge-force": at.SIGNAL_FORCE, "strings": at.SIGNAL_STRINGS}
_SILENCE = np.zeros((1, 2, 2))


class Instance:
    """The arrays of one guitar at one sample rate.

    Parameters
    ----------
    guitar : ukrt.model.parameters.Guitar
    sample_rate : float [Hz]
        From 44100 to 192000.
    signal : {"pressure", "bridge-force", "strings"}
    impulse_response : ukrt.radiation.impulse_response.ImpulseResponse, optional
        Instead of the one that the guitar names.
    shared : bool
        Whether other processes shall be able to run it.

    Attributes
    ----------
    d, v : ndarray of float64
    i, vi : ndarray of int64
        Modes, player and timeline; the convolver's.
    channels, lead_frames, response_frames : int

    Raises
    ------
    ParameterError
        A value out of range.
    ImpulseResponseError
        An impulse response that cannot be used.
    """

    def __init__(self, guitar, sample_rate, signal="pressure", impulse_response=None, shared=False):
        if signal not in SIGNALS:
            raise ParameterError("signal", signal, f"it must be one of {', '.join(SIGNALS)}")
        check_rate(sample_rate, guitar)
        self.guitar, self.sample_rate, self.signal = guitar, float(sample_rate), signal
        self.channels = {"pressure": 2, "bridge-force": 1, "strings": len(guitar.strings)}[signal]
        self.intonation = solved_intonation(guitar)
        response = _SILENCE
        if signal == "pressure":
            impulse_response = impulse_response or load_impulse_response(
                guitar.radiation.impulse_response, self.sample_rate
            )
            response = impulse_response.samples
        self.response_frames = len(response) if signal == "pressure" else 0
        self.lead_frames = max(1, round(guitar.pluck.duration * self.sample_rate))
        n_v, n_vi = convolver_size(len(response))
        sizes = {"d": ("f8", at.D_SIZE), "i": ("i8", at.I_SIZE), "v": ("f8", n_v), "vi": ("i8", n_vi)}
        self.block = Block(sizes, shared)
        self._look()
        convolver_prepare(response, self.v, self.vi)
        self.reset()

    def _look(self):
        self.d, self.i, self.v, self.vi = (self.block.arrays[name] for name in ("d", "i", "v", "vi"))

    def reset(self):
        """All strings at rest, no note held."""
        fill_instance(self.d, self.i, fingerboard(self.guitar).guitar, self.intonation, self.sample_rate)
        convolver_reset(self.v, self.vi)
        i = self.i
        i[at.H_SIGNAL], i[at.H_CHANNELS] = SIGNALS[self.signal], self.channels
        i[at.H_CONVOLVE] = self.signal == "pressure"
        self.d[at.METER + at.M_GAIN] = 1.0
        player_reset(self.d, i)
        make_player_tables(self.guitar, self.intonation, self.sample_rate, self.d, i)

    @property
    def preset_gain(self):
        """The preset's gain of pressure on its way to a sound card, 1 for forces [1]."""
        return db_to_gain(self.guitar.radiation.gain_db) if self.signal == "pressure" else 1.0

    @property
    def n_modes(self):
        """Modes of strings (both polarizations) and body, without the pseudo-modes (int)."""
        rows = (at.STRING_I + s * at.STRING_I_SIZE for s in range(len(self.guitar.strings)))
        return int(sum(2 * self.i[row + at.SI_MODES] for row in rows)) + len(self.guitar.body.frequencies_hz)

    def close(self):
        """Give shared memory back; what the arrays held last can still be read."""
        self.d = self.i = self.v = self.vi = None
        self.block.close()
        self._look()
