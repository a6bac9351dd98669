"""What the instrument leaves out when the machine is too slow: the level enters, less work leaves, no note is lost.

Each level includes those below it; the level changes between two samples and everything else follows from frames
alone, so that a take that notes when it changed gives the same bits again.

1  strings that are nearly silent sleep (sleep.py) until a hand touches them or the level is 0 again
2  ... and so do strings that only ring along with others; the response's tail is not heard (convolve.py)
3  ... louder ones too; fingers and dampers that come down have one contact (hands.py)
"""

import numpy as np

from ukrt.engine import layout as at
from ukrt.engine.kernels.convolve import convolver_shed
from ukrt.engine.kernels.energy import string_energy
from ukrt.engine.kernels.jit import kernel
from ukrt.engine.kernels.sleep import hush_string, sleep_string, wake_string

HIGHEST = 3
TAIL_LEVEL = 2  # from here on the convolver's last level is silent
EVERY = 4096  # frames between two looks at the strings
# A string sleeps when its energy is less than this share of the loudest string's (choices; measured: see the README).
SILENT_1, SILENT_2, SILENT_3 = 1e-7, 1e-4, 1e-3
FLOOR = 1e-12  # J; a string plucked with 1 N holds about 1e-4 J


@kernel
def set_shed(d, i, v, vi, level):
    """Shed as much as ``level`` (0 to 3) says from the next sample on; between two samples only."""
    level = min(max(level, 0), HIGHEST)
    i[at.H_SHED] = level
    convolver_shed(vi, 1 if level >= TAIL_LEVEL else 0)
    if level == 0:
        for s in range(i[at.H_STRINGS]):
            wake_string(d, i, s)
    else:
        _hush_silent(d, i, np.int64(2))  # the next look may come at once


@kernel
def tend_shed(d, i, now):
    """At absolute multiples of EVERY frames: strings that are hushed fall asleep, those now silent are hushed."""
    if i[at.H_SHED] == 0 or now % EVERY != 0:
        return
    for s in range(i[at.H_STRINGS]):
        own_i = at.STRING_I + s * at.STRING_I_SIZE
        if i[own_i + at.SI_SLEEP] == at.HUSHED and _is_left_alone(i, s):
            i[own_i + at.SI_LOOKS] -= 1
            if i[own_i + at.SI_LOOKS] <= 0:
                sleep_string(d, i, s)
    _hush_silent(d, i, np.int64(1))  # a variable to the compiler, which would make a function for each constant


@kernel
def _is_left_alone(i, s):
    """Whether no hand does anything to string ``s``, nor is about to."""
    own_i = at.STRING_I + s * at.STRING_I_SIZE
    busy = i[own_i + at.SI_PLUCK] + i[own_i + at.SI_LAND_LENGTH] + i[own_i + at.SI_MOVE_LENGTH]
    busy += i[own_i + at.SI_LIFT_LENGTH] + i[own_i + at.SI_DAMP_LENGTH] + i[own_i + at.SI_TENSION_LENGTH]
    busy += i[own_i + at.SI_CHANGED]
    for k in range(i[at.H_GESTURES]):
        busy += 1 if i[at.GESTURES_I + 3 * k + 2] == s else 0
    return busy == 0


@kernel
def _hush_silent(d, i, looks):
    """Strings as good as silent sleep at once; the others below the level's share are hushed first."""
    level, loudest = i[at.H_SHED], 0.0
    for s in range(i[at.H_STRINGS]):
        if i[at.STRING_I + s * at.STRING_I_SIZE + at.SI_SLEEP] == at.AWAKE:
            loudest = max(loudest, string_energy(d, i, s))
    share = SILENT_1 if level == 1 else (SILENT_2 if level == 2 else SILENT_3)
    for s in range(i[at.H_STRINGS]):
        if i[at.STRING_I + s * at.STRING_I_SIZE + at.SI_SLEEP] == at.AWAKE and _is_left_alone(i, s):
            energy = string_energy(d, i, s)
            if energy < max(SILENT_1 * loudest, FLOOR):
                sleep_string(d, i, s)
            elif energy < share * loudest:
                hush_string(d, i, s, looks)
