"""The volume of the sound: controllers enter, one gain for the whole guitar leaves, moved without a step.

One guitar has one volume: the last value of any channel counts. Volume, expression and master volume multiply; each is
40 log10(v / v0) dB, the square of v / v0 (General MIDI 2 and the DLS specification), with 0 dB at what a file begins
with. The gain goes straight from one value to the next, sample by sample, and is there when a note that was sent
together with it is let go.
"""

from ukrt.engine import layout
from ukrt.engine import player_layout as at
from ukrt.engine.kernels.jit import kernel


@kernel
def _square(value, full):
    return (value / full) * (value / full)


@kernel
def set_volume(d, i, which, value):
    """One of I_VOLUME, I_EXPRESSION and I_MASTER_VOLUME has a new value."""
    i[which] = value
    goal = _square(i[at.I_VOLUME], at.FULL_VOLUME) * _square(i[at.I_EXPRESSION], at.FULL_EXPRESSION)
    goal *= _square(i[at.I_MASTER_VOLUME], at.FULL_MASTER)
    if goal != d[at.D_LEVEL_GOAL]:
        d[at.D_LEVEL_GOAL] = goal
        begin_ramp(d, i, i[at.I_LEVEL_RAMP])


@kernel
def begin_ramp(d, i, frames):
    """From the gain that is now to the one that is wanted in ``frames`` (1 or more)."""
    i[at.I_LEVEL_LEFT] = frames
    d[at.D_LEVEL_STEP] = (d[at.D_LEVEL_GOAL] - d[at.D_LEVEL]) / frames


@kernel
def full_volume(d, i):
    """Everything at 0 dB, as at power-up."""
    i[at.I_VOLUME], i[at.I_EXPRESSION] = at.FULL_VOLUME, at.FULL_EXPRESSION
    set_volume(d, i, at.I_MASTER_VOLUME, at.FULL_MASTER)


@kernel
def apply_level(d, i, n):
    """Scale the ``n`` frames of pressure just computed; a gain of exactly 1 leaves them as they are."""
    left, level = i[at.I_LEVEL_LEFT], d[at.D_LEVEL]
    if left == 0 and level == 1.0:
        return
    for k in range(n):
        if left > 0:
            left -= 1
            level = d[at.D_LEVEL_GOAL] if left == 0 else level + d[at.D_LEVEL_STEP]
        d[layout.PRESSURE + k] *= level
        d[layout.PRESSURE + layout.CHUNK + k] *= level
    i[at.I_LEVEL_LEFT], d[at.D_LEVEL] = left, level
