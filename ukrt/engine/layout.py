"""Where every number of an instance lives: offsets into the flat arrays ``d`` (float64) and ``i`` (int64).

This is the one place that knows offsets. They are plain module-level integers, so Numba freezes them into the compiled
code; capacities are fixed, so that a host can allocate an instance from these numbers alone.

The modes of all strings stand in tiles of four: a state tile is ``D x[k]`` (4 Y, 4 Z) then ``x*[k+1]`` (4 Y, 4 Z); a
coefficient tile is ``a b/D D`` then up to seven port columns, four modes each, shared by both polarizations. A string's
last two tiles are its pseudo-modes, which have no D: there ``x[k]`` and ``b`` stand (kernels/motion.py).
"""

# Capacities ----------------------------------------------------------------------------------------------------------
MAX_STRINGS = 12
LANES = 16  # strings, padded to whole vectors of eight
MAX_CONTACTS = 5  # per string: fingers and dampers together
PORTS = 1 + MAX_CONTACTS  # bridge first, then contacts: rows of A of one string and polarization
COLUMNS = PORTS + 1  # and one more for the pluck
RESIDUAL_MODES = 8  # pseudo-modes that stand for what the basis cuts, one a port
MAX_TILES = 2048  # 8192 modes and pseudo-modes over all strings
MAX_BODY_MODES = 64
MAX_GESTURES = 512
CHUNK = 64  # frames between two absolute multiples of which nothing outside is looked at

# Tiles ---------------------------------------------------------------------------------------------------------------
TILE = 4  # modes
STATE_TILE = 16  # doubles
PSEUDO_TILES = RESIDUAL_MODES // TILE  # a string's last ones
COEF_A, COEF_BACK, COEF_D, COEF_COLUMNS = 0, 4, 8, 12  # then COLUMNS port columns, the bridge first
MATCHES = 2
COEF_TILE = 40  # five cache lines, nothing that the sweep does not want: a 10 kHz basis stays in the first cache
ERROR_TILE = 16  # the step's error of four modes at the matching frequencies: MATCHES x (real, loss), see residual.py


