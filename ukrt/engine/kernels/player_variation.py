"""No two plucks are the same: which finger plucks a note, and by how much that and chance change place, angle, force.

Enter a chord's notes on their strings; leave X_FINGER, and varied numbers. Chance is a hash of the preset's seed and of
the note's number, so that a piece comes out the same every time, live or not, whatever the block size.
"""

from ukrt.engine import player_layout as at
from ukrt.engine.kernels.jit import kernel

# By how much each finger differs (none, p, i, m, a): places [share of L] as the hand lies, with the thumb nearer to the
# neck; the thumb stronger than the others, the ring finger weaker [dB]. And the width of chance either way, which is
# more likely small than large (triangular). All of them are estimates.
FINGER_PLACE = (0.0, -0.008, 0.0, 0.003, 0.006)
FINGER_ANGLE = (0.0, 0.06, 0.0, 0.0, -0.03)  # rad
FINGER_FORCE = (0.0, 0.5, 0.0, 0.0, -0.7)
CHANCE_PLACE, CHANCE_ANGLE, CHANCE_FORCE = 0.008, 0.12, 1.5
_MASK = 0xFFFFFFFF


@kernel
def _mixed(x):
    """A 32-bit integer hash (multiplications by odd numbers below 2^31, so that 63 bits hold them).

    C. Wellons, "Prospecting for Hash Functions", 2018: [16 21f0aaad 15 735a2d97 15].
    """
    x ^= x >> 16
    x = (x * 0x21F0AAAD) & _MASK
    x ^= x >> 15
    x = (x * 0x735A2D97) & _MASK
    return x ^ (x >> 15)


@kernel
def chance(i, seq, which):
    """A number from -1 to 1, triangularly distributed, for question ``which`` about note ``seq``."""
    state = _mixed((_mixed(i[at.I_SEED] & _MASK) + seq) & _MASK)
    one, other = _mixed((state + 2 * which) & _MASK), _mixed((state + 2 * which + 1) & _MASK)
    return (one + other) / float(_MASK) - 1.0


@kernel
def varied_place(d, i, s, fret, place, share, seq, finger):
    """The place [share of L], kept from the left hand's finger and from the bridge as the controller's is."""
    moved = place + share * (FINGER_PLACE[finger] + CHANCE_PLACE * chance(i, seq, 0))
    stopped = d[at.D_PLACES + s * at.FRET_ROW + fret] / d[at.D_LENGTH + s]
    nearest = stopped + at.LEAST_SHARE * (1.0 - stopped)
    return min(max(moved, min(place, nearest)), max(place, at.PLACE_BRIDGE))


@kernel
def varied_angle(i, angle, share, seq, finger):
    """The angle [rad]."""
    return angle + share * (FINGER_ANGLE[finger] + CHANCE_ANGLE * chance(i, seq, 1))


@kernel
def varied_force(i, force, share, seq, finger):
    """The peak force [N]."""
    return force * 10.0 ** (share * (FINGER_FORCE[finger] + CHANCE_FORCE * chance(i, seq, 2)) / 20.0)


@kernel
def _is_plucked(i, s):
    """Whether a note of the chord is plucked on string ``s`` by a finger of its own."""
    note = i[at.X_TAKER + s]
    return note >= 0 and i[at.X_LATE + note] == at.BY_FINGER


@kernel
def _next_finger(last):
    if last == at.INDEX:
        return at.MIDDLE_FINGER
    return at.RING if last == at.MIDDLE_FINGER else at.INDEX


@kernel
def choose_fingers(i):
    """The thumb plucks the lower half of the strings; index, middle and ring finger take turns on the others.

    Of two treble strings at once neither goes to the finger that plucked last, and what follows goes to the one that
    has rested; three or more are for all three.
    """
    for note in range(i[at.G_COUNT]):
        i[at.X_FINGER + note] = at.NO_FINGER
    strings, together = i[at.I_STRINGS], 0
    for s in range(strings):
        if _is_plucked(i, s) and s < strings // 2:
            i[at.X_FINGER + i[at.X_TAKER + s]] = at.THUMB
        elif _is_plucked(i, s):
            together += 1
    if together == 0:
        return
    one = _next_finger(i[at.I_FINGER])
    other = _next_finger(one)
    finger = min(one, other) if together == 2 else one if together == 1 else at.INDEX
    for s in range(strings // 2, strings):
        if _is_plucked(i, s):
            i[at.X_FINGER + i[at.X_TAKER + s]] = finger
            finger = max(one, other) if together == 2 else min(finger + 1, at.RING)
    i[at.I_FINGER] = one if together == 1 else other if together == 2 else at.RING
