"""Where every number of an instance lives: offsets into the flat arrays ``d`` (float64) and ``i`` (int64).

This is the one place that knows offsets. They are plain module-level integers, so Numba freezes them into the compiled
code; capacities are fixed, so that a host can allocate an instance from these numbers alone.

The modes of all strings stand in tiles of four: a state tile is ``x[k]`` (4 Y, 4 Z) then ``x*[k+1]`` (4 Y, 4 Z); a
coefficient tile is ``a b D g0`` then up to seven port columns, four modes each, shared by both polarizations.
"""

MAGIC = 0x756B7274  # "ukrt"
VERSION = 1

# Capacities --------------------------------------------------------------------------------------------------------
MAX_STRINGS = 12
LANES = 16  # strings, padded to whole vectors of eight
MAX_CONTACTS = 5  # per string: fingers and dampers together
PORTS = 1 + MAX_CONTACTS  # bridge first, then contacts: rows of A of one string and polarization
COLUMNS = PORTS + 1  # and one more for the pluck
RESIDUAL_MODES = 8  # pseudo-modes that stand for what the basis cuts (one a port, two tiles)
MAX_TILES = 2048  # 8192 modes and pseudo-modes over all strings
MAX_BODY_MODES = 64
MAX_GESTURES = 512
MIDI_QUEUE = 16384  # messages
CHUNK = 64  # frames between two absolute multiples of which nothing outside is looked at

# Tiles -------------------------------------------------------------------------------------------------------------
TILE = 4  # modes
STATE_TILE = 16  # doubles
COEF_A, COEF_B, COEF_D, COEF_SQRT_G, COEF_COLUMNS = 0, 4, 8, 12, 16
COEF_TILE = 48  # 4 * (4 + COLUMNS) = 44, padded to whole cache lines

# Sections of d -----------------------------------------------------------------------------------------------------


def _sections(start, sizes):
    """Lay ``sizes`` (name -> length) one after another from ``start``, each on a 64-byte boundary; returns offsets, end."""
    offsets, at = {}, start
    for name, size in sizes.items():
        offsets[name] = at
        at += -(-size // 8) * 8
    return offsets, at


PLAYER_D_SIZE = 32768
PLAYER_I_SIZE = 131072