def _sections(start, sizes):
    """Lay ``sizes`` (name -> length) one after another, each on a 64-byte boundary; returns offsets and the end."""
    offsets, at = {}, start
    for name, size in sizes.items():
        offsets[name] = at
        at += -(-size // 8) * 8
    return offsets, at


# Sums over a string's modes, kept as vectors of eight (4 Y, 4 Z) until the solver adds them up -----------------------
SUM_HH = 2 * COLUMNS  # sum (D x)^2
SUM_HX = SUM_HH + 1  # sum (D x) x*
SUMS = SUM_HX + 1  # before them: 2 j = sum column_j x*, 2 j + 1 = sum column_j D x
ACC_STRIDE = 8 * LANES

# Residual tables: functions of a distance on [0, L], see ports.py ----------------------------------------------------
TABLE = 2049
TABLES = 1 + 2 * MATCHES  # static; real part and loss at each matching frequency

# One string's own numbers --------------------------------------------------------------------------------------------
STRING_D_SIZE = 256
(
    S_LENGTH, S_TENSION, S_DENSITY, S_STIFFNESS, S_LOSS_INTERNAL, S_LOSS_AIR, S_LOSS_BENDING, S_BANDWIDTH,
    S_RATIO, S_RATIO_FROM, S_RATIO_TO, S_PLUCK_FY, S_PLUCK_FZ, S_PLUCK_PLACE, S_FINGER_PLACE, S_MOVE_FROM, S_MOVE_TO,
    S_DAMP_LEVEL, S_DAMP_FROM, S_DAMP_TO, S_PLUCK_Y, S_PLUCK_Z, S_IMPEDANCE, S_MATCH_1, S_MATCH_2, S_HUSH,
    S_HAMMER, S_PULL_Y, S_PULL_Z, S_TOUCH_PLACE,
) = range(30)  # fmt: skip
# S_HUSH: loss [1/s] on top of the string's own while it is put to sleep, else 0; S_HAMMER: speed [m/s] of the finger
# that landed last; S_PULL_*: how far [m] the finger that is about to let go draws the string aside; S_TOUCH_PLACE:
# share of L where a touch stands in the damper's stead, 0: the damper is the preset's
S_PORT_X = 32  # places of the ports, bridge first, pluck last: COLUMNS
S_LAND_C = 40  # landing offsets of the finger's contacts, Y then Z
S_LAND_V = 56  # and the string's velocities there when the finger touched
S_W = 72  # A G A^T of one polarization without the fingers' own part: PORTS x PORTS
S_PLUCK_W = 112  # A G phi at the pluck: PORTS
S_PSEUDO = 120  # which column of C each pseudo-mode carries, and by how much: RESIDUAL_MODES each
S_PSEUDO_WEIGHT = 128
S_PSEUDO_AXES = 192  # the axes that C is turned to: eight rows of eight

STRING_I_SIZE = 32
(
    SI_TILE, SI_TILES, SI_END, SI_EXTRA, SI_MODES, SI_FINGER, SI_DAMPER, SI_PLUCK, SI_PLUCK_AT, SI_PLUCK_LENGTH,
    SI_LAND_AT, SI_LAND_LENGTH, SI_MOVE_AT, SI_MOVE_LENGTH, SI_DAMP_AT, SI_DAMP_LENGTH, SI_TENSION_AT,
    SI_TENSION_LENGTH, SI_CHANGED, SI_PORTS, SI_LIFT_AT, SI_LIFT_LENGTH, SI_SLEEP, SI_LOOKS, SI_FINGER_FROM,
    SI_DAMPER_FROM, SI_TENSION_STRAIGHT, SI_PLUCK_RELEASE, SI_RELEASE, SI_PLUCK_SMOOTH,
) = range(30)  # fmt: skip
# SI_PLUCK_RELEASE: frames in which the present pluck lets go, SI_RELEASE: and those to come; SI_PLUCK_SMOOTH: its force
# rises along half a cosine
# SI_SLEEP: AWAKE, HUSHED since frame SI_LOOKS, or ASLEEP; SI_*_FROM: which of the preset's contacts is its first
AWAKE, HUSHED, ASLEEP = range(3)

# One kind of contact of the preset's finger: exact flow of (m, c, k), or a rigid point, or a pure damper -------------
CONTACT_SIZE = 8
# The offset of a damper is its place / L, C_DAMPER its resistance / sqrt(T mu).
C_OFFSET, C_A, C_B, C_G, C_DAMPER = range(5)

PLAYER_D_SIZE = 32768
PLAYER_I_SIZE = 180224

_D, D_SIZE = _sections(
    0,
    {
        "STATE": MAX_TILES * STATE_TILE,
        "COEF": MAX_TILES * COEF_TILE,
        "ERROR": MAX_TILES * ERROR_TILE,
        "ACC": SUMS * ACC_STRIDE,
        "V": PORTS * PORTS * LANES,  # (A G A^T)^-1 of each string
        "LAM_Y": COLUMNS * LANES,
        "LAM_Z": COLUMNS * LANES,
        "MU": LANES,  # minus the tension of Kirchhoff-Carrier [N]
        "PSI": LANES,  # sum kappa q[k] q[k-1] [m^2/m]
        "SIGMA": LANES,  # 4 L / ES
        "XI": LANES,  # the string's place on the bridge, 0 bass .. 1 treble
        "LAND_Y": PORTS * LANES,  # landing offset d[k+1] of each contact
        "LAND_Z": PORTS * LANES,
        "FIN_Y": PORTS * LANES,  # q_f[k]
        "FIN_Z": PORTS * LANES,
        "FIN_Y1": PORTS * LANES,  # q_f*[k+1]
        "FIN_Z1": PORTS * LANES,
        "FIN_A": PORTS * LANES,
        "FIN_B": PORTS * LANES,
        "FIN_G": PORTS * LANES,
        "SLIDE": MAX_TILES * 4 * COLUMNS,  # change of each column per sample while a finger slides
        "PAIR": 8,  # the strings' force on the bridge, and its moment about the bass end
        "BODY_X": MAX_BODY_MODES,
        "BODY_XS": MAX_BODY_MODES,
        "BODY_A": MAX_BODY_MODES,
        "BODY_B": MAX_BODY_MODES,
        "BODY_BASS": MAX_BODY_MODES,
        "BODY_SLOPE": MAX_BODY_MODES,  # treble minus bass
        "BODY_W": 8,  # sums of column products bass-bass, bass-slope, slope-slope; then z*[k+1] of bass and slope
        "STRING": MAX_STRINGS * STRING_D_SIZE,
        "TABLES_AT": MAX_STRINGS * TABLES * TABLE,
        "CONTACTS": 2 * MAX_CONTACTS * CONTACT_SIZE,  # the finger's, then the damper's
        "SCRATCH": 4096,
        "BRIDGE": 2 * CHUNK,  # force on the body at the bass end, then the treble end [N]
        "STRINGS_OUT": CHUNK * LANES,  # each string's force on the body [N], sample by sample
        "PRESSURE": 2 * CHUNK,
        "GESTURES": MAX_GESTURES * 5,
        "METER": 8,
        "PLAYER_D": PLAYER_D_SIZE,
    },
)
_I, I_SIZE = _sections(
    0,
    {
        "HEAD": 64,
        "STRING_I": MAX_STRINGS * STRING_I_SIZE,
        "GESTURES_I": MAX_GESTURES * 3,  # frame, kind, string
        "PLAYER_I": PLAYER_I_SIZE,
    },
)
globals().update(_D)
globals().update(_I)

# HEAD ----------------------------------------------------------------------------------------------------------------
(
    H_STRINGS, H_PORTS, H_BODY, H_SIGNAL, H_CHANNELS, H_CONVOLVE, H_BUSY, H_GESTURES, H_GESTURES_DONE,
    H_GESTURES_DROPPED, H_FINGER, H_DAMPER, H_SHED, H_SMOOTH,
) = range(14)  # fmt: skip
# H_SHED: how much is shed, 0 (nothing) to 3, see kernels/shed.py; H_SMOOTH: 1 if plucks rise along half a cosine

# METER (in d) --------------------------------------------------------------------------------------------------------
M_RATE, M_GAIN = range(2)  # frames per second; gain of what goes to a sound card
SIGNAL_PRESSURE, SIGNAL_FORCE, SIGNAL_STRINGS = range(3)
